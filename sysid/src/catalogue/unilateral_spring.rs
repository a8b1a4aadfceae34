//! A cable that only pulls.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M −= k s max(0, s (θ − θ0)) with s the sign of θ0: slack up to the angle θ0, a spring beyond it on that side.
pub struct UnilateralSpring;

/// Least and largest angle at which the cable may begin to pull: one that is taut for more than three quarters of the time is a
/// spring.
fn slack(data: &Amplitudes) -> [f64; 2] {
    let [lower, upper, largest] = data.angles;
    let far = (4.0 * data.theta).max(largest);
    [if lower > 0.0 { lower } else { -far }, if upper < 0.0 { upper } else { far }]
}

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
                lower: slack(data)[0],
                upper: slack(data)[1],
                scale: Scale::Linear(0.1 * data.theta),
            },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let unit = data.moment / data.theta;
        let [low, high] = slack(data);
        let within = |theta_0: &f64| low < *theta_0 && *theta_0 < high;
        let aside = if low > 0.0 { low } else { high.min(0.0) };
        let starts = [-1.2, -0.4, 0.4, 1.2].map(|share| aside + share * data.theta);
        starts.into_iter().filter(within).map(|theta_0| vec![0.5 * unit, theta_0]).collect()
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

    #[test]
    fn a_cable_is_slack_for_a_quarter_of_the_time_at_the_least() {
        let slack = |angles: [f64; 3]| {
            let data = Amplitudes { theta: 0.1, moment: 1.0, angles, ..Amplitudes::default() };
            let starts = UnilateralSpring.starts(&data);
            let [low, high] = slack(&data);
            assert!(!starts.is_empty() && starts.iter().all(|start| low < start[1] && start[1] < high));
            [low, high]
        };
        assert_eq!(slack([-0.05, 0.05, 0.2]), [-0.4, 0.4], "about level");
        assert_eq!(slack([0.25, 0.35, 0.6]), [0.25, 0.6], "aside: three quarters of the time beyond 0.25");
        assert_eq!(slack([-0.35, -0.25, 0.6]), [-0.6, -0.25], "on the other side");
    }
}
