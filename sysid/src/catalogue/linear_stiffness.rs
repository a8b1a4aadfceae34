//! A spring that is straight.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= k θ. Over small angles gravity says the same, and is what a craft on a pivot has.
pub struct LinearStiffness;

impl Effect for LinearStiffness {
    fn about(&self) -> About {
        About {
            id: "linear_stiffness",
            locus: Locus::PitchMoment,
            sentence: "a straight spring pulls back (a torsion wire, rubber, a cable)",
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
        let unit = 0.1 * data.moment / data.theta;
        vec![Parameter {
            name: "k",
            unit: "N m/rad",
            lower: -50.0 * unit,
            upper: 200.0 * unit,
            scale: Scale::Linear(unit),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1 * data.moment / data.theta], vec![data.moment / data.theta]]
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        -p[0] * theta
    }
}
