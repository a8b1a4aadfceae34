//! What is believed of a model before the data are seen.
//!
//! ```text
//! prior(term) = ½ · ⅔ / named   or   ½ · ⅓ / shapes
//! ```
//!
//! The constant moment that holds a craft aside is no further term: nine in ten such craft have one ([`super::another_zero`]).

use super::another_zero::{is_trim, log_prior_of_trim, pulls_aside};
use super::posterior::is_shape;
use super::selection::Candidates;
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;

/// Prior probability that a further term is missing: half for nothing.
pub const FURTHER_TERM: f64 = 0.5;
/// Prior share of the named terms among those that may be missing: two to one against the shapes without a name.
pub const NAMED: f64 = 2.0 / 3.0;

/// ln of the prior odds of a model with the terms `effects`, where `candidates` can be asked for.
pub fn log_prior(problem: &Problem<'_>, effects: &[&'static dyn Effect], candidates: &Candidates) -> f64 {
    let (named, shapes) = (&candidates.named, candidates.shapes.len());
    let pulls = pulls_aside(problem, effects);
    let of = |effect: &&'static dyn Effect| {
        if effect.is_background() {
            return FURTHER_TERM.ln();
        }
        let share =
            if is_shape(*effect) { (1.0 - NAMED) / shapes as f64 } else { NAMED / named.len().max(1) as f64 };
        // A term that holds another as its special case says two things.
        let said = if named.iter().any(|simple| effect.generalises(*simple)) { 2.0 } else { 1.0 };
        said * (FURTHER_TERM * share).ln()
    };
    let terms = effects.iter().filter(|effect| !(pulls && is_trim(**effect))).map(of).sum::<f64>();
    if pulls { terms + log_prior_of_trim(effects) } else { terms }
}
