//! Dry friction in the pivot.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= Mc sign q, sticks at rest.
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn about(&self) -> About {
        About {
            id: "coulomb_friction",
            locus: Locus::PitchMoment,
            sentence: "dry friction in the pivot opposes the motion",
            equation: "M -= Mc sign(q), sticks at rest",
            variable: "q",
            condition: "when the pitch rate changes sign",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Coulomb, 1785")
    }
    fn class(&self) -> Option<Class> {
        Some(Class::SmallSignals)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Rate))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 0.1 * data.moment;
        vec![Parameter {
            name: "Mc",
            unit: "N m",
            lower: 0.0,
            upper: 30.0 * unit,
            scale: Scale::Linear(unit),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1 * data.moment]]
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], q: f64, _theta: f64, at: &Conditions) -> f64 {
        -p[0] * (q / at.small_rate).tanh()
    }
    fn friction(&self, p: &[f64], _q: f64) -> Option<f64> {
        Some(p[0])
    }
}
