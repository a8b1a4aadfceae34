//! Rate and angle of a row are not of the same moment: θ_meas = θ − δ q.

use super::{Effect, Entry, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "angle_skew",
    locus: "sensor",
    parameters: &[Parameter { name: "delta", unit: "s", range: [0.003, 0.02], signed: true }],
    moderate_and_strong: [0.008, 0.016],
    near: &[],
    make: |values, _| Box::new(AngleSkew(values[0])),
};

#[derive(Debug)]
struct AngleSkew(f64);

impl Effect for AngleSkew {
    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.theta -= self.0 * reading.q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_is_that_of_a_moment_before() {
        let mut reading = Reading { q: 0.4, theta: 0.1, ..Reading::default() };
        AngleSkew(0.01).measure(0.0, &mut reading);
        assert!((reading.theta - 0.096).abs() < 1e-15);
        assert_eq!(reading.q, 0.4);
    }
}
