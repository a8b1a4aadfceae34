//! The collective servo follows as a first-order lag: T u̇a = uc − ua.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "servo_lag",
    locus: "actuator",
    parameters: &[Parameter { name: "T", unit: "s", range: [0.02, 0.15], signed: false }],
    moderate_and_strong: [0.067, 0.115],
    near: &[],
    make: |values, _| Box::new(ServoLag { time_constant_s: values[0], position: 0.0 }),
};

#[derive(Debug)]
struct ServoLag {
    time_constant_s: f64,
    position: f64,
}

impl Effect for ServoLag {
    /// Mean of the exact exponential over the step.
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        if self.time_constant_s <= 0.0 {
            return u;
        }
        let before = self.position;
        self.position = u + (before - u) * (-dt / self.time_constant_s).exp();
        u + (before - self.position) * self.time_constant_s / dt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_followed_as_the_closed_form_says() {
        let mut lag = ServoLag { time_constant_s: 0.1, position: 0.0 };
        let area: f64 = (0..300).map(|_| 1e-3 * lag.blade(0.0, 1.0, 1e-3)).sum();
        let decayed = (-3.0_f64).exp();
        assert!((lag.position - (1.0 - decayed)).abs() < 1e-12);
        assert!((area - (0.3 - 0.1 * (1.0 - decayed))).abs() < 1e-12);
    }
}
