//! The collective servo, or the rotor behind it, follows the command as a first-order lag.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale};

/// T u̇_a = u_c − u_a.
pub struct ServoLag;

impl Effect for ServoLag {
    fn about(&self) -> About {
        About {
            id: "servo_lag",
            locus: Locus::Actuator,
            sentence: "the servo (or the rotor) follows the command with a first-order lag",
            equation: "T du_a/dt = u_c - u_a",
            variable: "u_rate",
            condition: "for a few tenths of a second after each switch of the input",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::Phase)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "T", unit: "s", lower: 0.2 * data.step, upper: 0.5, scale: Scale::Log }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![1.5 * data.step], vec![0.1]]
    }
    fn states(&self) -> usize {
        1
    }
    fn carries_thrust(&self) -> bool {
        true
    }
    /// Exact for a command that is constant over the step; answers the mean of u_a over it.
    fn actuate(&self, p: &[f64], s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        let (lag, before) = (p[0], s[0]);
        let passed = -(-at.dt / lag).exp_m1();
        s[0] = before + (u - before) * passed;
        u + (before - u) * passed * lag / at.dt
    }
}
