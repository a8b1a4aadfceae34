//! Which terms the data ask for: every model that the search visits gets one number, its log evidence, and every
//! probability of the answer is a posterior over all of them.
//!
//! ```text
//! ln P(M | data) = ln E(M) + Σ_terms ln prior(term) + const
//! ```
//!
//! E is the calibrated evidence of [`crate::likelihood::evidence`], the prior that of [`super::prior`]. A term is added while that
//! raises the posterior; then every term is dropped, and exchanged for every other, until no such step does.

use super::another_zero::{about_another_zero, about_zero};
use super::change_point::best_moment;
use super::excerpt::{carried, excerpt};
use super::input_hold::shapes_the_answer;
use super::levels::{MOST_TERMS, PLAUSIBLE};
use super::posterior::{Selection, Visited, is_shape};
use super::prior::{log_prior, log_prior_of_spring};
use super::rotation::all_but_the_same;
use super::search::{Prospect, fit_one_more, screen};
use crate::catalogue::command_tells::CommandTells;
use crate::catalogue::roll_off::RollOff;
use crate::catalogue::shapes::SHAPES;
use crate::catalogue::slow_moment::SlowMoment;
use crate::dataset::Place;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, SKETCH, fit as fit_from, fit_afresh, refit, settled};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use crate::progress::{Progress, Step};
use rayon::prelude::*;

mod drift;
mod simpler;

/// Candidates from whose noise models the model before is fitted again: one that has not settled makes every candidate look
/// good.
const FITTED_AGAIN: usize = 3;
/// Rounds of dropping and exchanging.
const MOST_EXCHANGES: usize = 4;
/// Shapes that are fitted to the end, of all that were screened.
const SHAPES_FITTED: usize = 2;
/// Shapes in one model.
const MOST_SHAPES: usize = 2;
/// Share of what the names gain that a sketch of a shape must gain to be followed.
const NEAR: f64 = 0.5;
/// A log posterior that differs by less is the same: minima are found to about a tenth of that.
const SAME: f64 = 0.3;

/// Candidates of the catalogue that can be asked for with these data.
pub struct Candidates {
    /// Those of the catalogue.
    pub named: Vec<&'static dyn Effect>,
    /// Those without a name.
    pub shapes: Vec<&'static dyn Effect>,
}

impl Candidates {
    /// Those of `catalogue` that apply and that the baseline lacks, and all shapes; where the outputs were smoothed, none that they
    /// are like.
    pub fn new(problem: &Problem<'_>, catalogue: &[&'static dyn Effect]) -> Self {
        let known =
            |e: &dyn Effect| problem.baseline.terms.iter().any(|term| term.effect.about().id == e.about().id);
        let hidden = |e: &dyn Effect| problem.data.is_smoothed() && shapes_the_answer(e);
        let applies =
            |e: &&'static dyn Effect| e.applies(problem.baseline, problem.data) && !known(*e) && !hidden(*e);
        let named = catalogue.iter().copied().filter(applies).collect();
        let shapes = SHAPES.iter().map(|&s| s as &'static dyn Effect).filter(|e| !hidden(*e)).collect();
        Self { named, shapes }
    }

    /// The named ones that begin to act at some moment.
    pub fn acting_from_a_moment(&self) -> Vec<&'static dyn Effect> {
        self.named.iter().copied().filter(|effect| effect.begins_at().is_some()).collect()
    }
}

/// A model with each candidate that it lacks.
pub struct Round {
    before: usize,
    after: Vec<usize>,
}

/// The search, with all that it has visited.
pub struct Search<'p, 'd> {
    /// What is searched on.
    pub problem: &'p Problem<'d>,
    /// What is searched for.
    pub candidates: Candidates,
    parts: &'p [Vec<Place>],
    /// The models.
    pub visited: Vec<Visited>,
    rounds: Vec<Round>,
    progress: &'p Progress<'p>,
    /// What is being done now.
    doing: String,
}

