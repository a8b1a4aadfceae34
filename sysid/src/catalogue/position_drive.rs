//! A drive that turns the body to the angle that it is told, as hard as it can.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M = clamp(∂M/∂u u_a − k θ, ±M_max) in place of ∂M/∂u u_a: the command is an angle, θ = u ∂M/∂u/k where it is reached, and the
/// drive's own damping has it turn at M_max/|∂M/∂q| at the most.
pub struct PositionDrive;

impl Effect for PositionDrive {
    fn about(&self) -> About {
        About {
            id: "position_drive",
            locus: Locus::Actuator,
            sentence: "the drive turns the body to the angle that the command says, with a limited moment (a position servo)",
            equation: "M = clamp(dM/du u_a - k theta, +-M_max) in place of dM/du u_a",
            variable: "theta",
            condition: "while the angle is not the commanded one",
        }
    }
    /// One that never gives all it can is a spring beside the command.
    fn generalises(&self, other: &dyn Effect) -> bool {
        ["linear_stiffness", "gravity_stiffness"].contains(&other.about().id)
    }
    /// A drive that is quicker than the rows begins to turn with the command, as a reaction to its change would.
    fn accounts_for(&self, other: &dyn Effect, _values: &[f64], _data: &Amplitudes) -> bool {
        other.about().id == "rotor_reaction"
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = data.acting() / data.theta;
        vec![
            Parameter {
                name: "k",
                unit: "N m/rad",
                lower: 0.01 * unit,
                upper: 1e3 * unit,
                scale: Scale::Log,
            },
            Parameter {
                name: "M_max",
                unit: "N m",
                lower: 0.05 * data.acting(),
                upper: 50.0 * data.acting(),
                scale: Scale::Log,
            },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let unit = data.acting() / data.theta;
        [[1.0, 1.0], [5.0, 1.0], [5.0, 3.0]].map(|[k, most]| vec![k * unit, most * data.acting()]).to_vec()
    }
    fn moves_the_mean(&self) -> bool {
        true
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, at: &Conditions) -> f64 {
        (at.control - p[0] * theta).clamp(-p[1], p[1]) - at.control
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pushes_to_the_commanded_angle_and_no_harder_than_it_can() {
        let moment = |control: f64, theta: f64| {
            let at = Conditions { control, ..Conditions::default() };
            control + PositionDrive.moment(&[10.0, 2.0], &[], 0.0, theta, &at)
        };
        assert_eq!(
            [moment(5.0, 0.5), moment(5.0, 0.4), moment(5.0, 0.0), moment(5.0, 2.0)],
            [0.0, 1.0, 2.0, -2.0]
        );
    }
}
