//! The supply sags while the servos and rotors work, and recovers: ∂M/∂u (1 − k v), T v̇ = |ua|/u0 − v.

use super::{Effect, Entry, Parameter};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "sagging_supply",
    locus: "actuator",
    parameters: &[
        Parameter { name: "k", unit: "-", range: [0.1, 0.9], signed: false },
        Parameter { name: "T", unit: "s", range: [3.0, 15.0], signed: false },
    ],
    moderate_and_strong: [0.516, 0.63],
    near: &["voltage_droop", "effectiveness_fade", "thrust_curve"],
    make: |values, _| {
        Box::new(SaggingSupply { depth: values[0], time_constant_s: values[1].max(1e-3), droop: 0.0 })
    },
};

/// u0, the work at which the droop is k in the end, rad.
const REFERENCE_RAD: f64 = 0.015;

#[derive(Debug)]
struct SaggingSupply {
    depth: f64,
    time_constant_s: f64,
    droop: f64,
}

impl Effect for SaggingSupply {
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        let end = u.abs() / REFERENCE_RAD;
        self.droop = end + (self.droop - end) * (-dt / self.time_constant_s).exp();
        u * (1.0 - self.depth * self.droop).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_droops_under_work_and_recovers_at_rest() {
        let mut supply = SaggingSupply { depth: 0.4, time_constant_s: 5.0, droop: 0.0 };
        for k in 0..5000 {
            supply.blade(0.0, if k % 600 < 300 { 0.015 } else { -0.015 }, 1e-3);
        }
        let worked = 1.0 - (-1.0_f64).exp();
        assert!((supply.blade(0.0, 0.015, 0.0) - 0.015 * (1.0 - 0.4 * worked)).abs() < 1e-12);
        for _ in 0..10_000 {
            supply.blade(0.0, 0.0, 1e-3);
        }
        assert!((supply.droop - worked * (-2.0_f64).exp()).abs() < 1e-12);
    }
}
