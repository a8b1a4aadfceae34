//! Rotors that change their speed turn the body back.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};

/// M += Jr u̇(t − τ): the reaction to the rotors' own angular acceleration, which yaw shows most (Pounds, Mahony and Corke,
/// Control Engineering Practice 18, 2010).
pub struct RotorReaction;

impl Effect for RotorReaction {
    fn about(&self) -> About {
        About {
            id: "rotor_reaction",
            locus: Locus::Actuator,
            sentence: "rotors that change their speed turn the body by their reaction",
            equation: "M += Jr du/dt, u after the delay",
            variable: "u_rate",
            condition: "at each switch of the input, as a kick",
        }
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
    fn forcing(&self, p: &[f64], at: &Conditions) -> f64 {
        p[0] * at.command_rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_in_proportion_to_the_rate_of_the_command() {
        let at = Conditions { command_rate: -1.5, ..Conditions::default() };
        assert!((RotorReaction.forcing(&[0.2], &at) + 0.3).abs() < 1e-15);
    }
}
