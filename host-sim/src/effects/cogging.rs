//! A moment that repeats with the angle, as a motor's magnets or a gear give: M += a sin(n θ + φ).

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "cogging",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "amplitude", unit: "N m", range: [0.02, 0.3], signed: false },
        Parameter { name: "n", unit: "1", range: [24.0, 48.0], signed: false },
        Parameter { name: "phase", unit: "rad", range: [0.1, 3.0], signed: true },
    ],
    moderate_and_strong: [0.06, 0.09],
    near: &[],
    make: |values, _| Box::new(Cogging { amplitude: values[0], n: values[1], phase: values[2] }),
};

#[derive(Debug)]
struct Cogging {
    amplitude: f64,
    n: f64,
    phase: f64,
}

impl Effect for Cogging {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        self.amplitude * (self.n * x.theta + self.phase).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};

    #[test]
    fn energy_is_that_of_a_pendulum_of_n_turns() {
        let (a, n, phase) = (0.1, 30.0, 0.7);
        let rest = State { theta: 0.02, theta_p: 0.02, ..State::default() };
        let x = fly_freely("cogging", &[("amplitude", a), ("n", n), ("phase", phase)], rest, 30).state();
        let potential = |theta: f64| a / n * (n * theta + phase).cos();
        let kinetic = 0.5 * FREE.inertia_kg_m2 * x.q * x.q;
        assert!((kinetic + potential(x.theta) - potential(0.02)).abs() < 1e-8, "{x:?}");
    }
}
