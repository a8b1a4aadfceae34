//! Control effectiveness grows with the collective thrust: ∂M/∂u (1 + k (T − T̄)/T̄), T the logged `thrust_norm`, T̄ that
//! of hover.

use super::{Beside, Effect, Entry, Others, Parameter};
use crate::plant::Plant;

pub(super) const ENTRY: Entry = Entry {
    id: "thrust_dependence",
    locus: "actuator",
    parameters: &[Parameter { name: "k", unit: "1", range: [0.2, 2.0], signed: true }],
    moderate_and_strong: [1.12, 1.42],
    near: &[],
    make: |values, _| Box::new(ThrustDependence { gain: values[0], above: 0.0 }),
};

#[derive(Debug)]
struct ThrustDependence {
    gain: f64,
    /// (T − T̄)/T̄.
    above: f64,
}

impl Effect for ThrustDependence {
    fn others(&self) -> Others {
        Others { thrust: true, ..Others::default() }
    }

    fn beside(&mut self, now: &Beside) {
        self.above = now.thrust_above_hover();
    }

    /// Down to nothing, not beyond.
    fn plant(&self, _t: f64, plant: &mut Plant) {
        plant.dm_du *= (1.0 + self.gain * self.above).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_more_thrust_is_a_fifth_of_k_more_effect() {
        let mut effect = (ENTRY.make)(&[0.8], 0);
        for (thrust, expected) in [(0.5, 23.0), (0.6, 23.0 * 1.16), (0.4, 23.0 * 0.84)] {
            let mut plant = Plant::nominal();
            effect.beside(&Beside { thrust, ..Beside::default() });
            effect.plant(0.0, &mut plant);
            assert!((plant.dm_du - expected).abs() < 1e-12);
        }
    }
}
