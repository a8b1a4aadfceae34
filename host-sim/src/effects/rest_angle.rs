//! The angle is measured from another zero than the one about which springs act: θ_meas = θ + θ0.

use super::{Effect, Entry, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "rest_angle",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "theta_0", unit: "rad", range: [0.02, 0.4], signed: true }],
    moderate_and_strong: [0.1, 0.3],
    near: &[],
    make: |values, _| Box::new(RestAngle(values[0])),
};

#[derive(Debug)]
struct RestAngle(f64);

impl Effect for RestAngle {
    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.theta += self.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_is_shifted_and_the_rate_is_not() {
        let mut reading = Reading { q: 0.4, theta: 0.1, ..Reading::default() };
        RestAngle(-0.25).measure(0.0, &mut reading);
        assert!((reading.theta + 0.15).abs() < 1e-15);
        assert_eq!(reading.q, 0.4);
    }
}
