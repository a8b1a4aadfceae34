//! A straight spring: M −= k θ.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "linear_stiffness",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "k", unit: "N m/rad", range: [0.05, 1.5], signed: true }],
    moderate_and_strong: [0.13, 0.205],
    near: &["gravity_stiffness"],
    make: |values, _| Box::new(LinearStiffness(values[0])),
};

#[derive(Debug)]
struct LinearStiffness(f64);

impl Effect for LinearStiffness {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        -self.0 * x.theta
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};

    #[test]
    fn it_swings_as_a_cosine() {
        let (k, amplitude, ticks) = (1.2, 0.3, 60);
        let rest = State { theta: amplitude, theta_p: amplitude, ..State::default() };
        let x = fly_freely("linear_stiffness", &[("k", k)], rest, ticks).state();
        let phase = (k / FREE.inertia_kg_m2).sqrt() * ticks as f64 * 0.02;
        assert!((x.theta - amplitude * phase.cos()).abs() < 1e-6, "{x:?}");
    }
}
