//! Something pulls from a moment on, and may let go: a load, a contact, a snagged cable. M += M0 for t0 ≤ t < t1; a t1
//! beyond the end of the test is a moment that stays.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "moment_step",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "M0", unit: "N m", range: [0.02, 0.25], signed: true },
        Parameter { name: "t0", unit: "s", range: [50.0, 70.0], signed: false },
        Parameter { name: "t1", unit: "s", range: [72.0, 90.0], signed: false },
    ],
    moderate_and_strong: [0.142, 0.22],
    near: &[],
    make: |values, _| Box::new(MomentStep { moment: values[0], window_s: [values[1], values[2]] }),
};

#[derive(Debug)]
struct MomentStep {
    moment: f64,
    window_s: [f64; 2],
}

impl Effect for MomentStep {
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
        let pull = [("M0", -0.1), ("t0", 0.5), ("t1", 0.9)];
        for (ticks, seconds) in [(25, 0.0), (35, 0.2), (100, 0.4)] {
            let aircraft = fly_freely("moment_step", &pull, State::default(), ticks);
            assert!((aircraft.state().q + 0.1 * seconds / 0.1705).abs() < 1e-9, "{ticks}");
        }
    }
}
