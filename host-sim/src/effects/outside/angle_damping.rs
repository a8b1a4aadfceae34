//! Damping that is negative near level and positive far from it, as of a loose, aerodynamically unstable
//! frame (van der Pol): M += d (1 − (θ/θ0)²) q.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "angle_damping",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "d", unit: "N m s/rad", range: [0.05, 0.6], signed: false },
        Parameter { name: "theta_0", unit: "rad", range: [0.1, 0.25], signed: false },
    ],
    moderate_and_strong: [0.118, 0.173],
    near: &["quadratic_drag", "cubic_stiffness"],
    make: |values, _| Box::new(AngleDamping { gain: values[0], angle: values[1].max(1e-3) }),
};

#[derive(Debug)]
struct AngleDamping {
    gain: f64,
    angle: f64,
}

impl Effect for AngleDamping {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        self.gain * (1.0 - (x.theta / self.angle).powi(2)) * x.q
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn without_other_moments_the_rate_is_a_polynomial_of_the_angle() {
        // I dq/dθ = d (1 − (θ/θ0)²)  ⇒  q = q0 + d/I (θ − θ³/(3 θ0²))
        let start = State { q: 0.2, q_p: 0.2, ..State::default() };
        let x = fly_freely("angle_damping", &[("d", 0.3), ("theta_0", 0.2)], start, 30).state();
        let expected = 0.2 + 0.3 / 0.1705 * (x.theta - x.theta.powi(3) / (3.0 * 0.04));
        assert!(x.theta > 0.1 && (x.q - expected).abs() < 1e-9, "{x:?}");
    }
}
