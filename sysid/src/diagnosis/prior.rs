//! What is believed of a model before the data are seen.
//!
//! ```text
//! prior(term) = ½ · ⅔ / named   or   ½ · ⅓ / shapes
//! ```

use super::posterior::is_shape;
use crate::model::effect::Effect;

/// Prior probability that a further term is missing: half for nothing.
pub const FURTHER_TERM: f64 = 0.5;
/// Prior share of the named terms among those that may be missing: two to one against the shapes without a name.
pub const NAMED: f64 = 2.0 / 3.0;

/// ln of the prior odds of a model with the terms `effects`, where `named` terms and so many `shapes` can be asked for.
pub fn log_prior(effects: &[&'static dyn Effect], named: &[&'static dyn Effect], shapes: usize) -> f64 {
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
    effects.iter().map(of).sum()
}
