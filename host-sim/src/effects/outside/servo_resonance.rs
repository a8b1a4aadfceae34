//! A servo that rings: üa + 2ζω u̇a + ω² ua = ω² uc.

use super::super::oscillator::Oscillator;
use super::{Effect, Entry, Parameter};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "servo_resonance",
    locus: "actuator",
    parameters: &[
        Parameter { name: "omega", unit: "rad/s", range: [6.0, 40.0], signed: false },
        Parameter { name: "zeta", unit: "-", range: [0.05, 0.4], signed: false },
    ],
    moderate_and_strong: [19.5, 16.2],
    near: &["servo_lag", "structural_mode", "extra_delay", "gyro_lag"],
    make: |values, _| {
        Box::new(ServoResonance { omega: values[0], servo: Oscillator::new(values[0], values[1]) })
    },
};

#[derive(Debug)]
struct ServoResonance {
    omega: f64,
    servo: Oscillator,
}

impl Effect for ServoResonance {
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
        let (omega, zeta) = (12.0, 0.2_f64);
        let mut servo = ServoResonance { omega, servo: Oscillator::new(omega, zeta) };
        let highest = (0..1000).map(|_| servo.blade(0.0, 1.0, 1e-3)).fold(0.0_f64, f64::max);
        let overshoot = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((highest - 1.0 - overshoot).abs() < 1e-4, "{highest}");
    }
}
