//! Something turns or swings at a rate of its own, an unbalanced rotor, a fan: M += a sin(2π f t + φ), t the time of the
//! recording.

use std::f64::consts::TAU;

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "periodic_moment",
    locus: "environment",
    parameters: &[
        Parameter { name: "amplitude", unit: "N m", range: [0.02, 0.3], signed: false },
        Parameter { name: "f_hz", unit: "Hz", range: [0.16, 2.0], signed: false },
        Parameter { name: "phase", unit: "rad", range: [0.1, 3.0], signed: true },
    ],
    moderate_and_strong: [0.0451, 0.0632],
    near: &[],
    make: |values, _| {
        Box::new(PeriodicMoment { amplitude: values[0], omega: TAU * values[1], phase: values[2] })
    },
};

#[derive(Debug)]
struct PeriodicMoment {
    amplitude: f64,
    omega: f64,
    phase: f64,
}

impl Effect for PeriodicMoment {
    fn moment(&self, t: f64, _x: &State, _blade: f64) -> f64 {
        self.amplitude * (self.omega * t + self.phase).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn the_rate_is_its_integral() {
        let shake = [("amplitude", 0.1), ("f_hz", 0.6), ("phase", -0.7)];
        let x = fly_freely("periodic_moment", &shake, State::default(), 80).state();
        let omega = TAU * 0.6;
        let expected = 0.1 / (omega * 0.1705) * ((-0.7_f64).cos() - (omega * 1.6 - 0.7).cos());
        assert!((x.q - expected).abs() < 1e-6, "{x:?}");
    }
}
