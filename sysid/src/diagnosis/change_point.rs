//! The moment from which on an effect acts. The likelihood has many minima over it, and kinks: a descent stops at the
//! nearest, and second derivatives say nothing of the interval.

use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use crate::optim::levenberg_marquardt::{Coordinate, Effort, Minimum, minimize};
use rayon::prelude::*;

/// How far from where a descent stopped another moment is looked for, s, and in what steps.
const REACH_S: f64 = 4.0;
const GRID_S: f64 = 0.1;
/// Distances at which the likelihood's profile is looked at, s.
const PROFILE_S: [f64; 14] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.2, 4.0];
/// Other values are fitted again for every moment with this effort.
const EFFORT: Effort = Effort { iterations: 3, tolerance: 0.1 };
/// Rise of −2 log likelihood at the ends of a 95 % interval of a moment: −2 ln(1 − √0.95) (Hansen, Econometrica 68, 2000,
/// theorem 2), more than that of a parameter on which the likelihood depends smoothly.
const RISE: f64 = 7.352;

/// `fit`, or the same effects fitted from a better moment nearby.
pub fn best_moment(problem: &Problem<'_>, fit: Fit) -> Fit {
    (0..fit.effects.len()).fold(fit, |fit, i| {
        let Some(place) = place_of_moment(problem, &fit, i) else { return fit };
        let own = fit.own_range(problem, i);
        let steps = (REACH_S / GRID_S) as i32;
        let best = (-steps..=steps)
            .into_par_iter()
            .filter_map(|step| {
                at_moment(problem, &fit, place, f64::from(step) * GRID_S, |j| own.contains(&j))
            })
            .min_by(|a, b| a.criterion.total_cmp(&b.criterion));
        match best.and_then(|best| refit(problem, &fit.effects, &best.values)) {
            Some(other) if other.criterion() < fit.criterion() => other,
            _ => fit,
        }
    })
}

/// 95 % interval of the moment that stands at `place` of the unknowns, from the likelihood's profile: the plant and the effects
/// are fitted again for every moment, and the interval reaches to the farthest that is as likely, with likelihood ratios
/// divided by `divisor`.
pub fn interval(problem: &Problem<'_>, fit: &Fit, place: usize, divisor: f64) -> [f64; 2] {
    let noise = problem.noise_range();
    let rise = |away: f64| {
        let there = at_moment(problem, fit, place, away, |j| !noise.contains(&j));
        there.map_or(f64::INFINITY, |minimum| minimum.criterion - fit.criterion())
    };
    let profile: Vec<[f64; 2]> = PROFILE_S.into_par_iter().map(|away| [rise(-away), rise(away)]).collect();
    let reach = |side: usize| {
        let last = profile.iter().rposition(|rises| rises[side] <= RISE * divisor);
        PROFILE_S[last.map_or(0, |last| (last + 1).min(PROFILE_S.len() - 1))]
    };
    let moment = fit.minimum.values[place];
    let Coordinate { bounds, .. } = problem.coordinates(&fit.effects).swap_remove(place);
    [moment - reach(0), moment + reach(1)].map(|end| end.clamp(bounds[0], bounds[1]))
}

/// Where the moment at which the `i`-th effect begins stands among all unknowns.
fn place_of_moment(problem: &Problem<'_>, fit: &Fit, i: usize) -> Option<usize> {
    Some(fit.own_range(problem, i).start + fit.effects[i].begins_at()?)
}

/// The unknowns that are `free` fitted again, the one at `place` held `away` from where it is, all others where they are.
fn at_moment(
    problem: &Problem<'_>,
    fit: &Fit,
    place: usize,
    away: f64,
    free: impl Fn(usize) -> bool,
) -> Option<Minimum> {
    let mut values = fit.minimum.values.clone();
    values[place] += away;
    let mut coordinates = problem.coordinates(&fit.effects);
    if !(coordinates[place].bounds[0]..=coordinates[place].bounds[1]).contains(&values[place]) {
        return None;
    }
    for (j, coordinate) in coordinates.iter_mut().enumerate() {
        if j == place || !free(j) {
            coordinate.bounds = [values[j]; 2];
        }
    }
    let residuals = problem.prediction_errors(&fit.effects);
    minimize(&residuals, problem.channels(), &coordinates, &values, EFFORT)
}
