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

#[cfg(test)]
mod tests {
    use super::super::fixture::{asked, effects, extended, flight_with};
    use super::*;

    /// Row and time at which the moment sets in.
    const SETS_IN: usize = 1200;
    const AT_S: f64 = 24.0;

    /// The flight with a moment that sets in, and the fit that has it.
    fn set_in<T>(ask: impl FnOnce(&Problem<'_>, &Fit) -> T) -> T {
        let flown = flight_with(1, |k, _, _| if k >= SETS_IN { 1.0 } else { 0.0 });
        asked(&flown, |problem, baseline| {
            ask(problem, &best_moment(problem, extended(problem, baseline, &effects(&["moment_step"]))))
        })
    }

    #[test]
    fn a_descent_that_stopped_at_another_moment_is_brought_to_the_best_within_reach() {
        set_in(|problem, best| {
            let place = place_of_moment(problem, best, 0).unwrap();
            assert_eq!(place, best.own_range(problem, 0).start + 1);
            assert!((best.minimum.values[place] - AT_S).abs() < 0.3, "{}", best.minimum.values[place]);
            for away in [-3.0, 3.0] {
                let mut stopped = best.clone();
                stopped.minimum.values[place] += away;
                stopped.minimum.criterion += 1e3;
                let found = best_moment(problem, stopped);
                assert!((found.minimum.values[place] - AT_S).abs() < 0.3, "{}", found.minimum.values[place]);
                assert!((found.criterion() - best.criterion()).abs() < 1.0);
            }
            // One that is better already stays.
            let mut better = best.clone();
            better.minimum.values[place] += 1.0;
            better.minimum.criterion -= 1e3;
            let kept = best_moment(problem, better);
            assert_eq!(kept.minimum.values[place], best.minimum.values[place] + 1.0);
        });
    }

    #[test]
    fn an_effect_without_a_moment_is_left_as_it_is() {
        asked(&flight_with(1, |_, _, theta| -theta.sin()), |problem, baseline| {
            let fit = extended(problem, baseline, &effects(&["gravity_stiffness"]));
            assert_eq!(place_of_moment(problem, &fit, 0), None);
            assert_eq!(best_moment(problem, fit.clone()).minimum.values, fit.minimum.values);
        });
    }

    #[test]
    fn the_interval_reaches_to_the_farthest_moment_that_is_as_likely() {
        set_in(|problem, fit| {
            let place = place_of_moment(problem, fit, 0).unwrap();
            let moment = fit.minimum.values[place];
            let rise = |away: f64| {
                let noise = problem.noise_range();
                at_moment(problem, fit, place, away, |j| !noise.contains(&j)).unwrap().criterion
                    - fit.criterion()
            };
            let mut before = 0.0;
            for divisor in [1.0, 100.0] {
                let [low, high] = interval(problem, fit, place, divisor);
                assert!(low < AT_S && AT_S < high && high - low > before, "{low} {high}");
                before = high - low;
                for (side, reach) in [(-1.0, moment - low), (1.0, high - moment)] {
                    let i = PROFILE_S.iter().position(|away| (away - reach).abs() < 1e-9).unwrap();
                    assert!(rise(side * PROFILE_S[i]) > RISE * divisor || i == PROFILE_S.len() - 1);
                    assert!(i == 0 || rise(side * PROFILE_S[i - 1]) <= RISE * divisor);
                }
            }
            // What chance makes of it all reaches as far as is looked, and no further than the parameter may go.
            assert_eq!(interval(problem, fit, place, 1e9), [moment - 4.0, moment + 4.0]);
            let mut early = fit.clone();
            early.minimum.values[place] = 1.0;
            assert_eq!(interval(problem, &early, place, 1e9), [0.0, 5.0]);
        });
    }

    #[test]
    fn what_is_held_stays_and_what_is_free_is_fitted_again() {
        set_in(|problem, fit| {
            let place = place_of_moment(problem, fit, 0).unwrap();
            let there = at_moment(problem, fit, place, 1.0, |j| j == place - 1).unwrap();
            for (j, (value, before)) in there.values.iter().zip(&fit.minimum.values).enumerate() {
                let expected = before + if j == place { 1.0 } else { 0.0 };
                assert_eq!((value - expected).abs() > 1e-9 * expected.abs(), j == place - 1, "{j}");
            }
            assert!(there.criterion > fit.criterion());
            let end = problem.coordinates(&fit.effects)[place].bounds[1];
            assert!(at_moment(problem, fit, place, end, |_| true).is_none(), "beyond the data");
        });
    }
}
