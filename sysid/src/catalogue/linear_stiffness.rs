//! A spring that is straight.

use super::gravity_stiffness::{starts_of_stiffness, stiffness};
use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Signal};

/// M −= k θ. Over small angles gravity says the same, and is what a craft on a pivot has.
pub struct LinearStiffness;

impl Effect for LinearStiffness {
    fn about(&self) -> About {
        About {
            id: "linear_stiffness",
            locus: Locus::PitchMoment,
            sentence: "a straight spring pulls back (a torsion wire, rubber, a cable), or the drive holds a position by itself",
            equation: "M -= k theta",
            variable: "theta",
            condition: "in proportion to the pitch angle, at low frequency",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn restates(&self) -> &'static [&'static str] {
        &["gravity_stiffness"]
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![stiffness("k", "N m/rad", data)]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        starts_of_stiffness(data)
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        -p[0] * theta
    }
}
