//! A cable that only pulls.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= k s max(0, s (θ − θ0)) with s the sign of θ0: slack up to the angle θ0, a spring beyond it on that side.
pub struct UnilateralSpring;

impl Effect for UnilateralSpring {
    fn about(&self) -> About {
        About {
            id: "unilateral_spring",
            locus: Locus::PitchMoment,
            sentence: "a cable pulls beyond an angle on one side, and is slack before",
            equation: "M -= k s max(0, s (theta - theta_0)), s = sign(theta_0)",
            variable: "theta",
            condition: "beyond the angle at which the cable is taut, on one side",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = data.moment / data.theta;
        vec![
            Parameter {
                name: "k",
                unit: "N m/rad",
                lower: 0.01 * unit,
                upper: 1e3 * unit,
                scale: Scale::Log,
            },
            Parameter {
                name: "theta_0",
                unit: "rad",
                lower: -4.0 * data.theta,
                upper: 4.0 * data.theta,
                scale: Scale::Linear(0.1 * data.theta),
            },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let unit = data.moment / data.theta;
        [-1.2, -0.4, 0.4, 1.2].map(|share| vec![0.5 * unit, share * data.theta]).to_vec()
    }
    fn acts_at(&self) -> Option<usize> {
        Some(1)
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, theta: f64, _at: &Conditions) -> f64 {
        let beyond = theta - p[1];
        if beyond * p[1] > 0.0 { -p[0] * beyond } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pulls_on_its_side_only() {
        let moment = |theta_0: f64, theta: f64| {
            UnilateralSpring.moment(&[3.0, theta_0], &[], 0.0, theta, &Conditions::default())
        };
        assert!((moment(0.1, 0.3) + 0.6).abs() < 1e-12 && (moment(-0.1, -0.3) - 0.6).abs() < 1e-12);
        assert_eq!([moment(0.1, 0.05), moment(0.1, -0.3), moment(-0.1, 0.3), moment(-0.1, -0.05)], [0.0; 4]);
    }
}
