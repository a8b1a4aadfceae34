//! "Not in my catalogue": whether terms without a name explain what the named effects leave.

use super::anonymous::{ANONYMOUS, Anonymous};
use super::effects::Effect;
use super::problem::Problem;
use super::rank::Selection;
use super::search::{Fit, refit, screen};
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Terms that are fitted to the end, of all that were screened.
const FITTED: usize = 2;

/// What the best term without a name adds to the named effects.
#[derive(Clone)]
pub struct Leftover {
    /// The term.
    pub term: &'static Anonymous,
    /// The named effects with the term.
    pub with: Fit,
    /// The term alone on top of the baseline.
    pub alone: Option<Fit>,
    /// BIC of the named effects less BIC with the term.
    pub delta_bic: f64,
    /// Gain of 2 log likelihood by the term, as a share of what named effects and term gain together.
    pub share: f64,
    /// Odds of so large a gain in likelihood by chance (likelihood ratio, χ²).
    pub p_value: f64,
}

/// The term without a name that explains most of what the selection leaves.
pub fn leftover(problem: &Problem<'_>, selection: &Selection) -> Option<Leftover> {
    let named = &selection.extended;
    let candidates: Vec<&'static dyn Effect> = ANONYMOUS.iter().map(|&a| a as &'static dyn Effect).collect();
    let mut screened = screen(problem, named, &candidates);
    screened.truncate(FITTED);
    let fits: Vec<Fit> =
        screened.par_iter().filter_map(|(effects, values)| refit(problem, effects, values)).collect();
    let with = fits.into_iter().min_by(|a, b| a.bic(problem).total_cmp(&b.bic(problem)))?;
    let id = with.effects.last()?.about().id;
    let term = ANONYMOUS.iter().copied().find(|a| a.about().id == id)?;
    let alone = if named.effects.is_empty() {
        None
    } else {
        let mut values = selection.baseline.minimum.values.clone();
        values.extend_from_slice(&with.minimum.values[with.own_range(problem, with.effects.len() - 1)]);
        refit(problem, &[term as &'static dyn Effect], &values)
    };
    let total = selection.baseline.criterion() - with.criterion();
    let own = named.criterion() - with.criterion();
    Some(Leftover {
        term,
        delta_bic: named.bic(problem) - with.bic(problem),
        share: if total > 0.0 { own / total } else { 0.0 },
        p_value: ChiSquared::new(term.parameters(&problem.sizes).len() as f64)
            .map_or(1.0, |chi| chi.sf(own.max(0.0))),
        with,
        alone,
    })
}
