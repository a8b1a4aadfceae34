//! The gyro is low-pass filtered.

use super::{About, Amplitudes, Conditions, Effect, Locus, Parameter, Scale};
use crate::dataset::Dataset;
use crate::diagnosis::baseline::Baseline;
use crate::model::pitch::Output;

/// T q̇_meas = q − q_meas.
pub struct GyroLag;

impl Effect for GyroLag {
    fn about(&self) -> About {
        About {
            id: "gyro_lag",
            locus: Locus::Sensor,
            sentence: "the gyro is low-pass filtered",
            equation: "T dq_meas/dt = q - q_meas",
            variable: "qdot",
            condition: "when the pitch rate changes fast",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "T", unit: "s", lower: 0.2 * data.step, upper: 0.5, scale: Scale::Log }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![1.5 * data.step], vec![0.08]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate
    }
    fn states(&self) -> usize {
        1
    }
    fn sense(&self, p: &[f64], s: &mut [f64], q: f64, _control: f64, at: &Conditions) {
        s[0] += (q - s[0]) * -(-at.dt / p[0]).exp_m1();
    }
    fn measure(&self, _p: &[f64], s: &[f64], y: Output) -> Output {
        [s[0], y[1]]
    }
}
