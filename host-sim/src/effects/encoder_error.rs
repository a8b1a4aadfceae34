//! The measured angle errs periodically with the angle: θ_meas = θ + a sin(n θ + φ).

use super::{Effect, Entry, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "encoder_error",
    locus: "sensor",
    parameters: &[
        Parameter { name: "amplitude", unit: "rad", range: [0.002, 0.02], signed: false },
        Parameter { name: "n", unit: "1", range: [16.0, 36.0], signed: false },
        Parameter { name: "phase", unit: "rad", range: [0.1, 3.0], signed: true },
    ],
    moderate_and_strong: [0.005, 0.01],
    near: &[],
    make: |values, _| Box::new(EncoderError { amplitude: values[0], n: values[1], phase: values[2] }),
};

#[derive(Debug)]
struct EncoderError {
    amplitude: f64,
    n: f64,
    phase: f64,
}

impl Effect for EncoderError {
    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.theta += self.amplitude * (self.n * reading.theta + self.phase).sin();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_errs_and_the_rate_does_not() {
        let mut reading = Reading { q: 0.4, theta: 0.1, ..Reading::default() };
        EncoderError { amplitude: 0.01, n: 20.0, phase: 0.5 }.measure(0.0, &mut reading);
        assert!((reading.theta - 0.1 - 0.01 * 2.5_f64.sin()).abs() < 1e-15);
        assert_eq!(reading.q, 0.4);
    }
}
