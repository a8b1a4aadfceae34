//! "Not in my catalogue": whether terms without a name explain what the named effects leave.

use super::search::screen;
use super::selection::{Selection, odds};
use crate::catalogue::shapes::{SHAPES, Shape};
use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use rayon::prelude::*;

/// Terms that are fitted to the end, of all that were screened.
const FITTED: usize = 2;

/// What the best terms without a name do, beside the named effects and in their place.
#[derive(Clone)]
pub struct Leftover {
    /// The term that adds most to the named effects.
    pub term: &'static Shape,
    /// The named effects with the term.
    pub with: Fit,
    /// BIC of the named effects less BIC with the term.
    pub delta_bic: f64,
    /// Gain of 2 log likelihood by the term, as a share of what named effects and term gain together.
    pub share: f64,
    /// Odds of so large a gain in likelihood by chance (likelihood ratio, χ²).
    pub p_value: f64,
    /// The best term in place of all named effects.
    pub instead: Option<(&'static Shape, Fit)>,
}

/// The terms without a name that explain most of what the selection leaves, and most of what it explains.
pub fn leftover(problem: &Problem<'_>, selection: &Selection) -> Option<Leftover> {
    let Selection { baseline, extended: named, findings } = selection;
    let (term, with) = best(problem, named)?;
    let instead = if findings.is_empty() { None } else { best(problem, baseline) };
    let total = baseline.criterion() - with.criterion();
    let own = named.criterion() - with.criterion();
    Some(Leftover {
        delta_bic: named.bic(problem) - with.bic(problem),
        share: if total > 0.0 { own / total } else { 0.0 },
        p_value: odds(own, term.parameters(&problem.sizes).len()),
        term,
        with,
        instead,
    })
}

/// `before` with the term without a name that lowers the BIC most.
fn best(problem: &Problem<'_>, before: &Fit) -> Option<(&'static Shape, Fit)> {
    let candidates: Vec<&'static dyn Effect> = SHAPES.iter().map(|&a| a as &'static dyn Effect).collect();
    let mut screened = screen(problem, before, &candidates);
    screened.truncate(FITTED);
    let fits: Vec<Fit> = screened.par_iter().filter_map(|p| refit(problem, &p.effects, &p.values)).collect();
    let fit = fits.into_iter().min_by(|a, b| a.bic(problem).total_cmp(&b.bic(problem)))?;
    let id = fit.effects.last()?.about().id;
    Some((SHAPES.iter().copied().find(|a| a.about().id == id)?, fit))
}
