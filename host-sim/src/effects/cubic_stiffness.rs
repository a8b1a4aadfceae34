//! A cable or umbilical that stiffens: M −= k3 θ³.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "cubic_stiffness",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "k3", unit: "N m/rad³", range: [0.5, 30.0], signed: false }],
    moderate_and_strong: [2.74, 6.3],
    near: &[],
    make: |values, _| Box::new(CubicStiffness(values[0])),
};

#[derive(Debug)]
struct CubicStiffness(f64);

impl Effect for CubicStiffness {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        -self.0 * x.theta.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};

    #[test]
    fn it_swings_with_the_period_of_the_elliptic_integral() {
        // I θ̈ = −k3 θ³ from rest at A: period 7.416298709205487 / (A √(k3/I))
        let (k3, amplitude) = (20.0, 0.3);
        let period = 7.416_298_709_205_487 / (amplitude * (k3 / FREE.inertia_kg_m2).sqrt());
        let ticks = (period / 0.02) as usize;
        let rest = State { theta: amplitude, theta_p: amplitude, ..State::default() };
        let aircraft = fly_freely("cubic_stiffness", &[("k3", k3)], rest, ticks);
        // near the turning point: θ ≈ A − k3 A³ δ²/(2 I), q ≈ k3 A³ δ/I, δ the time that is left
        let left = period - ticks as f64 * 0.02;
        let acceleration = k3 * amplitude.powi(3) / FREE.inertia_kg_m2;
        assert!((aircraft.state().q - acceleration * left).abs() < 2e-4, "{:?}", aircraft.state());
    }
}
