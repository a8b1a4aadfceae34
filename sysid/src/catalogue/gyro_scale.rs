//! The gain of the gyro is wrong: θ̇ and q disagree.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Picture, Scale, Signal};
use crate::model::pitch::Output;

/// q_meas = (1 + s) q.
pub struct GyroScale;

impl Effect for GyroScale {
    fn about(&self) -> About {
        About {
            id: "gyro_scale",
            locus: Locus::Sensor,
            sentence: "the gyro's gain is wrong",
            equation: "q_meas = (1 + s) q",
            variable: "q",
            condition: "whenever it turns: the rate and the angle's slope disagree in proportion",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Measured(Signal::Rate))
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "s", unit: "1", lower: -0.8, upper: 2.0, scale: Scale::Linear(0.05) }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate && data.has_angle
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, _roll_rate: f64) -> Output {
        [(1.0 + p[0]) * y[0], y[1]]
    }
}
