//! Dry friction with another value each way.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= M_up for q > 0, M += M_down for q < 0 (Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30, 1994): the same
/// moment as `coulomb_friction` of (M_up + M_down)/2 beside a `trim_offset` of (M_down − M_up)/2, and no motion tells which of the
/// two makes it.
pub struct AsymmetricFriction;

impl Effect for AsymmetricFriction {
    fn about(&self) -> About {
        About {
            id: "asymmetric_friction",
            locus: Locus::PitchMoment,
            sentence: "dry friction in the pivot has another value nose-up than nose-down, or a constant moment acts beside it",
            equation: "M -= M_up for q > 0, M += M_down for q < 0",
            variable: "q",
            condition: "when the pitch rate changes sign",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Armstrong-Hélouvry, Dupont and Canudas de Wit, 1994")
    }
    fn generalises(&self, other: &dyn Effect) -> bool {
        other.about().id == "coulomb_friction"
    }
    fn restates(&self) -> &'static [&'static str] {
        &["coulomb_friction", "trim_offset"]
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Rate))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 0.1 * data.moment;
        let (lower, upper, scale) = (0.0, 30.0 * unit, Scale::Linear(unit));
        ["M_up", "M_down"].map(|name| Parameter { name, unit: "N m", lower, upper, scale }).to_vec()
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1 * data.moment; 2]]
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], q: f64, _theta: f64, at: &Conditions) -> f64 {
        -p[usize::from(q < 0.0)] * (q / at.small_rate).tanh()
    }
    fn friction(&self, p: &[f64], q: f64) -> Option<f64> {
        Some(p[usize::from(q < 0.0)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_way_has_its_own_moment_against_the_motion() {
        let at = Conditions { small_rate: 1e-4, ..Conditions::default() };
        let moment = |q: f64| AsymmetricFriction.moment(&[0.07, 0.02], &[], q, 0.0, &at);
        assert_eq!((moment(0.1), moment(-0.1), moment(0.0)), (-0.07, 0.02, 0.0));
    }
}
