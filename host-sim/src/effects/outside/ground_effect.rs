//! A cushion under one side of the frame: M −= G max(θ, 0), a stiffness for nose-up alone.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "ground_effect",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "G", unit: "N m/rad", range: [0.1, 3.0], signed: false }],
    moderate_and_strong: [0.204, 0.329],
    near: &["gravity_stiffness", "cubic_stiffness", "end_stop", "trim_offset"],
    make: |values, _| Box::new(GroundEffect(values[0])),
};

#[derive(Debug)]
struct GroundEffect(f64);

impl Effect for GroundEffect {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        -self.0 * x.theta.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn it_throws_the_nose_back_and_lets_the_tail_go() {
        // half a period π √(I/G) above level, then a straight line
        let start = State { q: 0.3, q_p: 0.3, ..State::default() };
        let half = std::f64::consts::PI * (0.1705_f64 / 1.0).sqrt();
        let x = fly_freely("ground_effect", &[("G", 1.0)], start, 100).state();
        assert!((x.q + 0.3).abs() < 1e-6, "{x:?}");
        assert!((x.theta + 0.3 * (2.0 - half)).abs() < 1e-6);
    }
}
