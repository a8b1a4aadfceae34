//! The measured angle is low-pass filtered.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Effect, Locus, Parameter, Scale};

/// T dθ_meas/dt = θ − θ_meas.
pub struct AngleLag;

impl Effect for AngleLag {
    fn about(&self) -> About {
        About {
            id: "angle_lag",
            locus: Locus::Sensor,
            sentence: "the measured angle is low-pass filtered",
            equation: "T dtheta_meas/dt = theta - theta_meas",
            variable: "q",
            condition: "when the pitch angle changes fast: it trails the integral of the rate",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::Phase)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "T", unit: "s", lower: 0.2 * data.step, upper: 1.0, scale: Scale::Log }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![1.5 * data.step], vec![0.1]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_angle
    }
    fn angle_lag(&self, p: &[f64]) -> Option<f64> {
        Some(p[0])
    }
}
