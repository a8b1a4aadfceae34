//! The gyro clips.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};
use crate::model::pitch::Output;

/// |q_meas| ≤ q_max.
pub struct GyroSaturation;

impl Effect for GyroSaturation {
    fn about(&self) -> About {
        About {
            id: "gyro_saturation",
            locus: Locus::Sensor,
            sentence: "the gyro clips",
            equation: "|q_meas| <= q_max",
            variable: "q",
            condition: "at the largest pitch rates",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "q_max",
            unit: "rad/s",
            lower: 0.5 * data.q,
            upper: 6.0 * data.q,
            scale: Scale::Log,
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [1.2, 1.6, 2.1].map(|share| vec![share * data.q]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, _at: &Conditions) -> Output {
        [y[0].clamp(-p[0], p[0]), y[1]]
    }
}
