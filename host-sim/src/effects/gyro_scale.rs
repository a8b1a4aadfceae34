//! Gain of the rate is wrong, so θ̇ and q disagree: q_meas = (1 + s) q.

use super::{Effect, Entry, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "gyro_scale",
    locus: "sensor",
    parameters: &[Parameter { name: "s", unit: "-", range: [0.05, 0.3], signed: true }],
    moderate_and_strong: [0.15, 0.3],
    near: &[],
    make: |values, _| Box::new(GyroScale(values[0])),
};

#[derive(Debug)]
struct GyroScale(f64);

impl Effect for GyroScale {
    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.q *= 1.0 + self.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_scaled_and_the_angle_is_not() {
        let mut reading = Reading { q: 0.4, theta: 0.1, ..Reading::default() };
        GyroScale(-0.25).measure(0.0, &mut reading);
        assert!((reading.q - 0.3).abs() < 1e-15);
        assert_eq!(reading.theta, 0.1);
    }
}
