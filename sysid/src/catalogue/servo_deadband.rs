//! Small commands do nothing.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// u_a = 0 for |u_c| < b, else u_c − b sign u_c.
pub struct ServoDeadband;

impl Effect for ServoDeadband {
    fn about(&self) -> About {
        About {
            id: "servo_deadband",
            locus: Locus::Actuator,
            sentence: "the servo ignores small commands",
            equation: "u_a = 0 for |u_c| < b, else u_c - b sign(u_c)",
            variable: "u",
            condition: "at small commands",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::SmallSignals)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Command))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "b",
            unit: "rad",
            lower: 0.0,
            upper: 1.5 * data.u,
            scale: Scale::Linear(0.1 * data.u),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.1, 0.35].map(|share| vec![share * data.u]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        !data.two_levels
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, _at: &Conditions) -> f64 {
        u - u.clamp(-p[0], p[0])
    }
}
