//! Something pulls for a while, a snagged cable: a constant moment M from t₁ for a time, nothing before and after.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "moment_window",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "M", unit: "N m", range: [0.02, 0.25], signed: true },
        Parameter { name: "from_s", unit: "s", range: [55.0, 75.0], signed: false },
        Parameter { name: "length_s", unit: "s", range: [4.0, 15.0], signed: false },
    ],
    moderate_and_strong: [0.2, 0.235],
    near: &["trim_offset"],
    make: |values, _| {
        Box::new(MomentWindow { moment: values[0], window_s: [values[1], values[1] + values[2]] })
    },
};

#[derive(Debug)]
struct MomentWindow {
    moment: f64,
    window_s: [f64; 2],
}

impl Effect for MomentWindow {
    fn moment(&self, t: f64, _x: &State, _blade: f64) -> f64 {
        if (self.window_s[0]..self.window_s[1]).contains(&t) { self.moment } else { 0.0 }
    }

    fn window_s(&self) -> Option<[f64; 2]> {
        Some(self.window_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn it_gives_the_rate_of_its_impulse_and_no_more() {
        let pull = [("M", -0.1), ("from_s", 0.5), ("length_s", 0.4)];
        for (ticks, seconds) in [(25, 0.0), (35, 0.2), (100, 0.4)] {
            let aircraft = fly_freely("moment_window", &pull, State::default(), ticks);
            assert!((aircraft.state().q + 0.1 * seconds / 0.1705).abs() < 1e-9, "{ticks}");
        }
    }
}
