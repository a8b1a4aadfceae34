//! A cable or umbilical that stiffens.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= k3 θ³.
pub struct CubicStiffness;

impl Effect for CubicStiffness {
    fn about(&self) -> About {
        About {
            id: "cubic_stiffness",
            locus: Locus::PitchMoment,
            sentence: "a cable (or another spring) stiffens with the angle",
            equation: "M -= k3 theta^3",
            variable: "theta",
            condition: "at large pitch angles",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::LargeAngles)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 0.1 * data.moment / data.theta.powi(3);
        vec![Parameter {
            name: "k3",
            unit: "N m/rad^3",
            lower: 0.0,
            upper: 100.0 * unit,
            scale: Scale::Linear(unit),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.1, 0.5].map(|share| vec![share * data.moment / data.theta.powi(3)]).to_vec()
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        -p[0] * theta.powi(3)
    }
}
