//! Maximum likelihood for one set of effects: the innovations form with coloured disturbance, from several starts.

use super::effects::Effect;
use super::problem::Problem;
use crate::identify::levenberg_marquardt::{Effort, Linearised, Minimum, minimize};
use rayon::prelude::*;

/// A fitted set of effects.
#[derive(Clone)]
pub struct Fit {
    /// The effects that were added to the baseline, in the order of their parameters.
    pub effects: Vec<&'static dyn Effect>,
    /// Where the criterion is least.
    pub minimum: Minimum,
}

impl Fit {
    /// −2 log likelihood (with the prior on the mount), up to a constant common to all fits of the same data.
    pub fn criterion(&self) -> f64 {
        self.minimum.criterion
    }

    /// Bayesian information criterion: the criterion plus ln N for each of the effects' parameters.
    pub fn bic(&self, problem: &Problem<'_>) -> f64 {
        let parameters: usize = self.effects.iter().map(|e| e.parameters(&problem.sizes).len()).sum();
        self.criterion() + parameters as f64 * (problem.count() as f64).ln()
    }

    /// Whether a parameter of the effect added last stands at a bound of what physics allows: then it stands for
    /// something else.
    pub fn last_at_bound(&self, problem: &Problem<'_>) -> bool {
        let coordinates = problem.coordinates(&self.effects);
        let own = self.effects.last().map_or(0, |e| e.parameters(&problem.sizes).len());
        let pairs = coordinates.iter().zip(&self.minimum.values).rev().take(own);
        let mut near = pairs.map(|(c, &value)| {
            let hair = 1e-6 * (c.bounds[1] - c.bounds[0]);
            value - c.bounds[0] < hair || c.bounds[1] - value < hair
        });
        near.any(|at_bound| at_bound)
    }

    /// Where the parameters of the `i`-th effect stand among all unknowns.
    pub fn own_range(&self, problem: &Problem<'_>, i: usize) -> core::ops::Range<usize> {
        let count = |e: &&'static dyn Effect| e.parameters(&problem.sizes).len();
        let first = problem.noise_range().end + self.effects[..i].iter().map(count).sum::<usize>();
        first..first + count(&self.effects[i])
    }

    /// Where the parameters of the effect called `id` stand among all unknowns; `None` where the fit has no such effect.
    pub fn range_of(&self, problem: &Problem<'_>, id: &str) -> Option<core::ops::Range<usize>> {
        let position = self.effects.iter().position(|effect| effect.about().id == id)?;
        Some(self.own_range(problem, position))
    }

    /// The ids of the effects.
    pub fn ids(&self) -> Vec<&'static str> {
        self.effects.iter().map(|e| e.about().id).collect()
    }
}

/// Disturbance strengths tried for the baseline, as shares of `Problem::noise_start`'s unit.
const STRENGTHS: [f64; 5] = [0.03, 0.3, 3.0, 30.0, 300.0];
/// Strength that stands for "near output error".
const LOW_GAIN: f64 = 0.03;
/// Candidates whose sketch ends this far above the best in BIC are not fitted to the end.
const HOPELESS: f64 = 60.0;
const SKETCH: Effort = Effort { iterations: 5, tolerance: 0.5 };
const FINISH: Effort = Effort { iterations: 40, tolerance: 0.02 };

/// Fits the baseline: a few iterations from every disturbance strength, then the best to the end.
pub fn fit_baseline(problem: &Problem<'_>) -> Option<Fit> {
    let sketch =
        |share: &f64| sketch(problem, &[], &[problem.plant_start(), problem.noise_start(*share)].concat());
    let sketches: Vec<Fit> = STRENGTHS.par_iter().filter_map(sketch).collect();
    let best = sketches.into_iter().min_by(|a, b| a.criterion().total_cmp(&b.criterion()))?;
    refit(problem, &[], &best.minimum.values).map(|fit| settled(problem, fit))
}

/// `fit`, or the same effects fitted from a band-passed disturbance where that is better: a low pass of two poles does
/// not turn into one by itself.
pub fn settled(problem: &Problem<'_>, fit: Fit) -> Fit {
    let mut banded = fit.minimum.values.clone();
    banded[problem.noise_range()][1..4].copy_from_slice(&problem.band_pass());
    match refit(problem, &fit.effects, &banded) {
        Some(other) if other.criterion() < fit.criterion() => other,
        _ => fit,
    }
}

