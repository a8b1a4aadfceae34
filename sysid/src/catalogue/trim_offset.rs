//! A constant moment: the vehicle is out of trim, or its centre of gravity lies ahead of the pivot.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};

/// M += M0.
pub struct TrimOffset;

impl Effect for TrimOffset {
    fn about(&self) -> About {
        About {
            id: "trim_offset",
            locus: Locus::Actuator,
            sentence: "a constant out-of-trim moment acts on the vehicle",
            equation: "M += M0",
            variable: "constant",
            condition: "all the time, with the same sign",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let reach = 5.0 * data.moment;
        vec![Parameter {
            name: "M0",
            unit: "N m",
            lower: -reach,
            upper: reach,
            scale: Scale::Linear(0.1 * data.moment),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn moves_the_mean(&self) -> bool {
        true
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, _theta: f64, _at: &Conditions) -> f64 {
        p[0]
    }
}
