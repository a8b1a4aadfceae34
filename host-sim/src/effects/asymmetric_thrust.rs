//! Another slope for nose-up than for nose-down: M = ∂M/∂u ua (1 + a sign ua).

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "asymmetric_thrust",
    locus: "actuator",
    parameters: &[Parameter { name: "a", unit: "-", range: [0.05, 0.5], signed: true }],
    moderate_and_strong: [0.15, 0.19],
    near: &[],
    make: |values, _| Box::new(AsymmetricThrust(values[0])),
};

#[derive(Debug)]
struct AsymmetricThrust(f64);

impl Effect for AsymmetricThrust {
    fn of_thrust(&self) -> bool {
        true
    }

    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        u + self.0 * u.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nose_up_is_stronger_than_nose_down() {
        let mut thrust = AsymmetricThrust(0.2);
        assert!((thrust.blade(0.0, 0.01, 1e-3) - 0.012).abs() < 1e-15);
        assert!((thrust.blade(0.0, -0.01, 1e-3) + 0.008).abs() < 1e-15);
    }
}
