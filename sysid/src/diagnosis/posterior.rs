//! The models that the search has visited, and what all of them together say of each term.
//!
//! ```text
//! P(term) = Σ_{M with the term} P(M | data) / Σ_M P(M | data)
//! ```

use super::another_zero::{is_trim, pulls_aside};
use super::levels::{LAG_HORIZONS_S, PLAUSIBLE};
use super::locate::indistinct;
use super::rotation::all_but_the_same;
use crate::catalogue::shapes::SHAPES;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, weights};
use crate::likelihood::free_run::free_run;
use crate::likelihood::horizon::indistinct_ahead;
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use nalgebra::Vector2;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Share of what a term adds to the predictions by which those of two models differ that say the same.
const SAME_SHARE: f64 = 0.1;

/// A model that was fitted, with what the data say of its parameters.
pub struct Visited {
    /// The fit.
    pub fit: Fit,
    /// Information and scores there.
    pub information: Information,
    /// ln of the prior odds of its terms.
    pub log_prior: f64,
}

/// One term of the model, with what speaks for it.
#[derive(Clone)]
pub struct Finding {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Whether it has a name.
    pub named: bool,
    /// Posterior probability that it is in the model.
    pub probability: f64,
    /// Named candidates in its place that the data cannot rule out: effect, probability, and the model with it.
    pub rivals: Vec<(&'static dyn Effect, f64, usize)>,
    /// Gain of the log posterior by the term: with it against without it. Finite.
    pub log_evidence: f64,
    /// Odds of so large a gain in likelihood by chance (χ², the likelihood ratio divided by κ).
    pub p_value: f64,
    /// Share of what can be closed that is lost without the term: of the gain in evidence of the fullest model over the baseline,
    /// or, for a name that is judged, of the motion 1 s ahead, whichever is more.
    pub share: f64,
    /// The model without it; where that has no finite likelihood, the most probable with some of the other terms.
    pub without: Option<usize>,
}

/// All models that were visited, and which of them are the answer's.
pub struct Selection {
    /// The models.
    pub visited: Vec<Visited>,
    /// The baseline, its parameters estimated again.
    pub baseline: usize,
    /// With the named terms that are needed.
    pub named: usize,
    /// The same with shapes beside them.
    pub extended: usize,
    /// The most probable of all.
    pub fullest: usize,
}

impl Visited {
    /// Places of the unknowns of all terms but those of the background.
    fn own(&self, problem: &Problem<'_>) -> Vec<usize> {
        let effects = &self.fit.effects;
        let physics = (0..effects.len()).filter(|&i| !effects[i].is_background());
        physics.flat_map(|i| self.fit.own_range(problem, i)).collect()
    }

    /// Ids of its shapes, sorted.
    pub fn shapes(&self) -> Vec<&'static str> {
        self.ids(is_shape)
    }

