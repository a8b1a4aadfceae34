//! Rotors that change their speed turn the body back.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale};
use crate::recording::InputUnit;

/// M += Jr u̇_a: the reaction to the rotors' own angular acceleration, which yaw shows most (Pounds, Mahony and Corke, Control
/// Engineering Practice 18, 2010). Of a command that jumps it is a kick, of one that a servo or rotor follows later an answer that
/// comes at once and goes with its lag.
pub struct RotorReaction;

impl Effect for RotorReaction {
    fn about(&self) -> About {
        About {
            id: "rotor_reaction",
            locus: Locus::Actuator,
            sentence: "rotors that change their speed turn the body by their reaction",
            equation: "M += Jr du_a/dt, u_a as the blades follow u",
            variable: "u_rate",
            condition: "at each switch of the input, as a kick",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Pounds, Mahony and Corke, 2010")
    }
    /// Where the input is a force, a moment or the current that makes one, no rotor does.
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        !matches!(data.input_unit, InputUnit::Newton | InputUnit::NewtonMetre | InputUnit::Ampere)
    }
    /// A lead: without another axis it turns the phase as a shorter delay does.
    fn class(&self) -> Option<Class> {
        Some(Class::Phase)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let gain = data.moment / data.u;
        vec![Parameter {
            name: "Jr",
            unit: "N m s/unit",
            lower: 0.1 * data.step * gain,
            upper: 2.0 * gain,
            scale: Scale::Log,
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.02, 0.15].map(|lead| vec![lead * data.moment / data.u]).to_vec()
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn is_impulsive(&self) -> bool {
        true
    }
    fn impulse(&self, p: &[f64], at: &Conditions) -> f64 {
        p[0] * at.blades_change
    }
}
