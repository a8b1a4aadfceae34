//! The springs rest at another angle than the zero of the measured one.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};
use crate::model::pitch::Output;

/// θ_meas = θ + θ0: every moment that depends on the angle acts about θ0 of the measured one. Alone it shows in nothing: it is told
/// beside a spring that is not straight, or that nothing else holds aside.
pub struct RestAngle;

impl Effect for RestAngle {
    fn about(&self) -> About {
        About {
            id: "rest_angle",
            locus: Locus::PitchMoment,
            sentence: "gravity and springs rest at another angle than zero (the centre of gravity lies ahead or behind, or the sensor's zero is off)",
            equation: "M(theta) -> M(theta - theta_0)",
            variable: "theta",
            condition: "wherever a moment depends on the angle, unequal on the two sides of its zero",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "theta_0",
            unit: "rad",
            lower: -1.6,
            upper: 1.6,
            scale: Scale::Linear(0.1 * data.theta),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_angle
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, _roll_rate: f64) -> Output {
        [y[0], y[1] + p[0]]
    }
}
