//! The gyro has an offset.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};
use crate::model::pitch::Output;

/// q_meas = q + b.
pub struct GyroBias;

impl Effect for GyroBias {
    fn about(&self) -> About {
        About {
            id: "gyro_bias",
            locus: Locus::Sensor,
            sentence: "the gyro has a constant offset",
            equation: "q_meas = q + b",
            variable: "constant",
            condition: "all the time: the rate's mean and the angle's slope disagree",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "b",
            unit: "rad/s",
            lower: -5.0 * data.q,
            upper: 5.0 * data.q,
            scale: Scale::Linear(0.05 * data.q),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, _roll_rate: f64) -> Output {
        [y[0] + p[0], y[1]]
    }
}
