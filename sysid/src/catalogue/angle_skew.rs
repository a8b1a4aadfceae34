//! Rate and angle are not of the same moment.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};
use crate::model::pitch::Output;

/// θ_meas(t) = θ(t − δ) ≈ θ − δ q, against the rate of the same row: δ > 0 where the angle is the older of the two, δ < 0 where
/// the rate is (a filter of the gyro's).
pub struct AngleSkew;

/// Largest skew, in samples, and the least that is searched, s.
const LARGEST: (f64, f64) = (1.5, 0.01);

impl Effect for AngleSkew {
    fn about(&self) -> About {
        About {
            id: "angle_skew",
            locus: Locus::Sensor,
            sentence: "the angle of a row is of another moment than its rate",
            equation: "theta_meas(t) = theta(t - delta)",
            variable: "q",
            condition: "in proportion to the pitch rate, between rate and angle alone",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let largest = (LARGEST.0 * data.step).max(LARGEST.1);
        vec![Parameter {
            name: "delta",
            unit: "s",
            lower: -largest,
            upper: largest,
            scale: Scale::Linear(0.1 * largest),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate && data.has_angle
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, _roll_rate: f64) -> Output {
        [y[0], y[1] - p[0] * y[0]]
    }
}
