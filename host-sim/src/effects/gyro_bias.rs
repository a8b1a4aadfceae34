//! Offset of the rate: q_meas = q + b.

use super::{Effect, Entry, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "gyro_bias",
    locus: "sensor",
    parameters: &[Parameter { name: "b", unit: "rad/s", range: [0.01, 0.1], signed: true }],
    moderate_and_strong: [0.03, 0.1],
    near: &[],
    make: |values, _| Box::new(GyroBias(values[0])),
};

#[derive(Debug)]
struct GyroBias(f64);

impl Effect for GyroBias {
    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.q += self.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_off_and_the_angle_is_not() {
        let mut reading = Reading { q: 0.3, theta: 0.1, ..Reading::default() };
        GyroBias(-0.05).measure(0.0, &mut reading);
        assert_eq!((reading.q, reading.theta), (0.25, 0.1));
    }
}
