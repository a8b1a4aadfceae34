//! Blades lose thrust where the frame moves with them: M −= k q |ua|.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "rate_dependent_thrust",
    locus: "actuator",
    parameters: &[Parameter { name: "k", unit: "N m s/rad²", range: [5.0, 100.0], signed: false }],
    moderate_and_strong: [18.5, 32.5],
    near: &["quadratic_drag", "thrust_curve"],
    make: |values, _| Box::new(RateDependentThrust(values[0])),
};

#[derive(Debug)]
struct RateDependentThrust(f64);

impl Effect for RateDependentThrust {
    fn moment(&self, _t: f64, x: &State, blade: f64) -> f64 {
        -self.0 * x.q * blade.abs()
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn under_a_held_command_it_is_a_damping() {
        let thrust = Setting::new("rate_dependent_thrust", &[("k", 40.0)]).unwrap();
        let mut aircraft = Aircraft::new(FREE, &[thrust], None, 0);
        (0..53).for_each(|_| aircraft.advance(-0.015));
        let (damping, t) = (40.0 * 0.015_f64, 1.0);
        let expected = -23.0 * 0.015 / damping * (1.0 - (-damping / 0.1705 * t).exp());
        assert!((aircraft.state().q - expected).abs() < 1e-9);
    }
}
