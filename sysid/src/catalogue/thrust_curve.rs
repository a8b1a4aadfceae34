//! Thrust is not linear in the collective.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M = ∂M/∂u u_a (1 + κ|u_a|).
pub struct ThrustCurve;

impl Effect for ThrustCurve {
    fn about(&self) -> About {
        About {
            id: "thrust_curve",
            locus: Locus::Actuator,
            sentence: "thrust is not linear in the collective",
            equation: "M = dM/du u_a (1 + kappa |u_a|)",
            variable: "u",
            condition: "at large commands against small ones",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Command))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "kappa",
            unit: "1/rad",
            lower: -0.9 / data.u,
            upper: 5.0 / data.u,
            scale: Scale::Linear(0.1 / data.u),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [-0.1, -0.4, 0.3].map(|share| vec![share / data.u]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        !data.two_levels
    }
    fn of_thrust(&self) -> bool {
        true
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, _at: &Conditions) -> f64 {
        u * (1.0 + p[0] * u.abs())
    }
}
