//! Something turns or swings at a rate of its own, an unbalanced rotor, a fan: M += A sin(ω t + φ).

use rand::RngExt;
use std::f64::consts::TAU;

use super::{Effect, Entry, Parameter};
use crate::plant::State;
use crate::seeds::{Stream, generator};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "periodic_moment",
    locus: "environment",
    parameters: &[
        Parameter { name: "A", unit: "N m", range: [0.02, 0.3], signed: false },
        Parameter { name: "omega", unit: "rad/s", range: [1.0, 12.0], signed: false },
    ],
    moderate_and_strong: [0.046, 0.065],
    near: &["gust_disturbance"],
    make: |values, seed| {
        let phase = generator(seed, Stream::Effect).random_range(0.0..TAU);
        Box::new(PeriodicMoment { amplitude: values[0], omega: values[1], phase })
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
        let x = fly_freely("periodic_moment", &[("A", 0.1), ("omega", 4.0)], State::default(), 80).state();
        let effect = (ENTRY.make)(&[0.1, 4.0], 0);
        // A/(ω I) (cos φ − cos(ωt + φ)), the cosines from the moment a quarter of a period later
        let cosine = |t: f64| effect.moment(t + TAU / 16.0, &State::default(), 0.0) / 0.1;
        let expected = 0.1 / (4.0 * 0.1705) * (cosine(0.0) - cosine(1.6));
        assert!((x.q - expected).abs() < 1e-6, "{x:?}");
    }
}
