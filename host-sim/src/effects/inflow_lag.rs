//! Induced flow builds up behind the blade pitch: M = ∂M/∂u (ua − g λ), Tλ λ̇ = ua − λ.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "inflow_lag",
    locus: "actuator",
    parameters: &[
        Parameter { name: "g", unit: "-", range: [0.2, 0.6], signed: false },
        Parameter { name: "T_lambda", unit: "s", range: [0.05, 0.4], signed: false },
    ],
    moderate_and_strong: [0.5, 0.6],
    near: &[],
    make: |values, _| Box::new(InflowLag { share: values[0], time_constant_s: values[1], inflow: 0.0 }),
};

#[derive(Debug)]
struct InflowLag {
    share: f64,
    time_constant_s: f64,
    inflow: f64,
}

impl Effect for InflowLag {
    fn of_thrust(&self) -> bool {
        true
    }

    /// With the mean of the exact inflow over the step.
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        if self.time_constant_s <= 0.0 {
            return u * (1.0 - self.share);
        }
        let before = self.inflow;
        self.inflow = u + (before - u) * (-dt / self.time_constant_s).exp();
        let mean = u + (before - self.inflow) * self.time_constant_s / dt;
        u - self.share * mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_acts_fully_at_first_and_keeps_the_rest_of_its_share() {
        let mut flow = InflowLag { share: 0.4, time_constant_s: 0.2, inflow: 0.0 };
        let area: f64 = (0..500).map(|_| 1e-3 * flow.blade(0.0, 1.0, 1e-3)).sum();
        let decayed = (-2.5_f64).exp();
        assert!((area - (0.5 - 0.4 * (0.5 - 0.2 * (1.0 - decayed)))).abs() < 1e-12);
        assert!((flow.inflow - (1.0 - decayed)).abs() < 1e-12);
    }
}
