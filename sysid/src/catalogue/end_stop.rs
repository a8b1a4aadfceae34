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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_is_free_for_a_quarter_of_the_time_at_the_least() {
        let free = |angles: [f64; 3]| {
            let data = Amplitudes { theta: 0.1, moment: 1.0, angles, ..Amplitudes::default() };
            let [stop, _] = EndStop.parameters(&data).try_into().unwrap_or_else(|_| panic!());
            let starts = EndStop.starts(&data);
            assert!(starts.iter().all(|start| stop.lower < start[0] && start[0] < stop.upper), "{starts:?}");
            [stop.lower, stop.upper]
        };
        assert_eq!(free([-0.05, 0.05, 0.2]), [0.03, 0.4], "about level");
        assert_eq!(free([0.25, 0.35, 0.6]), [0.25, 0.6], "aside: three quarters of the time beyond 0.25");
        assert_eq!(free([-0.35, -0.25, 0.6]), [0.25, 0.6], "on the other side");
    }
}
