//! The battery sags, the rotors droop: control effectiveness fades.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// ∂M/∂u (1 − a t).
pub struct EffectivenessFade;

impl Effect for EffectivenessFade {
    fn about(&self) -> About {
        About {
            id: "effectiveness_fade",
            locus: Locus::Actuator,
            sentence: "control effectiveness fades with time",
            equation: "dM/du (1 - a t)",
            variable: "t",
            condition: "more and more towards the end of the recording",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Gain(Signal::Time))
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "a", unit: "1/s", lower: 0.0, upper: 0.02, scale: Scale::Linear(1e-3) }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![1e-3]]
    }
    fn of_thrust(&self) -> bool {
        true
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        u * (1.0 - p[0] * at.t).max(0.0)
    }
}
