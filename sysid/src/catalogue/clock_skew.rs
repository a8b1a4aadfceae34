//! Input and output are stamped by two clocks.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Scale};

/// With fewer changes of the input the delay could differ from one way to the other as well.
const FEWEST_CHANGES: usize = 4;

/// u_logged(t) = u(t (1 + ε)): the apparent delay is τ + ε t.
pub struct ClockSkew;

impl Effect for ClockSkew {
    fn about(&self) -> About {
        About {
            id: "clock_skew",
            locus: Locus::Timing,
            sentence: "input and output are stamped by two clocks that drift apart",
            equation: "u(t - tau - epsilon t)",
            variable: "t",
            condition: "more and more towards the end of the recording, after each switch of the input",
        }
    }
    /// A line through the delays of a few steps, of which some go up and some down, is no drift.
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.changes_of_input() >= FEWEST_CHANGES
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "epsilon",
            unit: "s/s",
            lower: -0.01,
            upper: 0.01,
            scale: Scale::Linear(1e-4),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        [5e-4, -5e-4, 1.5e-3, -1.5e-3, 2.5e-3, -2.5e-3].map(|epsilon| vec![epsilon]).to_vec()
    }
    /// Two clocks have an offset as well, and a log that holds the latest value is late by a share of a sample: a constant
    /// delay within a sample is theirs.
    fn accounts_for(&self, other: &dyn Effect, p: &[f64], data: &Amplitudes) -> bool {
        let constant = other.class() == Some(Class::Phase) && other.about().locus == Locus::Timing;
        constant && p.iter().all(|delay| delay.abs() <= data.step)
    }
    fn delay(&self, p: &[f64], at: &Conditions) -> f64 {
        p[0] * at.t
    }
}
