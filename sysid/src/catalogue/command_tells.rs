//! A controller's commands as a further reading of the motion.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};

/// x̂ += g n(k) for q, x₁ and x₂, n(k) what is [new](Dataset::has_command_news) in the command: what the controller knew of
/// the motion beyond the log. It is a fact about the log and no finding.
pub struct CommandTells;

/// Size of g that a step of the search tries, for q, and for a moment as a share of what acts relative to what moves.
const USUAL: f64 = 0.01;
/// Largest g, in such steps.
const MOST: f64 = 1e4;

impl Effect for CommandTells {
    fn about(&self) -> About {
        About {
            id: "command_tells",
            locus: Locus::Environment,
            sentence: "the controller knows more of the motion than the log",
            equation: "x += g n, n what is new in u",
            variable: "u",
            condition: "wherever the controller answers",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let gain = |name, step: f64| Parameter {
            name,
            unit: "1",
            lower: -MOST * step,
            upper: MOST * step,
            scale: Scale::Linear(step),
        };
        let moment = USUAL * data.acting() / data.q;
        vec![gain("rate", USUAL), gain("x1", moment), gain("x2", moment)]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0; 3]]
    }
    fn applies(&self, _baseline: &Baseline, _data: &Dataset) -> bool {
        false
    }
    fn is_background(&self) -> bool {
        true
    }
    fn corrects(&self, p: &[f64]) -> Option<[f64; 3]> {
        Some([p[0], p[1], p[2]])
    }
}
