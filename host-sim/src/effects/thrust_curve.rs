//! Thrust is not linear in collective: M = ∂M/∂u ua (1 + κ|ua|).

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "thrust_curve",
    locus: "actuator",
    parameters: &[Parameter { name: "kappa", unit: "1/rad", range: [5.0, 40.0], signed: true }],
    moderate_and_strong: [14.9, 25.4],
    near: &[],
    make: |values, _| Box::new(ThrustCurve(values[0])),
};

#[derive(Debug)]
struct ThrustCurve(f64);

impl Effect for ThrustCurve {
    fn of_thrust(&self) -> bool {
        true
    }

    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        u * (1.0 + self.0 * u.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_odd_and_steepens_with_kappa() {
        let mut curve = ThrustCurve(-20.0);
        assert!((curve.blade(0.0, 0.015, 1e-3) - 0.015 * 0.7).abs() < 1e-15);
        assert!((curve.blade(0.0, -0.015, 1e-3) + 0.015 * 0.7).abs() < 1e-15);
    }
}
