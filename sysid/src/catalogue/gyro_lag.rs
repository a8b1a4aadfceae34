//! The gyro is low-pass filtered.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Effect, Locus, Parameter, Scale};

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
    fn class(&self) -> Option<Class> {
        Some(Class::Phase)
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
    fn gyro_lag(&self, p: &[f64]) -> Option<f64> {
        Some(p[0])
    }
}
