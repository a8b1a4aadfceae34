//! Another axis' command drives this one.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// M += c u_roll(t).
pub struct CrossFeed;

impl Effect for CrossFeed {
    fn about(&self) -> About {
        About {
            id: "cross_feed",
            locus: Locus::Actuator,
            sentence: "the command of the roll axis drives the pitch axis as well",
            equation: "M += c u_roll(t)",
            variable: "u_roll",
            condition: "in proportion to the command of the roll axis",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::RollCommand))
    }
    /// The axes' commands are taken to be of one size.
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 0.1 * data.moment / data.u;
        vec![Parameter {
            name: "c",
            unit: "N m/unit",
            lower: -50.0 * unit,
            upper: 50.0 * unit,
            scale: Scale::Linear(unit),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.varies(|beside| beside.roll_command.as_deref())
    }
    fn moves_the_mean(&self) -> bool {
        true
    }
    fn forcing(&self, p: &[f64], at: &Conditions) -> f64 {
        p[0] * at.roll_command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_in_proportion_to_the_other_command() {
        let at = Conditions { roll_command: -0.02, ..Conditions::default() };
        assert!((CrossFeed.forcing(&[4.0], &at) + 0.08).abs() < 1e-15);
    }
}
