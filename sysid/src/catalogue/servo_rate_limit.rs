//! The collective servo slews no faster than a limit.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale};

/// |u̇_a| ≤ r.
pub struct ServoRateLimit;

impl Effect for ServoRateLimit {
    fn about(&self) -> About {
        About {
            id: "servo_rate_limit",
            locus: Locus::Actuator,
            sentence: "the servo slews no faster than a limit",
            equation: "|du_a/dt| <= r",
            variable: "u_rate",
            condition: "for as long after a switch of the input as the slew takes",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "r",
            unit: "rad/s",
            lower: 0.2 * data.u,
            upper: 2.0 * data.u / data.step,
            scale: Scale::Log,
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [2.0, 8.0, 25.0].map(|per_second| vec![per_second * data.u]).to_vec()
    }
    fn states(&self) -> usize {
        1
    }
    /// A ramp towards the command; the mean counts the part of the step after the command is reached.
    fn actuate(&self, p: &[f64], s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        let before = s[0];
        let reach = p[0] * at.dt;
        let wanted = u - before;
        if wanted.abs() > reach {
            s[0] = before + reach.copysign(wanted);
            return 0.5 * (before + s[0]);
        }
        s[0] = u;
        let ramp = wanted.abs() / reach;
        u - 0.5 * ramp * wanted
    }
}
