//! The range of the collective is exhausted.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// |u_a| ≤ u_max.
pub struct ServoSaturation;

impl Effect for ServoSaturation {
    fn about(&self) -> About {
        About {
            id: "servo_saturation",
            locus: Locus::Actuator,
            sentence: "the collective range is exhausted beyond a limit",
            equation: "|u_a| <= u_max",
            variable: "u",
            condition: "when the command exceeds the limit",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Command))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "u_max",
            unit: "rad",
            lower: 0.1 * data.u,
            upper: 4.0 * data.u,
            scale: Scale::Log,
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.6, 0.85, 1.1, 1.5].map(|share| vec![share * data.u]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        !data.two_levels
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, _at: &Conditions) -> f64 {
        u.clamp(-p[0], p[0])
    }
}
