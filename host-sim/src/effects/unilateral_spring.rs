//! A cable that only pulls, a cushion on one side: M −= k max(0, s (θ − θ0)) s. The side s is +1 for θ0 ≥ 0 (it pulls
//! back beyond θ0, above) and −1 for θ0 < 0 (below).

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "unilateral_spring",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "k", unit: "N m/rad", range: [0.1, 5.0], signed: false },
        Parameter { name: "theta_0", unit: "rad", range: [0.005, 0.1], signed: true },
    ],
    moderate_and_strong: [0.241, 0.357],
    near: &[],
    make: |values, _| Box::new(UnilateralSpring { stiffness: values[0], slack_until: values[1] }),
};

#[derive(Debug)]
struct UnilateralSpring {
    stiffness: f64,
    slack_until: f64,
}

impl Effect for UnilateralSpring {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        let side = if self.slack_until >= 0.0 { 1.0 } else { -1.0 };
        -self.stiffness * (side * (x.theta - self.slack_until)).max(0.0) * side
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn it_throws_one_side_back_and_lets_the_other_go() {
        // 0.06 rad at 0.3 rad/s to the cable, half a period π √(I/k) in it, then a straight line
        let half = std::f64::consts::PI * (0.1705_f64 / 1.0).sqrt();
        for side in [1.0, -1.0] {
            let start = State { q: 0.3 * side, q_p: 0.3 * side, ..State::default() };
            let cable = [("k", 1.0), ("theta_0", 0.06 * side)];
            let x = fly_freely("unilateral_spring", &cable, start, 100).state();
            assert!((x.q + 0.3 * side).abs() < 1e-4, "{x:?}");
            assert!((x.theta - side * (0.06 - 0.3 * (2.0 - 0.2 - half))).abs() < 1e-4, "{x:?}");
            let away = State { q: -0.3 * side, q_p: -0.3 * side, ..State::default() };
            let x = fly_freely("unilateral_spring", &cable, away, 100).state();
            assert!((x.theta + 0.6 * side).abs() < 1e-9, "{x:?}");
        }
    }
}
