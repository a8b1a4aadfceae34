//! Small commands do nothing: ua = 0 for |uc| < b, else uc − b sign uc.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "servo_deadband",
    locus: "actuator",
    parameters: &[Parameter { name: "b", unit: "rad", range: [0.001, 0.006], signed: false }],
    moderate_and_strong: [0.0012, 0.0014],
    near: &[],
    make: |values, _| Box::new(ServoDeadband(values[0])),
};

#[derive(Debug)]
struct ServoDeadband(f64);

impl Effect for ServoDeadband {
    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        u.signum() * (u.abs() - self.0).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_swallows_small_commands_and_shortens_large_ones() {
        let mut servo = ServoDeadband(0.004);
        assert_eq!(servo.blade(0.0, -0.0039, 1e-3), 0.0);
        assert!((servo.blade(0.0, -0.01, 1e-3) + 0.006).abs() < 1e-15);
        assert!((servo.blade(0.0, 0.015, 1e-3) - 0.011).abs() < 1e-15);
    }
}
