//! The centre of gravity lies below the pivot (or above it).

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= G sin θ; G < 0 where the centre of gravity lies above the pivot.
///
/// Of a body with the radius of gyration r gravity makes no more of its inertia than m g l/(m (r² + l²)) ≤ g/2r, wherever the pivot
/// is: what is stiffer is a spring.
pub struct GravityStiffness;

/// The largest |G| per inertia, 1/s²: of a radius of gyration of 1 cm, which is less than any rig has.
pub const STIFFEST: f64 = 490.0;

impl Effect for GravityStiffness {
    fn about(&self) -> About {
        About {
            id: "gravity_stiffness",
            locus: Locus::PitchMoment,
            sentence: "the centre of gravity lies off the pivot and gravity acts as a spring",
            equation: "M -= G sin(theta)",
            variable: "theta",
            condition: "in proportion to the pitch angle, at low frequency",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let most = STIFFEST * data.inertia;
        let stiffness = stiffness("G", "N m", &within_a_turn(data));
        let [lower, upper] = [stiffness.lower, stiffness.upper].map(|bound| bound.clamp(-most, most));
        vec![Parameter { lower, upper, ..stiffness }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let most = STIFFEST * data.inertia;
        let within = |(start, share): (Vec<f64>, f64)| vec![start[0].min(share * most)];
        starts_of_stiffness(&within_a_turn(data)).into_iter().zip([0.3, 0.7]).map(within).collect()
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        -p[0] * theta.sin()
    }
}

/// Of a body that turns over, gravity sees no more than the sine of its angle.
fn within_a_turn(data: &Amplitudes) -> Amplitudes {
    Amplitudes { theta: data.theta.min(1.0), ..*data }
}

/// A stiffness of either sign, by the moments that act over the angle.
pub(super) fn stiffness(name: &'static str, unit: &'static str, data: &Amplitudes) -> Parameter {
    let usual = 0.1 * data.acting() / data.theta;
    Parameter { name, unit, lower: -50.0 * usual, upper: 200.0 * usual, scale: Scale::Linear(usual) }
}

/// Where the search for one starts.
pub(super) fn starts_of_stiffness(data: &Amplitudes) -> Vec<Vec<f64>> {
    vec![vec![0.1 * data.acting() / data.theta], vec![data.acting() / data.theta]]
}
