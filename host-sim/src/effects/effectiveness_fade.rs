//! The battery sags, the rotors droop: ∂M/∂u (1 − a t).

use super::{Effect, Entry, Parameter};
use crate::plant::Plant;

pub(super) const ENTRY: Entry = Entry {
    id: "effectiveness_fade",
    locus: "actuator",
    parameters: &[Parameter { name: "a", unit: "1/s", range: [0.001, 0.006], signed: false }],
    moderate_and_strong: [0.0022, 0.0029],
    near: &[],
    make: |values, _| Box::new(EffectivenessFade(values[0])),
};

#[derive(Debug)]
struct EffectivenessFade(f64);

impl Effect for EffectivenessFade {
    /// Down to nothing, not beyond.
    fn plant(&self, t: f64, plant: &mut Plant) {
        plant.dm_du *= (1.0 - self.0 * t).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effectiveness_falls_in_a_straight_line_and_never_turns_round() {
        let at = |t| {
            let mut plant = Plant::nominal();
            EffectivenessFade(0.005).plant(t, &mut plant);
            plant.dm_du
        };
        assert!((at(0.0) - 23.0).abs() < 1e-12);
        assert!((at(100.0) - 11.5).abs() < 1e-12);
        assert_eq!(at(300.0), 0.0);
    }
}
