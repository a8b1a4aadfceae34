//! Friction that falls with speed.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= (Mc + (Ms − Mc) exp(−(q/qs)²)) sign q (Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30, 1994), with
/// the sign of `coulomb_friction`; without a fall (Ms = Mc) it is that.
pub struct StribeckFriction;

impl Effect for StribeckFriction {
    fn about(&self) -> About {
        About {
            id: "stribeck_friction",
            locus: Locus::PitchMoment,
            sentence: "friction in the pivot is higher near standstill and falls with speed",
            equation: "M -= (Mc + (Ms - Mc) exp(-(q/qs)^2)) sign(q), sticks at rest",
            variable: "q",
            condition: "at small pitch rates, most where the vehicle breaks away",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Armstrong-Hélouvry, Dupont and Canudas de Wit, 1994")
    }
    fn generalises(&self, other: &dyn Effect) -> bool {
        other.about().id == "coulomb_friction"
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Rate))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 0.1 * data.moment;
        let moment = |name| Parameter {
            name,
            unit: "N m",
            lower: 0.0,
            upper: 30.0 * unit,
            scale: Scale::Linear(unit),
        };
        let qs = Parameter {
            name: "qs",
            unit: "rad/s",
            lower: 0.05 * data.q,
            upper: 3.0 * data.q,
            scale: Scale::Log,
        };
        vec![moment("Mc"), moment("Ms"), qs]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.15, 0.5].map(|share| vec![0.05 * data.moment, 0.2 * data.moment, share * data.q]).to_vec()
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], q: f64, _theta: f64, at: &Conditions) -> f64 {
        -level(p, q) * (q / at.small_rate).tanh()
    }
    fn friction(&self, p: &[f64], q: f64) -> Option<f64> {
        Some(level(p, q))
    }
}

/// A breakaway below the sliding friction is no fall, and is taken for none.
fn level(p: &[f64], q: f64) -> f64 {
    p[0] + (p[1] - p[0]).max(0.0) * (-(q / p[2]).powi(2)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_breaks_away_at_one_moment_and_slides_at_another() {
        let at = Conditions { small_rate: 1e-4, ..Conditions::default() };
        let moment = |p: [f64; 3], q: f64| StribeckFriction.moment(&p, &[], q, 0.0, &at);
        let p = [0.03, 0.08, 0.05];
        assert!((moment(p, 1e-3) + 0.08).abs() < 1e-4 && (moment(p, -0.5) - 0.03).abs() < 1e-12);
        assert!((moment(p, 0.05) + 0.03 + 0.05 / 1.0_f64.exp()).abs() < 1e-12);
        assert_eq!(moment(p, 0.0), 0.0);
        assert_eq!(moment([0.08, 0.03, 0.05], 0.01), moment([0.08, 0.08, 0.05], 0.01));
    }
}
