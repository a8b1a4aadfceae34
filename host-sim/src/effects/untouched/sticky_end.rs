//! The frame rubs and clings near the ends of its travel: dry friction Mc for |θ| > θe, none between.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "sticky_end",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "Mc", unit: "N m", range: [0.03, 0.3], signed: false },
        Parameter { name: "theta_e", unit: "rad", range: [0.05, 0.15], signed: false },
    ],
    moderate_and_strong: [0.0557, 0.0653],
    near: &["coulomb_friction", "end_stop"],
    make: |values, _| Box::new(StickyEnd { level: values[0], angle: values[1] }),
};

#[derive(Debug)]
struct StickyEnd {
    level: f64,
    angle: f64,
}

impl Effect for StickyEnd {
    fn dry_friction(&self, x: &State) -> [f64; 2] {
        if x.theta.abs() > self.angle { [self.level; 2] } else { [0.0; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn a_frame_that_drifts_to_the_end_comes_to_rest_in_it() {
        // ½ I q² = Mc s: it slides s = ½ 0.1705 0.09 / 0.15 = 0.0512 rad into the end
        let start = State { q: 0.3, q_p: 0.3, ..State::default() };
        let x = fly_freely("sticky_end", &[("Mc", 0.15), ("theta_e", 0.1)], start, 60).state();
        assert_eq!(x.q, 0.0);
        // the end is found to the millisecond
        assert!((x.theta - 0.1 - 0.5 * 0.1705 * 0.09 / 0.15).abs() < 0.3 * 1e-3, "{x:?}");
    }
}
