//! The induced flow builds up behind the blade pitch and takes part of the thrust back.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale};

/// M = ∂M/∂u (u_a − g λ), Tλ λ̇ = u_a − λ.
pub struct InflowLag;

impl Effect for InflowLag {
    fn about(&self) -> About {
        About {
            id: "inflow_lag",
            locus: Locus::Actuator,
            sentence: "the induced flow builds up behind the blade angle",
            equation: "M = dM/du (u_a - g lambda), T_lambda dlambda/dt = u_a - lambda",
            variable: "u_rate",
            condition: "for a few tenths of a second after each switch of the input, as an overshoot",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Pitt and Peters, 1981")
    }
    fn class(&self) -> Option<Class> {
        Some(Class::Phase)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter { name: "g", unit: "1", lower: 0.02, upper: 0.95, scale: Scale::Linear(0.1) },
            Parameter { name: "T_lambda", unit: "s", lower: data.step, upper: 1.5, scale: Scale::Log },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.4, 4.0 * data.step], vec![0.4, 0.3]]
    }
    fn states(&self) -> usize {
        1
    }
    fn of_thrust(&self) -> bool {
        true
    }
    fn actuate(&self, p: &[f64], s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        let (share, lag, before) = (p[0], p[1], s[0]);
        let passed = -(-at.dt / lag).exp_m1();
        s[0] = before + (u - before) * passed;
        u - share * (u + (before - u) * passed * lag / at.dt)
    }
}
