//! The servo slews no faster than r: |u̇a| ≤ r.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "servo_rate_limit",
    locus: "actuator",
    parameters: &[Parameter { name: "r", unit: "rad/s", range: [0.02, 0.3], signed: false }],
    moderate_and_strong: [0.2, 0.139],
    near: &[],
    make: |values, _| Box::new(ServoRateLimit { rate: values[0], position: 0.0 }),
};

#[derive(Debug)]
struct ServoRateLimit {
    rate: f64,
    position: f64,
}

impl Effect for ServoRateLimit {
    /// Mean over the step: a ramp until the command is reached, then the command.
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        let way = u - self.position;
        let ramp = if self.rate > 0.0 { (way.abs() / self.rate).min(dt) } else { dt };
        let before = self.position;
        self.position = if ramp < dt { u } else { before + (self.rate * dt).copysign(way) };
        ((before + self.position) / 2.0 * ramp + u * (dt - ramp)) / dt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_becomes_a_ramp() {
        let mut servo = ServoRateLimit { rate: 0.1, position: 0.0 };
        let area: f64 = (0..400).map(|k| 1e-3 * servo.blade(f64::from(k) * 1e-3, 0.030_05, 1e-3)).sum();
        assert_eq!(servo.position, 0.030_05);
        assert!((area - (0.030_05 * 0.4 - 0.030_05_f64.powi(2) / 0.2)).abs() < 1e-12);
        servo.blade(0.4, -0.03, 1e-3);
        assert!((servo.position - 0.029_95).abs() < 1e-12);
    }
}
