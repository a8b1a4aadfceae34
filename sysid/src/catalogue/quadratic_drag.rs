//! Drag that grows with the square of the pitch rate.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= D q|q|.
pub struct QuadraticDrag;

impl Effect for QuadraticDrag {
    fn about(&self) -> About {
        About {
            id: "quadratic_drag",
            locus: Locus::PitchMoment,
            sentence: "drag grows with the square of the pitch rate",
            equation: "M -= D q |q|",
            variable: "q",
            condition: "at large pitch rates, growing with the square",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Rate))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 0.1 * data.moment / (data.q * data.q);
        vec![Parameter {
            name: "D",
            unit: "N m s^2/rad^2",
            lower: 0.0,
            upper: 50.0 * unit,
            scale: Scale::Linear(unit),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1 * data.moment / (data.q * data.q)]]
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], q: f64, _theta: f64, _at: &Conditions) -> f64 {
        -p[0] * q * q.abs()
    }
}
