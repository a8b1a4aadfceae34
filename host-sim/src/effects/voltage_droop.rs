//! Control effectiveness follows the supply: ∂M/∂u (V/V̄)ⁿ, V the logged `battery_v`, V̄ the battery's nominal voltage.

use super::{Beside, Effect, Entry, Others, Parameter};
use crate::plant::Plant;

pub(super) const ENTRY: Entry = Entry {
    id: "voltage_droop",
    locus: "actuator",
    parameters: &[Parameter { name: "n", unit: "1", range: [0.5, 4.0], signed: false }],
    moderate_and_strong: [1.59, 2.44],
    near: &[],
    make: |values, _| Box::new(VoltageDroop { power: values[0], ratio: 1.0 }),
};

#[derive(Debug)]
struct VoltageDroop {
    power: f64,
    /// V/V̄.
    ratio: f64,
}

impl Effect for VoltageDroop {
    fn others(&self) -> Others {
        Others { battery: true, ..Others::default() }
    }

    fn beside(&mut self, now: &Beside) {
        self.ratio = (now.battery_v / Beside::default().battery_v).max(0.0);
    }

    fn plant(&self, _t: f64, plant: &mut Plant) {
        plant.dm_du *= self.ratio.powf(self.power);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_less_voltage_leaves_its_power() {
        let mut effect = (ENTRY.make)(&[2.0], 0);
        let mut plant = Plant::nominal();
        effect.beside(&Beside { battery_v: 0.9 * 14.8, ..Beside::default() });
        effect.plant(0.0, &mut plant);
        assert!((plant.dm_du - 0.81 * 23.0).abs() < 1e-12);
    }
}
