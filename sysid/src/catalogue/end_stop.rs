//! Contact beyond an angle.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= ks (|θ| − θs) sign θ for |θ| > θs.
pub struct EndStop;

/// Least angle of a stop: one that is touched for more than three quarters of the time is no stop, but a spring.
fn free(data: &Amplitudes) -> f64 {
    let [lower, upper, _] = data.angles;
    (0.3 * data.theta).max(lower).max(-upper)
}

impl Effect for EndStop {
    fn about(&self) -> About {
        About {
            id: "end_stop",
            locus: Locus::PitchMoment,
            sentence: "the vehicle runs against an elastic stop beyond an angle",
            equation: "M -= ks (|theta| - theta_s) sign(theta) for |theta| > theta_s",
            variable: "theta",
            condition: "beyond the angle of the stop",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::LargeAngles)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = data.moment / data.theta;
        vec![
            Parameter {
                name: "theta_s",
                unit: "rad",
                lower: free(data),
                upper: (4.0 * data.theta).max(data.angles[2]),
                scale: Scale::Linear(0.1 * data.theta),
            },
            Parameter {
                name: "ks",
                unit: "N m/rad",
                lower: 0.01 * unit,
                upper: 1e3 * unit,
                scale: Scale::Log,
            },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let unit = data.moment / data.theta;
        [0.4, 0.9, 1.5].map(|share| vec![free(data) + share * data.theta, unit]).to_vec()
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        -p[1] * (theta - theta.clamp(-p[0], p[0]))
    }
}
