//! Which effects the data ask for: forward selection by likelihood, pruned backward, with the rivals of each.

use super::search::fit_one_more;
use crate::catalogue::CATALOGUE;
use crate::likelihood::fit::{Fit, fit_baseline, refit, settled};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// An effect is added when it lowers the BIC by more than this. Calibrated on simulated recordings without any
/// effect, at all levels of disturbance.
pub const DETECTION: f64 = 10.0;
/// A further effect beside one that was found needs more: the first one's equation is idealised, and small terms mend it.
const FURTHER: f64 = 14.0;
/// An effect stays when taking it out raises the BIC by more than this.
pub const RETENTION: f64 = 6.0;
/// Candidates from whose values the baseline is fitted again.
const BASELINE_STARTS: usize = 3;
/// Most effects that one diagnosis adds.
const MOST_EFFECTS: usize = 3;
/// Rivals at least this probable are told.
pub const PLAUSIBLE: f64 = 0.05;

/// One effect that was added, with what speaks for it.
#[derive(Clone)]
pub struct Finding {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Posterior probability among all candidates in its place, the other effects given.
    pub probability: f64,
    /// Candidates that the data cannot rule out, with their probabilities.
    pub rivals: Vec<(&'static dyn Effect, f64)>,
    /// Fits with each of the rivals in its place.
    pub rival_fits: Vec<Fit>,
    /// BIC without the effect less BIC with it.
    pub delta_bic: f64,
    /// Odds of so large a gain in likelihood by chance (likelihood ratio, χ²).
    pub p_value: f64,
}

/// The outcome of the selection.
pub struct Selection {
    /// The baseline, its parameters estimated again.
    pub baseline: Fit,
    /// The baseline with all findings.
    pub extended: Fit,
    /// The findings, largest contribution first.
    pub findings: Vec<Finding>,
}

/// Selects effects. `None` where not even the baseline has a finite likelihood.
pub fn select(problem: &Problem<'_>, progress: &(dyn Fn(&str) + Sync)) -> Option<Selection> {
    progress("fitting the baseline");
    let mut current = fit_baseline(problem)?;
    let mut rounds: Vec<Round> = Vec::new();
    for round in 0..MOST_EFFECTS {
        progress(&format!("trying the catalogue's effects on top of {}", told(&current)));
        let tried = one_more(problem, &current);
        let needed = if round == 0 { DETECTION } else { FURTHER };
        let bic = tried.before.bic(problem);
        let best = tried.fits.first().filter(|fit| bic - fit.bic(problem) > needed);
        current = best.map_or_else(|| tried.before.clone(), |best| settled(problem, best.clone()));
        let ended = best.is_none();
        rounds.push(tried);
        if ended {
            break;
        }
    }
    progress("checking which effects are needed");
    let mut extended = prune(problem, current);
    loop {
        match findings(problem, &rounds, &extended) {
            Examined::Needed(findings) => {
                return Some(Selection { baseline: rounds.swap_remove(0).before, extended, findings });
            }
            Examined::Needless(rest) => extended = *rest,
        }
    }
}

/// A model with each effect of the catalogue that it lacks.
#[derive(Clone)]
struct Round {
    before: Fit,
    /// With one more effect, the last one; best first.
    fits: Vec<Fit>,
}

/// What a closer look at each effect says: all are needed, or a fit without one of them is as good.
enum Examined {
    Needed(Vec<Finding>),
    Needless(Box<Fit>),
}

fn told(fit: &Fit) -> String {
    if fit.effects.is_empty() { "the baseline".into() } else { fit.ids().join(" + ") }
}

/// `before` with each effect of the catalogue that it lacks, best first; and `before` itself, fitted again from where
/// the candidates ended: a baseline that has not settled makes every candidate look good.
fn one_more(problem: &Problem<'_>, before: &Fit) -> Round {
    let missing: Vec<&'static dyn Effect> = CATALOGUE
        .iter()
        .copied()
        .filter(|candidate| candidate.applies(problem.baseline, problem.data))
        .filter(|candidate| before.effects.iter().all(|e| e.about().id != candidate.about().id))
        .collect();
    let fits = fit_one_more(problem, before, &missing);
    let length = before.minimum.values.len();
    let again: Vec<Fit> = fits
        .par_iter()
        .take(BASELINE_STARTS)
        .filter_map(|fit| refit(problem, &before.effects, &fit.minimum.values[..length]))
        .collect();
    let best = again.into_iter().fold(before.clone(), lower);
    Round { before: best, fits }
}

fn lower(a: Fit, b: Fit) -> Fit {
    if b.criterion() < a.criterion() { b } else { a }
}

/// Takes out, one after the other, effects that the others have made needless.
fn prune(problem: &Problem<'_>, mut fit: Fit) -> Fit {
    while fit.effects.len() > 1 {
        let weakest = (0..fit.effects.len())
            .filter_map(|i| without(problem, &fit, i))
            .min_by(|a, b| a.bic(problem).total_cmp(&b.bic(problem)));
        match weakest {
            Some(less) if less.bic(problem) - fit.bic(problem) < RETENTION => fit = less,
            _ => break,
        }
    }
    fit
}

/// `fit` without its `i`-th effect, fitted again.
pub fn without(problem: &Problem<'_>, fit: &Fit, i: usize) -> Option<Fit> {
    let mut effects = fit.effects.clone();
    let mut values = fit.minimum.values.clone();
    values.drain(fit.own_range(problem, i));
    effects.remove(i);
    refit(problem, &effects, &values)
}

fn findings(problem: &Problem<'_>, rounds: &[Round], extended: &Fit) -> Examined {
    let mut findings = Vec::new();
    for (i, &effect) in extended.effects.iter().enumerate() {
        let others: Vec<&str> = extended.ids().into_iter().filter(|id| *id != effect.about().id).collect();
        let same = |round: &&Round| {
            let ids = round.before.ids();
            ids.len() == others.len() && ids.iter().all(|id| others.contains(id))
        };
        let Round { before: rest, fits: rivals } =
            match (rounds.iter().find(same), without(problem, extended, i)) {
                (Some(round), None) => round.clone(),
                (Some(round), Some(less)) => {
                    Round { before: lower(round.before.clone(), less), fits: round.fits.clone() }
                }
                (None, Some(less)) => one_more(problem, &less),
                // The others alone leave no finite likelihood: this one is judged against the baseline.
                (None, None) => Round { before: rounds[0].before.clone(), fits: Vec::new() },
            };
        let finding = finding(problem, effect, extended, &rest, rivals);
        if finding.delta_bic < RETENTION {
            return Examined::Needless(Box::new(rest));
        }
        findings.push(finding);
    }
    findings.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
    Examined::Needed(findings)
}

fn finding(
    problem: &Problem<'_>,
    effect: &'static dyn Effect,
    extended: &Fit,
    rest: &Fit,
    mut candidates: Vec<Fit>,
) -> Finding {
    let is_it = |fit: &Fit| fit.effects.last().is_some_and(|e| e.about().id == effect.about().id);
    candidates.retain(|fit| !is_it(fit) && fit.effects.len() == extended.effects.len());
    let best = extended.bic(problem);
    let weight = |fit: &Fit| (-0.5 * (fit.bic(problem) - best)).exp();
    let total = 1.0 + weight(rest) + candidates.iter().map(weight).sum::<f64>();
    let mut rivals: Vec<(f64, Fit)> = candidates.into_iter().map(|fit| (weight(&fit) / total, fit)).collect();
    rivals.retain(|(probability, _)| *probability >= PLAUSIBLE);
    let parameters = effect.parameters(&problem.sizes).len();
    let gain = rest.criterion() - extended.criterion();
    Finding {
        effect,
        probability: 1.0 / total,
        rivals: rivals.iter().filter_map(|(p, fit)| Some((*fit.effects.last()?, *p))).collect(),
        rival_fits: rivals.into_iter().map(|(_, fit)| fit).collect(),
        delta_bic: rest.bic(problem) - best,
        p_value: odds(gain, parameters),
    }
}

/// Odds of a gain of 2 log likelihood of `gain` or more by chance, with `parameters` more (likelihood ratio, χ²).
pub fn odds(gain: f64, parameters: usize) -> f64 {
    ChiSquared::new(parameters as f64).map_or(1.0, |chi| chi.sf(gain.max(0.0)))
}
