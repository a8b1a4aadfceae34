//! Thrust has another slope one way than the other.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M = ∂M/∂u u_a (1 + a sign u_a): a propeller that turns back, blades whose profile is cambered, a fan in a duct.
pub struct AsymmetricThrust;

/// Share of the rows that the command must be on either side of zero for.
const BOTH_SIDES: f64 = 0.05;
/// Spread of the command's size, as a share of it, from which on it is more than one size.
const SIZES: f64 = 0.1;

impl Effect for AsymmetricThrust {
    fn about(&self) -> About {
        About {
            id: "asymmetric_thrust",
            locus: Locus::Actuator,
            sentence: "the command moves the vehicle more one way than the other",
            equation: "M = dM/du u_a (1 + a sign(u_a))",
            variable: "u",
            condition: "at commands of one sign against those of the other",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Command))
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "a", unit: "1", lower: -0.95, upper: 0.95, scale: Scale::Linear(0.1) }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    /// Of a command of one size either way it is a constant moment.
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        let mean = |of: &dyn Fn(f64) -> f64| {
            data.runs.iter().flat_map(|run| &run.u).map(|&u| of(u)).sum::<f64>() / data.samples() as f64
        };
        let share = |side: f64| mean(&|u| f64::from(side * u > 0.0));
        let size = mean(&f64::abs);
        let spread = mean(&|u| (u.abs() - size).powi(2)).sqrt();
        share(1.0) > BOTH_SIDES && share(-1.0) > BOTH_SIDES && spread > SIZES * size
    }
    fn of_thrust(&self) -> bool {
        true
    }
    fn moves_the_mean(&self) -> bool {
        true
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, _at: &Conditions) -> f64 {
        u + p[0] * u.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nose_up_is_stronger_than_nose_down() {
        let thrust = |u: f64| AsymmetricThrust.actuate(&[0.2], &mut [], u, &Conditions::default());
        assert!((thrust(0.01) - 0.012).abs() < 1e-15 && (thrust(-0.01) + 0.008).abs() < 1e-15);
    }
}