/// Selects terms on top of the baseline's fit. `parts` are the parts of the data that will be held out in turn. `None` where the
/// baseline has no finite derivatives.
pub fn select(
    problem: &Problem<'_>,
    baseline: Fit,
    catalogue: &[&'static dyn Effect],
    parts: &[Vec<Place>],
    progress: &Progress<'_>,
) -> Option<Selection> {
    let begun = |problem, parts| {
        let candidates = Candidates::new(problem, catalogue);
        Search {
            problem,
            candidates,
            parts,
            visited: Vec::new(),
            rounds: Vec::new(),
            progress,
            doing: String::new(),
        }
    };
    let Some(excerpt) = excerpt(problem.data) else {
        return searched(begun(problem, parts), baseline);
    };
    let part = problem.in_part(&excerpt);
    let of_part = refit(&part, &[], &baseline.minimum.values)?;
    let selection = searched(begun(&part, &[]), of_part)?;
    let mut search = begun(problem, parts);
    search.begin("fitting to all data what was found in a part of them".into());
    search.visit(baseline)?;
    carried(search, &part, &selection)
}

fn searched(mut search: Search<'_, '_>, baseline: Fit) -> Option<Selection> {
    let plain = search.visit(baseline)?;
    let told = search.with_command_news(plain);
    let baseline = search.with_third_pole(told);
    let mut current = search.with_what_is_read(baseline);
    for _ in 0..MOST_TERMS {
        search.begin(format!("trying the catalogue's effects on top of {}", search.described(current)));
        let all = search.candidates.named.clone();
        let round = search.one_more(current, &all);
        let best = search.best(&round.after);
        search.rounds.push(round);
        match best {
            Some(best) if search.improvement(best, current) > 0.0 => current = search.settle(best),
            _ => break,
        }
    }
    search.begin("dropping and exchanging effects".into());
    let named = search.exchange(current);
    let named = search.simplest(named, baseline);
    search.begin("trying terms without a name".into());
    let extended = search.with_shapes(named);
    if named != baseline {
        search.visit_shape_instead(baseline, named);
    }
    Some(search.selection(baseline, named, extended))
}

impl Search<'_, '_> {
    /// Says what is being done from now on.
    fn begin(&mut self, doing: String) {
        (self.progress)(doing.as_str().into());
        self.doing = doing;
    }

    /// Which of all that was visited is the answer's, of those that were found.
    pub fn selection(mut self, baseline: usize, named: usize, extended: usize) -> Selection {
        let extended = self.without_needless(extended, named);
        for place in self.with_fewer_shapes(extended) {
            self.visit_its_class(place);
        }
        let [named, extended] = [named, extended].map(|place| self.likeliest_of_class(place));
        let fullest = self.best_of_all(extended, |_| true);
        Selection { visited: self.visited, baseline, named, extended, fullest }
    }

    /// Keeps a fit; of two with the same terms the better.
    pub fn visit(&mut self, fit: Fit) -> Option<usize> {
        let mut ids = fit.ids();
        ids.sort_unstable();
        let same = |other: &Visited| {
            let mut others = other.fit.ids();
            others.sort_unstable();
            others == ids
        };
        let known = self.visited.iter().position(same);
        if let Some(place) = known
            && self.visited[place].fit.criterion() <= fit.criterion()
        {
            return Some(place);
        }
        let information = Information::new(self.problem, &fit, self.parts)?;
        let log_prior = log_prior(self.problem, &fit.effects, &self.candidates)
            + log_prior_of_spring(self.problem, &fit, &self.candidates);
        let visited = Visited { log_prior, fit, information };
        Some(match known {
            Some(place) => {
                self.visited[place] = visited;
                place
            }
            None => {
                self.visited.push(visited);
                self.visited.len() - 1
            }
        })
    }

    fn described(&self, place: usize) -> String {
        let effects = self.visited[place].fit.effects.iter();
        let ids: Vec<&str> = effects.filter(|e| !e.is_background()).map(|e| e.about().id).collect();
        if ids.is_empty() { "the baseline".into() } else { ids.join(" + ") }
    }

    /// The model at `place`, or that with a third pole of the background where it is more probable.
    pub fn with_third_pole(&mut self, place: usize) -> usize {
        let before = self.visited[place].fit.clone();
        let prospects = screen(self.problem, &before, &[&RollOff, &SlowMoment]);
        let fits: Vec<Fit> =
            prospects.par_iter().filter_map(|p| refit(self.problem, &p.effects, &p.values)).collect();
        let after: Vec<usize> = fits.into_iter().filter_map(|fit| self.visit(fit)).collect();
        self.better_than(place, &after)
    }

    /// The model at `place`, or that which takes what is new in the command for a reading, where that is there and more probable.
    fn with_command_news(&mut self, place: usize) -> usize {
        if !self.problem.data.has_command_news() {
            return place;
        }
        let before = &self.visited[place].fit;
        let effects = [&before.effects[..], &[&CommandTells as &'static dyn Effect]].concat();
        let start = CommandTells.starts(&self.problem.sizes).concat();
        let told = refit(self.problem, &effects, &[&before.minimum.values[..], &start].concat());
        let after: Vec<usize> = told.and_then(|fit| self.visit(fit)).into_iter().collect();
        self.better_than(place, &after)
    }

    /// The model at `place`, or that with a candidate of which nothing is left to fit, as the limit of a sensor that the log shows,
    /// where it is more probable. Its gain is all in what else moves, which no step from the optimum without it sees: it is fitted
    /// from the user's model.
    fn with_what_is_read(&mut self, place: usize) -> usize {
        let sizes = &self.problem.sizes;
        let read = |e: &&'static dyn Effect| {
            let own = e.starts(sizes).into_iter().next()?;
            (own.len() == 1 && e.beyond_data(&own, sizes).is_some()).then_some((*e, own))
        };
        let all: Vec<(&'static dyn Effect, Vec<f64>)> =
            self.candidates.named.iter().filter_map(read).collect();
        let fits: Vec<Fit> = all.iter().filter_map(|(e, own)| fit_afresh(self.problem, &[*e], own)).collect();
        let visited: Vec<usize> = fits.into_iter().filter_map(|fit| self.visit(fit)).collect();
        let told: Vec<usize> = visited.into_iter().map(|i| self.with_command_news(i)).collect();
        let after: Vec<usize> = told.into_iter().map(|i| self.with_third_pole(i)).collect();
        self.better_than(place, &after)
    }

    /// The model at `before` with each named candidate that it lacks (a term beside its own special case says nothing twice); and
    /// itself, fitted again from where these ended.
    pub fn one_more(&mut self, before: usize, candidates: &[&'static dyn Effect]) -> Round {
        let fit = self.visited[before].fit.clone();
        let lacking = |e: &&'static dyn Effect| {
            let said = |known: &&'static dyn Effect| {
                known.about().id == e.about().id || known.generalises(*e) || e.generalises(*known)
            };
            !fit.effects.iter().any(said)
        };
        let missing: Vec<&'static dyn Effect> = candidates.iter().copied().filter(lacking).collect();
        let (progress, what) = (self.progress, self.doing.as_str());
        let fits = fit_one_more(self.problem, &fit, &missing, &|step| progress(Step { what, ..step }));
        let length = fit.minimum.values.len();
        let again: Vec<Fit> = fits
            .par_iter()
            .take(FITTED_AGAIN)
            .filter_map(|other| refit(self.problem, &fit.effects, &other.minimum.values[..length]))
            .collect();
        for fit in again {
            self.visit(fit);
        }
        // A term that another one drives to its bound is needless beside it.
        let needed = |other: &Fit| {
            let idle = |i: &usize| !other.effects[*i].is_background() && other.at_bound(self.problem, *i);
            match (0..fit.effects.len()).find(idle) {
                Some(i) => without(self.problem, other, i),
                None => Some(other.clone()),
            }
        };
        let asked_of = |e: &dyn Effect| missing.iter().any(|other| other.about().id == e.about().id);
        let hanging = about_another_zero(self.problem, &fit, asked_of);
        let swinging = about_zero(self.problem, &fit, asked_of);
        let fits: Vec<Fit> = fits.par_iter().filter_map(needed).chain(hanging).chain(swinging).collect();
        let after = fits.into_iter().filter_map(|fit| self.visit(fit)).collect();
        Round { before, after }
    }

    /// A round on top of `before`, unless there was one.
    fn once_more(&mut self, before: usize, candidates: &[&'static dyn Effect]) {
        if !self.rounds.iter().any(|round| round.before == before) {
            let round = self.one_more(before, candidates);
            self.rounds.push(round);
        }
    }

    /// Candidates that came near in some round, those of a class with one of them, and those that one of them
    /// is a special case of, or that are one of it.
    fn near(&self) -> Vec<&'static dyn Effect> {
        let seen = |e: &dyn Effect| self.visited.iter().any(|v| v.fit.position(e.about().id).is_some());
        let class = |e: &dyn Effect| {
            e.class().is_some()
                && self.candidates.named.iter().any(|other| other.class() == e.class() && seen(*other))
        };
        let related = |e: &dyn Effect| {
            let of = |other: &dyn Effect| other.generalises(e) || e.generalises(other);
            self.candidates.named.iter().any(|other| of(*other) && seen(*other))
        };
        let near = |e: &&'static dyn Effect| seen(*e) || class(*e) || related(*e);
        self.candidates.named.iter().copied().filter(near).collect()
    }

    /// The model at `place`, fitted from another background too.
    pub fn settle(&mut self, place: usize) -> usize {
        let fit = settled(self.problem, self.visited[place].fit.clone());
        self.visit(fit).unwrap_or(place)
    }

    fn log_posterior(&self, place: usize, divisor: f64) -> f64 {
        self.visited[place].log_posterior(self.problem, divisor)
    }

    /// Gain of the log posterior by the terms of `after` that `before` has not.
    fn improvement(&self, after: usize, before: usize) -> f64 {
        let divisor = self.visited[after].divisor_beyond(self.problem, &self.visited[before].fit);
        self.log_posterior(after, divisor) - self.log_posterior(before, divisor)
    }

    fn best(&self, places: &[usize]) -> Option<usize> {
        let likeliest =
            |a: &usize, b: &usize| self.log_posterior(*a, 1.0).total_cmp(&self.log_posterior(*b, 1.0));
        places.iter().copied().max_by(likeliest)
    }

    /// The best of `after` where it is more probable than the model at `place`, which stays else.
    fn better_than(&self, place: usize, after: &[usize]) -> usize {
        self.best(after).filter(|&best| self.improvement(best, place) > 0.0).unwrap_or(place)
    }

    /// The most probable of all models that `count`, with the divisor of the terms of the one at hand.
    pub fn best_of_all(&self, current: usize, count: impl Fn(&Visited) -> bool) -> usize {
        let divisor = self.visited[current].divisor(self.problem);
        let all = (0..self.visited.len()).filter(|&i| count(&self.visited[i]));
        let value = |i: usize| self.log_posterior(i, divisor) + if i == current { SAME } else { 0.0 };
        all.max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or(current)
    }

    /// The most probable of those without a shape.
    pub fn best_named(&self, current: usize) -> usize {
        self.best_of_all(current, |visited| visited.shapes().is_empty())
    }

    /// Every term dropped, and exchanged for every candidate, until no such step is more probable.
    fn exchange(&mut self, mut current: usize) -> usize {
        for _ in 0..MOST_EXCHANGES {
            for rest in self.visit_without(current) {
                self.once_more(rest, &self.near());
            }
            // What a general term says may be its special case and another one.
            for simpler in self.visit_instead(current, |general, e| general.generalises(e)) {
                self.once_more(simpler, &self.candidates.named.clone());
            }
            for other in self.visit_instead(current, |one, e| all_but_the_same(one, e) || both_ring(one, e)) {
                self.visit_without(other);
            }
            self.visit_change_instead(current);
            let best = self.best_named(current);
            if best == current {
                break;
            }
            current = self.settle(best);
        }
        self.visit_its_class(current);
        current
    }

    /// Where no angle is measured, lags of sensor and actuator show alike: whichever was found first, the others are asked in its
    /// place.
    pub fn visit_its_class(&mut self, place: usize) {
        if !self.problem.data.has_angle {
            self.visit_instead(place, |one, e| one.class().is_some() && one.class() == e.class());
        }
    }

    /// The model at `place`, or that with another of the class of one of its terms in its place, whichever is likelier.
    fn likeliest_of_class(&self, place: usize) -> usize {
        let fit = &self.visited[place].fit;
        let lacks = |one: &Fit, other: &Fit| -> Vec<&'static dyn Effect> {
            let lacking = other.effects.iter().filter(|e| one.position(e.about().id).is_none());
            lacking.copied().collect()
        };
        let mate = |other: &Visited| match (&lacks(&other.fit, fit)[..], &lacks(fit, &other.fit)[..]) {
            ([old], [new]) => old.class().is_some() && old.class() == new.class(),
            (old, new) => old.is_empty() && new.is_empty(),
        };
        self.best_of_all(place, mate)
    }

    /// The models that were visited with the names of that at `place`, beside them some of its shapes or all.
    fn with_fewer_shapes(&self, place: usize) -> Vec<usize> {
        let fit = &self.visited[place].fit;
        let has = |one: &Fit, e: &dyn Effect| one.position(e.about().id).is_some();
        let fewer = |other: &Fit| {
            other.effects.iter().all(|e| has(fit, *e))
                && fit.effects.iter().all(|e| is_shape(*e) || e.is_background() || has(other, *e))
        };
        (0..self.visited.len()).filter(|&i| fewer(&self.visited[i].fit)).collect()
    }

    /// The model at `place` without each of its terms in turn.
    pub fn visit_without(&mut self, place: usize) -> Vec<usize> {
        let fit = self.visited[place].fit.clone();
        let terms: Vec<usize> = (0..fit.effects.len()).filter(|&i| !fit.effects[i].is_background()).collect();
        let fits: Vec<Fit> = terms.par_iter().filter_map(|&i| without(self.problem, &fit, i)).collect();
        let handed: Vec<Fit> =
            terms.par_iter().flat_map_iter(|&i| handed_on(self.problem, &fit, i)).collect();
        fits.into_iter().chain(handed).filter_map(|fit| self.visit(fit)).collect()
    }

    /// The model at `place` with every candidate in the place of a term that `stands` for it.
    fn visit_instead(
        &mut self,
        place: usize,
        stands: impl Fn(&dyn Effect, &dyn Effect) -> bool,
    ) -> Vec<usize> {
        let fit = self.visited[place].fit.clone();
        let mut pairs: Vec<(usize, &'static dyn Effect)> = Vec::new();
        for (i, term) in fit.effects.iter().enumerate() {
            let other = |e: &&'static dyn Effect| stands(*term, *e) && fit.position(e.about().id).is_none();
            pairs.extend(self.candidates.named.iter().copied().filter(other).map(|other| (i, other)));
        }
        let fits: Vec<Fit> = pairs
            .into_iter()
            .filter_map(|(i, other)| {
                let mut effects = fit.effects.clone();
                let mut values = fit.minimum.values.clone();
                values.drain(fit.own_range(self.problem, i));
                effects.remove(i);
                effects.push(other);
                let rung = fit.effects[i].rings(&fit.minimum.values[fit.own_range(self.problem, i)]);
                let ringing = rung.and_then(|[f_hz, zeta]| other.start_ringing(f_hz, zeta));
                let starts = other.starts(&self.problem.sizes).into_iter().chain(ringing);
                let fits = starts.filter_map(|own| {
                    fit_from(self.problem, &effects, &[&values[..], &own].concat(), SKETCH)
                });
                let best = fits.min_by(|a, b| a.criterion().total_cmp(&b.criterion()))?;
                refit(self.problem, &effects, &best.minimum.values)
            })
            .collect();
        fits.into_iter().filter_map(|fit| self.visit(fit)).collect()
    }

    /// The shapes that promise most beside the model at `place`, a few steps from their starts.
    fn shapes(&self, place: usize) -> Vec<Prospect> {
        let before = &self.visited[place].fit;
        let lacking = |e: &&'static dyn Effect| before.position(e.about().id).is_none();
        let shapes: Vec<&'static dyn Effect> =
            self.candidates.shapes.iter().copied().filter(lacking).collect();
        let mut prospects = screen(self.problem, before, &shapes);
        prospects.truncate(SHAPES_FITTED);
        prospects
    }

    /// The model at `place` with the shapes without which it is implausible: a form that is fitted can look like something by chance,
    /// and has no sentence of physics to stand on.
    fn with_shapes(&mut self, place: usize) -> usize {
        let sure = ((1.0 - PLAUSIBLE) / PLAUSIBLE).ln();
        let mut current = place;
        for _ in 0..MOST_SHAPES {
            let prospects = self.shapes(current);
            let fits: Vec<Fit> =
                prospects.par_iter().filter_map(|p| refit(self.problem, &p.effects, &p.values)).collect();
            let after: Vec<usize> = fits.into_iter().filter_map(|fit| self.visit(fit)).collect();
            match self.best(&after) {
                Some(best) if self.improvement(best, current) > sure => current = best,
                _ => break,
            }
        }
        current
    }

    /// The best shape in place of all names, where a sketch of it comes at least near to what they gain.
    fn visit_shape_instead(&mut self, baseline: usize, named: usize) {
        let (none, names) = (self.visited[baseline].fit.criterion(), self.visited[named].fit.criterion());
        let near = |sketch: &Fit| none - sketch.criterion() > NEAR * (none - names);
        let fits: Vec<Fit> = self
            .shapes(baseline)
            .par_iter()
            .filter_map(|p| fit_from(self.problem, &p.effects, &p.values, SKETCH).filter(near))
            .filter_map(|sketch| refit(self.problem, &sketch.effects, &sketch.minimum.values))
            .collect();
        for fit in fits {
            self.visit(fit);
        }
    }

    /// The model at `place` less the named terms that its shapes have made needless.
    fn without_needless(&mut self, mut place: usize, named: usize) -> usize {
        while place != named {
            let rest = self.visit_without(place);
            let shapes = |v: &Visited| v.fit.effects.iter().filter(|e| is_shape(**e)).count();
            let all = shapes(&self.visited[place]);
            let fewer = rest.into_iter().filter(|&i| shapes(&self.visited[i]) == all);
            let needless =
                fewer.max_by(|a, b| self.improvement(place, *b).total_cmp(&self.improvement(place, *a)));
            match needless {
                Some(less) if self.improvement(place, less) < 0.0 => place = less,
                _ => break,
            }
        }
        place
    }
}

/// `fit` without its `i`-th effect, fitted again.
pub fn without(problem: &Problem<'_>, fit: &Fit, i: usize) -> Option<Fit> {
    let mut effects = fit.effects.clone();
    let mut values = fit.minimum.values.clone();
    values.drain(fit.own_range(problem, i));
    effects.remove(i);
    refit(problem, &effects, &values).map(|fit| best_moment(problem, fit))
}

/// Whether both effects ring: the likelihood of a light damping is a narrow valley, and one that lies in it shows another
/// the way.
fn both_ring(one: &dyn Effect, other: &dyn Effect) -> bool {
    [one, other].iter().all(|effect| effect.start_ringing(1.0, 0.1).is_some())
}

/// `fit` without its `i`-th effect, of which another one of its class with as many parameters takes over the values: of a lag that is
/// cut in two neither part by itself leads to the whole.
fn handed_on(problem: &Problem<'_>, fit: &Fit, i: usize) -> Vec<Fit> {
    let (class, own) = (fit.effects[i].class(), fit.own_range(problem, i));
    let mates =
        (0..fit.effects.len()).filter(|&j| j != i && class.is_some() && fit.effects[j].class() == class);
    let takes_over = |j: usize| {
        let others = fit.own_range(problem, j);
        if others.len() != own.len() {
            return None;
        }
        let mut values = fit.minimum.values.clone();
        values.copy_within(own.clone(), others.start);
        values.drain(own.clone());
        let mut effects = fit.effects.clone();
        effects.remove(i);
        refit(problem, &effects, &values)
    };
    mates.filter_map(takes_over).collect()
}

#[cfg(test)]
mod tests;