/// `before` with each of `candidates` in turn, best first. Of the starts of a candidate the best after one Gauss–Newton
/// step is followed, from the optimum of `before` and from near output error (where the disturbance model does not
/// swallow an effect before it is seen); those that come near the best are fitted to the end.
pub fn fit_one_more(problem: &Problem<'_>, before: &Fit, candidates: &[&'static dyn Effect]) -> Vec<Fit> {
    let mut starts = best_starts(problem, before, candidates, &before.minimum.values);
    if let Some(low) = near_output_error(problem, before) {
        for (candidate, mut values, criterion) in best_starts(problem, before, candidates, &low) {
            let noise = problem.noise_range();
            values[noise.clone()].copy_from_slice(&before.minimum.values[noise]);
            starts.push((candidate, values, criterion));
        }
    }
    let sketches: Vec<Fit> = starts
        .par_iter()
        .filter_map(|(candidate, values, _)| {
            let mut effects = before.effects.clone();
            effects.push(*candidate);
            sketch(problem, &effects, values)
        })
        .collect();
    let mut best: Vec<Fit> = Vec::new();
    for fit in sketches {
        match best.iter_mut().find(|other| other.ids() == fit.ids()) {
            Some(other) if other.criterion() <= fit.criterion() => {}
            Some(other) => *other = fit,
            None => best.push(fit),
        }
    }
    // A sketch at a bound often lies lowest and is no candidate in the end: it must not outbid the others.
    let within = |fit: &Fit| !fit.last_at_bound(problem);
    let lowest = best.iter().filter(|f| within(f)).map(|f| f.bic(problem)).fold(f64::INFINITY, f64::min);
    best.retain(|fit| fit.bic(problem) < lowest + HOPELESS);
    let mut fits: Vec<Fit> =
        best.par_iter().filter_map(|fit| refit(problem, &fit.effects, &fit.minimum.values)).collect();
    fits.retain(within);
    fits.sort_by(|a, b| a.bic(problem).total_cmp(&b.bic(problem)));
    fits
}

/// `before` with each of `candidates` after one Gauss–Newton step, best BIC first: effects and values.
pub fn screen(
    problem: &Problem<'_>,
    before: &Fit,
    candidates: &[&'static dyn Effect],
) -> Vec<(Vec<&'static dyn Effect>, Vec<f64>)> {
    let count = (problem.count() as f64).ln();
    let mut steps: Vec<(f64, Vec<&'static dyn Effect>, Vec<f64>)> =
        best_starts(problem, before, candidates, &before.minimum.values)
            .into_iter()
            .map(|(candidate, values, criterion)| {
                let own = values.len() - before.minimum.values.len();
                let mut effects = before.effects.clone();
                effects.push(candidate);
                (criterion + own as f64 * count, effects, values)
            })
            .collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    steps.into_iter().map(|(_, effects, values)| (effects, values)).collect()
}

/// Each candidate's best start after one step, the unknowns of `before` starting from `values`.
fn best_starts(
    problem: &Problem<'_>,
    before: &Fit,
    candidates: &[&'static dyn Effect],
    values: &[f64],
) -> Vec<(&'static dyn Effect, Vec<f64>, f64)> {
    let residuals = |v: &[f64]| problem.prediction_errors(&before.effects, v);
    let coordinates = problem.coordinates(&before.effects);
    let Some(shared) = Linearised::new(&residuals, problem.channels(), &coordinates, values) else {
        return Vec::new();
    };
    let best_start = |&candidate: &&'static dyn Effect| {
        let mut effects = before.effects.clone();
        effects.push(candidate);
        let coordinates = problem.coordinates(&effects);
        let residuals = |v: &[f64]| problem.prediction_errors(&effects, v);
        let one_step =
            |start: Vec<f64>| shared.one_step(&residuals, problem.channels(), &coordinates, &start);
        let steps = candidate.starts(&problem.sizes).into_iter().filter_map(one_step);
        steps.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(values, criterion)| (candidate, values, criterion))
    };
    candidates.par_iter().filter_map(best_start).collect()
}

/// Values of `before`'s unknowns with the noise model held near output error, the mount held as the user's model has
/// it (a mount bent out of its place hides lags and delays), and the rest fitted again.
fn near_output_error(problem: &Problem<'_>, before: &Fit) -> Option<Vec<f64>> {
    let mut start = before.minimum.values.clone();
    let mut coordinates = problem.coordinates(&before.effects);
    let (noise, mount) = (problem.noise_range(), problem.mount_range());
    start[noise.clone()].copy_from_slice(&problem.noise_start(LOW_GAIN));
    start[mount.clone()].copy_from_slice(&problem.plant_start()[mount.clone()]);
    for i in noise.chain(mount) {
        coordinates[i].bounds = [start[i]; 2];
    }
    let residuals = |v: &[f64]| problem.prediction_errors(&before.effects, v);
    minimize(&residuals, problem.channels(), &coordinates, &start, SKETCH).map(|m| m.values)
}

/// Fits `effects` from given values to the end.
pub fn refit(problem: &Problem<'_>, effects: &[&'static dyn Effect], start: &[f64]) -> Option<Fit> {
    fit(problem, effects, start, FINISH)
}

fn sketch(problem: &Problem<'_>, effects: &[&'static dyn Effect], start: &[f64]) -> Option<Fit> {
    fit(problem, effects, start, SKETCH)
}

fn fit(problem: &Problem<'_>, effects: &[&'static dyn Effect], start: &[f64], effort: Effort) -> Option<Fit> {
    let residuals = |values: &[f64]| problem.prediction_errors(effects, values);
    let minimum = minimize(&residuals, problem.channels(), &problem.coordinates(effects), start, effort)?;
    Some(Fit { effects: effects.to_vec(), minimum })
}
