//! Maximum likelihood for one set of effects: the innovations form with coloured disturbance.

use super::problem::Problem;
use crate::model::effect::Effect;
use crate::optim::levenberg_marquardt::{Effort, Minimum, minimize};
use nalgebra::Matrix2;
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

    /// Delay of the plant, s.
    pub fn delay(&self, problem: &Problem<'_>) -> f64 {
        problem.unpack(&self.effects, &self.minimum.values).plant.delay
    }

    /// Whether a parameter of the `i`-th effect stands at a bound of what physics allows: then it stands for something else.
    pub fn at_bound(&self, problem: &Problem<'_>, i: usize) -> bool {
        let coordinates = problem.coordinates(&self.effects);
        let own = self.own_range(problem, i);
        let values = &self.minimum.values[own.clone()];
        let beyond = self.effects[i].beyond_data(values, &problem.sizes).map(|beyond| own.start + beyond);
        own.filter(|place| Some(*place) != beyond).any(|place| {
            let (bounds, value) = (coordinates[place].bounds, self.minimum.values[place]);
            let hair = 1e-6 * (bounds[1] - bounds[0]);
            value - bounds[0] < hair || bounds[1] - value < hair
        })
    }

    /// Where the parameters of the `i`-th effect stand among all unknowns.
    pub fn own_range(&self, problem: &Problem<'_>, i: usize) -> core::ops::Range<usize> {
        let count = |e: &&'static dyn Effect| e.parameters(&problem.sizes).len();
        let first = problem.noise_range().end + self.effects[..i].iter().map(count).sum::<usize>();
        first..first + count(&self.effects[i])
    }

    /// Where the parameters of the effect called `id` stand among all unknowns; `None` where the fit has no such effect.
    pub fn range_of(&self, problem: &Problem<'_>, id: &str) -> Option<core::ops::Range<usize>> {
        self.position(id).map(|position| self.own_range(problem, position))
    }

    /// Place of the effect called `id` among the effects.
    pub fn position(&self, id: &str) -> Option<usize> {
        self.effects.iter().position(|effect| effect.about().id == id)
    }

    /// The ids of the effects.
    pub fn ids(&self) -> Vec<&'static str> {
        self.effects.iter().map(|e| e.about().id).collect()
    }
}

/// Disturbance strengths tried for the baseline, as shares of `Problem::noise_start`'s unit.
const STRENGTHS: [f64; 5] = [0.03, 0.3, 3.0, 30.0, 300.0];
/// A fit from one of several starts.
pub const SKETCH: Effort = Effort { iterations: 8, tolerance: 0.5 };
/// A fit to the end.
pub const FINISH: Effort = Effort { iterations: 40, tolerance: 0.02 };

/// Fits the baseline: a few iterations from every disturbance strength, then the best to the end.
pub fn fit_baseline(problem: &Problem<'_>) -> Option<Fit> {
    fit_afresh(problem, &[], &[])
}

/// The same with `effects` beside the baseline, which begin at the values `own`.
pub fn fit_afresh(problem: &Problem<'_>, effects: &[&'static dyn Effect], own: &[f64]) -> Option<Fit> {
    let sketch = |share: &f64| {
        let start = [&problem.plant_start()[..], &problem.noise_start(*share), own].concat();
        fit(problem, effects, &start, SKETCH)
    };
    let sketches: Vec<Fit> = STRENGTHS.par_iter().filter_map(sketch).collect();
    let best = sketches.into_iter().min_by(|a, b| a.criterion().total_cmp(&b.criterion()))?;
    refit(problem, effects, &best.minimum.values).map(|fit| settled(problem, fit))
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

/// Fits `effects` from given values to the end.
pub fn refit(problem: &Problem<'_>, effects: &[&'static dyn Effect], start: &[f64]) -> Option<Fit> {
    fit(problem, effects, start, FINISH)
}

/// Fits `effects` from given values with some effort.
pub fn fit(
    problem: &Problem<'_>,
    effects: &[&'static dyn Effect],
    start: &[f64],
    effort: Effort,
) -> Option<Fit> {
    let residuals = problem.prediction_errors(effects);
    let minimum = minimize(&residuals, problem.channels(), &problem.coordinates(effects), start, effort)?;
    Some(Fit { effects: effects.to_vec(), minimum })
}

/// Fits `effects` beside the baseline of `plain`, each from its `start`-th start or its last.
pub fn refit_with(
    problem: &Problem<'_>,
    plain: &Fit,
    effects: &[&'static dyn Effect],
    start: usize,
) -> Option<Fit> {
    let own = effects.iter().flat_map(|effect| {
        let mut starts = effect.starts(&problem.sizes);
        starts.swap_remove(start.min(starts.len() - 1))
    });
    let start: Vec<f64> = plain.minimum.values.iter().copied().chain(own).collect();
    refit(problem, effects, &start)
}

/// Mean square of residuals.
pub fn covariance(residuals: &[[f64; 2]]) -> Matrix2<f64> {
    let n = residuals.len().max(1) as f64;
    let squares = residuals.iter().map(|[a, b]| Matrix2::new(a * a, a * b, a * b, b * b));
    squares.sum::<Matrix2<f64>>() / n
}

/// Inverse covariance of residuals and the logarithm of its determinant; a dead second channel is left out.
pub fn weights(residuals: &[[f64; 2]]) -> (Matrix2<f64>, f64) {
    let s = covariance(residuals);
    match s.try_inverse() {
        Some(inverse) if s[(1, 1)] > 0.0 => (inverse, s.determinant().ln()),
        _ => (Matrix2::new(1.0 / s[(0, 0)], 0.0, 0.0, 0.0), s[(0, 0)].ln()),
    }
}
