//! Control effectiveness grows with the collective thrust.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// ∂M/∂u (1 + k (T − T̄)/T̄), T the collective thrust and T̄ its mean.
pub struct ThrustDependence;

impl Effect for ThrustDependence {
    fn about(&self) -> About {
        About {
            id: "thrust_dependence",
            locus: Locus::Actuator,
            sentence: "control effectiveness depends on the collective thrust",
            equation: "dM/du (1 + k (T - T_mean)/T_mean)",
            variable: "thrust",
            condition: "at high thrust against low",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Gain(Signal::Thrust))
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "k", unit: "1", lower: -5.0, upper: 5.0, scale: Scale::Linear(0.1) }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.varies(|beside| beside.thrust.as_deref())
    }
    fn of_thrust(&self) -> bool {
        true
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        u * (1.0 + p[0] * at.thrust)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_more_thrust_adds_a_tenth_of_k() {
        let at = Conditions { thrust: 0.1, ..Conditions::default() };
        assert!((ThrustDependence.actuate(&[0.8], &mut [], 0.5, &at) - 0.54).abs() < 1e-15);
    }
}
