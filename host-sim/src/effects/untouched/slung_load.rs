//! A load slung below the pivot, swinging: M += G sin(α − θ), l α̈ + h θ̈ = −g α − 2ζ√(g l) α̇.
//!
//! α: angle of the cable against the vertical; G: weight times the arm h from the pivot down to the hook. The
//! cable's pull is taken as the weight.

use super::super::oscillator::Oscillator;
use super::{Effect, Entry, Motion, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "slung_load",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "G", unit: "N m", range: [0.05, 1.5], signed: false },
        Parameter { name: "l", unit: "m", range: [0.3, 2.0], signed: false },
    ],
    moderate_and_strong: [0.133, 0.201],
    near: &["gravity_stiffness"],
    make: |values, _| {
        let length = values[1].max(0.01);
        let swing = Oscillator::new((GRAVITY_M_S2 / length).sqrt(), DAMPING_RATIO);
        Box::new(SlungLoad { moment: values[0], arm_per_length: ARM_M / length, swing })
    },
};

const GRAVITY_M_S2: f64 = 9.81;
/// h, m.
const ARM_M: f64 = 0.15;
/// ζ of the swing, from the air.
const DAMPING_RATIO: f64 = 0.02;

#[derive(Debug)]
struct SlungLoad {
    moment: f64,
    arm_per_length: f64,
    swing: Oscillator,
}

impl Effect for SlungLoad {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        self.moment * (self.swing.position - x.theta).sin()
    }

    fn follow(&mut self, motion: &Motion) {
        let acceleration = (motion.after.q - motion.before.q) / motion.dt;
        self.swing.advance(-self.arm_per_length * acceleration, motion.dt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};

    #[test]
    fn frame_and_load_swing_as_the_double_pendulum_does() {
        // the coupled linear equations by the midpoint rule on a grid of its own
        let (g_moment, length) = (0.4, 0.8);
        let start = State { theta: 0.02, theta_p: 0.02, ..State::default() };
        let found = fly_freely("slung_load", &[("G", g_moment), ("l", length)], start, 200).state();
        let omega = (GRAVITY_M_S2 / length).sqrt();
        let rate = |[theta, q, alpha, swing]: [f64; 4]| {
            let q_dot = g_moment * (alpha - theta) / FREE.inertia_kg_m2;
            let pull = -ARM_M / length * q_dot - omega * omega * alpha - 2.0 * DAMPING_RATIO * omega * swing;
            [q, q_dot, swing, pull]
        };
        let moved = |x: [f64; 4], v: [f64; 4], h: f64| std::array::from_fn(|i| x[i] + h * v[i]);
        let mut x = [0.02, 0.0, 0.0, 0.0];
        for _ in 0..40_000 {
            let middle = moved(x, rate(x), 0.5e-4);
            x = moved(x, rate(middle), 1e-4);
        }
        assert!((found.theta - x[0]).abs() < 1e-4 && (found.q - x[1]).abs() < 3e-4, "{found:?} {x:?}");
    }
}