    /// Ids of its named terms, sorted.
    pub fn names(&self) -> Vec<&'static str> {
        self.ids(|effect| !is_shape(effect) && !effect.is_background())
    }

    fn ids(&self, count: impl Fn(&'static dyn Effect) -> bool) -> Vec<&'static str> {
        let counted = self.fit.effects.iter().filter(|effect| count(**effect));
        let mut ids: Vec<&str> = counted.map(|effect| effect.about().id).collect();
        ids.sort_unstable();
        ids
    }

    /// κ of all its terms.
    pub fn divisor(&self, problem: &Problem<'_>) -> f64 {
        self.information.divisor(self.own(problem).into_iter())
    }

    /// κ of the terms that `other` has not.
    pub fn divisor_beyond(&self, problem: &Problem<'_>, other: &Fit) -> f64 {
        let effects = &self.fit.effects;
        let further = (0..effects.len()).filter(|&i| other.position(effects[i].about().id).is_none());
        self.information.divisor(further.flat_map(|i| self.fit.own_range(problem, i)))
    }

    /// Log posterior up to a constant, likelihoods calibrated by `divisor`.
    pub fn log_posterior(&self, problem: &Problem<'_>, divisor: f64) -> f64 {
        self.log_posterior_with(problem, self.fit.criterion(), divisor)
    }

    /// The same with another criterion (that of a part of the data).
    pub fn log_posterior_with(&self, problem: &Problem<'_>, criterion: f64, divisor: f64) -> f64 {
        // what holds a craft that hangs aside is there, if only to the size of the background
        let pulls = pulls_aside(problem, &self.fit.effects);
        let named = self.fit.effects.iter().enumerate();
        let named = named.filter(|(_, e)| !(e.is_background() || is_shape(**e) || pulls && is_trim(**e)));
        let own_of_named = named.flat_map(|(i, _)| self.fit.own_range(problem, i));
        let own = self.own(problem);
        let no_term = self.information.holds_zero(own_of_named, &self.fit.minimum.values)
            || self.information.occam(own.iter().copied(), divisor).is_none();
        if no_term { f64::NEG_INFINITY } else { self.log_posterior_of_any(problem, criterion, divisor) }
    }

    /// The same, also where a term's interval holds zero or a parameter of it stands at a bound: finite. Such a parameter
    /// takes nothing from the evidence.
    fn log_posterior_of_any(&self, problem: &Problem<'_>, criterion: f64, divisor: f64) -> f64 {
        let moving = self.own(problem).into_iter().filter(|&i| self.information.moves(i));
        let background = (0..self.fit.effects.len()).filter(|&i| self.fit.effects[i].is_background());
        // A pole of the background that has gone to its bound is none.
        let of_one = |i| self.information.occam(self.fit.own_range(problem, i), divisor).unwrap_or(0.0);
        let of_background: f64 = background.map(of_one).sum();
        let occam = self.information.occam(moving, divisor).unwrap_or(0.0) + of_background;
        -0.5 * criterion / divisor + occam + self.log_prior
    }
}

impl Selection {
    /// The terms of the model at `place`, the background's left out, largest share first.
    pub fn findings(&self, problem: &Problem<'_>, place: usize) -> Vec<Finding> {
        let model = &self.visited[place];
        let effects = model.fit.effects.iter().enumerate().filter(|(_, e)| !e.is_background());
        let mut findings: Vec<Finding> = effects.map(|(i, &e)| self.finding(problem, place, i, e)).collect();
        findings.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        findings
    }

    /// What the model at `place` gains over the baseline, calibrated by the terms of the fullest model.
    pub fn gain(&self, problem: &Problem<'_>, place: usize) -> f64 {
        let divisor = self.visited[self.fullest].divisor(problem);
        let value = |i: usize| self.visited[i].log_posterior(problem, divisor);
        (value(place) - value(self.baseline)).max(0.0)
    }

    fn finding(&self, problem: &Problem<'_>, place: usize, i: usize, effect: &'static dyn Effect) -> Finding {
        let model = &self.visited[place];
        let own = model.fit.own_range(problem, i);
        let divisor = model.information.divisor(own.clone());
        let has = |v: &Visited| v.fit.position(effect.about().id).is_some();
        // What shapes stand beside it is given: a shape that holds the term as its special case does not speak against it.
        let beside = if is_shape(effect) { None } else { Some(model.shapes()) };
        let counts = |v: &&Visited| beside.as_ref().is_none_or(|beside| v.shapes() == *beside);
        let value = |v: &Visited| v.log_posterior(problem, divisor);
        let top = self.visited.iter().filter(counts).map(value).fold(f64::NEG_INFINITY, f64::max);
        let weight = |v: &Visited| if counts(&v) { (value(v) - top).exp() } else { 0.0 };
        let total: f64 = self.visited.iter().map(weight).sum();
        let probability = self.visited.iter().filter(|v| has(v)).map(weight).sum::<f64>() / total;
        let of_the_rest =
            |v: &Visited| !has(v) && v.fit.effects.iter().all(|e| model.fit.position(e.about().id).is_some());
        // That another term of the rest is none does not speak for this one.
        let any = |v: &Visited| v.log_posterior_of_any(problem, v.fit.criterion(), divisor);
        // All the rest; where that has no finite likelihood, the most probable part of it.
        let size = |i: usize| self.visited[i].fit.effects.len();
        let without = (0..self.visited.len()).filter(|&i| of_the_rest(&self.visited[i])).max_by(|&a, &b| {
            let all = |i: usize| size(i) + 1 == model.fit.effects.len();
            all(a).cmp(&all(b)).then_with(|| any(&self.visited[a]).total_cmp(&any(&self.visited[b])))
        });
        let gain = without.map_or(0.0, |w| any(model) - any(&self.visited[w]));
        let ratio = without.map_or(0.0, |w| self.visited[w].fit.criterion() - model.fit.criterion());
        let further = |w: usize| model.fit.minimum.values.len() - self.visited[w].fit.minimum.values.len();
        let whole = self.gain(problem, self.fullest);
        Finding {
            effect,
            named: !is_shape(effect),
            probability,
            rivals: self.rivals(problem, model, (effect, probability), divisor, |v| weight(v) / total),
            log_evidence: gain,
            p_value: chance(ratio / divisor, without.map_or(own.len(), further)),
            share: if whole > 0.0 { (gain / whole).clamp(0.0, 1.0) } else { 0.0 },
            without,
        }
    }

    /// The model that has `effect` where `other`, which has as many names as `model`, has `rival`.
    fn with_instead(
        &self,
        other: &Fit,
        rival: &dyn Effect,
        effect: &dyn Effect,
        model: &Visited,
    ) -> Option<&Fit> {
        if names(other) != names(&model.fit) {
            return None;
        }
        let kept = other.ids().into_iter().filter(|id| *id != rival.about().id);
        self.fit_of(kept.chain([effect.about().id]))
    }

    /// The model of just these effects.
    fn fit_of(&self, ids: impl Iterator<Item = &'static str>) -> Option<&Fit> {
        let mut wanted: Vec<&str> = ids.collect();
        wanted.sort_unstable();
        self.visited.iter().map(|visited| &visited.fit).find(|fit| {
            let mut ids = fit.ids();
            ids.sort_unstable();
            ids == wanted
        })
    }

    /// Named candidates that stand in the place of `effect`, whose probability is its `own`, alone or with others, in models as
    /// probable as [`PLAUSIBLE`].
    fn rivals(
        &self,
        problem: &Problem<'_>,
        model: &Visited,
        (effect, own): (&'static dyn Effect, f64),
        divisor: f64,
        probability: impl Fn(&Visited) -> f64,
    ) -> Vec<(&'static dyn Effect, f64, usize)> {
        let mut rivals: Vec<(&'static dyn Effect, f64, usize)> = Vec::new();
        for (i, other) in
            self.visited.iter().enumerate().filter(|(_, v)| v.fit.position(effect.about().id).is_none())
        {
            let mut further = other.fit.effects.clone();
            further.retain(|e| model.fit.position(e.about().id).is_none());
            let of_class = |e: &dyn Effect| effect.class().is_some_and(|class| e.class() == Some(class));
            // of several that stand in its place together, that of its class, or what was found first
            let mut named = further.iter().copied().filter(|e| !e.is_background() && !is_shape(*e));
            let Some(rival) = named.clone().find(|e| of_class(*e)).or_else(|| named.next()) else { continue };
            let same_class = of_class(rival);
            let mut p = probability(other);
            let counterpart = self.with_instead(&other.fit, rival, effect, model);
            if let Some(counterpart) = counterpart.filter(|_| further.len() == 1) {
                let neither =
                    self.fit_of(counterpart.ids().into_iter().filter(|id| *id != effect.about().id));
                let same = || {
                    !effect.generalises(rival)
                        && !rival.generalises(effect)
                        && !all_but_the_same(effect, rival)
                        && neither.is_some_and(|neither| {
                            explains_the_same([counterpart, &other.fit], neither, divisor)
                        })
                };
                if same_class || same() {
                    p = p.max(indistinct(problem, counterpart, &other.fit));
                }
                // Without an angle nothing but the noise model tells a lag of the sensor from one of the actuator.
                if same_class && !problem.data.has_angle {
                    p = p.max(alike_ahead(problem, [counterpart, &other.fit], neither));
                    let alike = |neither: &Fit| answers_alike(problem, [counterpart, &other.fit], neither);
                    if p < own && neither.is_some_and(alike) {
                        p = own;
                    }
                }
            }
            match rivals.iter_mut().find(|(known, ..)| known.about().id == rival.about().id) {
                Some(known) if known.1 >= p => {}
                Some(known) => *known = (rival, p, i),
                None => rivals.push((rival, p, i)),
            }
        }
        rivals.retain(|(_, p, _)| *p >= PLAUSIBLE);
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        rivals
    }
}

/// Number of terms with a name.
fn names(fit: &Fit) -> usize {
    fit.effects.iter().filter(|effect| !is_shape(**effect)).count()
}

/// Odds that two models predict alike a while ahead, where what the command does counts and not what the noise did: at the longest
/// of [`LAG_HORIZONS_S`] at which the first is told from one with `neither`. A horizon at which it is not, as a second in a loop and
/// in gusts, tells it from nothing else.
pub fn alike_ahead(problem: &Problem<'_>, [model, rival]: [&Fit; 2], neither: Option<&Fit>) -> f64 {
    let unpack = |fit: &Fit| problem.unpack(&fit.effects, &fit.minimum.values);
    let model = unpack(model);
    let from = |other: &Fit, horizon: f64| {
        indistinct_ahead(problem, [&model, &unpack(other)], &problem.data.places(), horizon).unwrap_or(0.0)
    };
    let tells = |horizon: &f64| neither.is_none_or(|neither| from(neither, *horizon) < PLAUSIBLE);
    from(rival, LAG_HORIZONS_S.into_iter().find(tells).unwrap_or(LAG_HORIZONS_S[0]))
}

/// Whether two models answer the input alike: row by row their free runs change by what differs little from what either adds to one
/// with `neither`. The colour of the noise is then all that tells them apart, and the noise model knows it roughly.
fn answers_alike(problem: &Problem<'_>, [model, rival]: [&Fit; 2], neither: &Fit) -> bool {
    let places = problem.data.places();
    let answer = |fit: &Fit| free_run(problem, &problem.unpack(&fit.effects, &fit.minimum.values), &places);
    let (Some(model), Some(rival), Some(neither)) = (answer(model), answer(rival), answer(neither)) else {
        return false;
    };
    let apart = |other: &[Vec<f64>]| -> f64 {
        let of_place = |(a, b): (&Vec<f64>, &Vec<f64>)| -> f64 {
            let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            differences.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum()
        };
        model.iter().zip(other).map(of_place).sum()
    };
    apart(&rival) < SAME_SHARE * apart(&neither)
}

/// Whether two models' predictions differ by little of what either adds to one with `neither`, and their likelihoods, divided by
/// `divisor`, by less than makes one of them implausible: how wide the catalogue lets each of their terms be is then all that tells
/// them apart, and that is no evidence.
fn explains_the_same([model, rival]: [&Fit; 2], neither: &Fit, divisor: f64) -> bool {
    let (weight, _) = weights(&model.minimum.residuals);
    let apart = |other: &Fit| -> f64 {
        let pairs = model.minimum.residuals.iter().zip(&other.minimum.residuals);
        pairs.map(|(a, b)| Vector2::new(a[0] - b[0], a[1] - b[1])).map(|d| d.dot(&(weight * d))).sum()
    };
    let log_ratio = 0.5 * (model.criterion() - rival.criterion()).abs() / divisor;
    log_ratio < -PLAUSIBLE.ln() && apart(rival) < SAME_SHARE * apart(neither)
}

/// Whether `effect` is several others in other words, all of which are there (`has`): dry friction that differs each way is friction
/// and a constant moment. One that restates a single other does so nearly, and no more.
pub fn is_in_other_words(effect: &dyn Effect, has: impl Fn(&str) -> bool) -> bool {
    let parts = effect.restates();
    parts.len() > 1 && parts.iter().all(|id| has(id))
}

/// Whether an effect is a shape without a name.
pub fn is_shape(effect: &dyn Effect) -> bool {
    SHAPES.iter().any(|shape| shape.about().id == effect.about().id)
}

/// Odds of a gain of 2 log likelihood of `gain` or more by chance, with `parameters` more (likelihood ratio, χ²).
pub fn chance(gain: f64, parameters: usize) -> f64 {
    ChiSquared::new(parameters as f64).map_or(1.0, |chi| chi.sf(gain.max(0.0)))
}

#[cfg(test)]
mod tests;
