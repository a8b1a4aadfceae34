//! A background that falls off faster than two poles do.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};
use crate::model::noise::Third;

/// T ẇ = −w + M_w, M += w: the coloured disturbance passes one more low pass. It is a fact about the day and no finding.
pub struct RollOff;

impl Effect for RollOff {
    fn about(&self) -> About {
        About {
            id: "roll_off",
            locus: Locus::Environment,
            sentence: "the background falls off with a third pole",
            equation: "T dw/dt = -w + disturbance, M += w",
            variable: "t",
            condition: "at high frequencies, whatever the input does",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "T", unit: "s", lower: data.step, upper: 2.0, scale: Scale::Log }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1], vec![0.3]]
    }
    fn applies(&self, _baseline: &Baseline, _data: &Dataset) -> bool {
        false
    }
    fn is_background(&self) -> bool {
        true
    }
    fn noise(&self, p: &[f64]) -> Option<Third> {
        Some(Third::RollOff { time_constant: p[0] })
    }
}
