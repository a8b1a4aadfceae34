//! A servo that rings: üa = ω² (uc − ua) − 2ζω u̇a, ω = 2π f.

use std::f64::consts::TAU;

use super::oscillator::Oscillator;
use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "servo_second_order",
    locus: "actuator",
    parameters: &[
        Parameter { name: "f_hz", unit: "Hz", range: [1.8, 6.5], signed: false },
        Parameter { name: "zeta", unit: "1", range: [0.05, 0.4], signed: false },
    ],
    moderate_and_strong: [3.06, 2.58],
    near: &[],
    make: |values, _| {
        let omega = TAU * values[0];
        Box::new(ServoSecondOrder { omega, servo: Oscillator::new(omega, values[1]) })
    },
};

#[derive(Debug)]
struct ServoSecondOrder {
    omega: f64,
    servo: Oscillator,
}

impl Effect for ServoSecondOrder {
    /// Mean of the exact positions at both ends of the step.
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        let before = self.servo.position;
        self.servo.advance(self.omega * self.omega * u, dt);
        (before + self.servo.position) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_overshoots_by_the_closed_form() {
        let zeta = 0.2_f64;
        let mut servo = (ENTRY.make)(&[2.0, zeta], 0);
        let highest = (0..1000).map(|_| servo.blade(0.0, 1.0, 1e-3)).fold(0.0_f64, f64::max);
        let overshoot = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((highest - 1.0 - overshoot).abs() < 1e-4, "{highest}");
    }
}
