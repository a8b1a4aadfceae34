//! What the background may be as well, where the data are too short to tell.
//!
//! The tests compare what a model leaves with what its noise makes of itself. On a few seconds the noise is a guess: its size at low
//! frequencies is known to a factor, and what looks like a moment beside one guess is noise beside another. The p-value is then
//! that of every guess, each as often as the data let it be true:
//!
//! ```text
//! p = ∫ p(ν) π(ν | data) dν
//! ```
//!
//! which for a mean in noise of unknown size is the p-value of Student's t (Meng, Annals of Statistics 22, 1994). The guesses are
//! drawn from a normal density, wider than the information says, and drawn again by their likelihood (Rubin, Bayesian Statistics 3,
//! 1988). The other unknowns follow.

use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, weights};
use crate::likelihood::problem::Problem;
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

/// Rows beyond which the noise is known well enough: a minute at 50 Hz.
const MOST_ROWS: usize = 3000;
/// Guesses whose likelihood is asked.
const PROPOSED: usize = 200;
/// Guesses that are kept.
const KEPT: usize = 20;
/// By how much they are drawn wider than the information says.
const WIDER: f64 = 1.5;
/// Standard deviation, in the coordinate of the search, of an unknown that stands at a bound.
const FROM_BOUND: f64 = 2.0;
const SEED: u64 = 1;

/// Fits with other noise that are as likely, drawn by their likelihood; none where the data are long, or say nothing of the noise.
pub fn as_likely(problem: &Problem<'_>, fit: &Fit) -> Vec<Fit> {
    if fit.minimum.residuals.len() > MOST_ROWS {
        return Vec::new();
    }
    drawn(problem, fit).unwrap_or_default()
}

fn drawn(problem: &Problem<'_>, fit: &Fit) -> Option<Vec<Fit>> {
    let information = Information::new(problem, fit, &[])?;
    let spread = information.spread(problem.noise_range())?;
    let at_bound: Vec<usize> = problem.noise_range().filter(|&i| !information.moves(i)).collect();
    let coordinates = problem.coordinates(&fit.effects);
    let errors = problem.prediction_errors(&fit.effects);
    let deviance = |residuals: &[[f64; 2]]| residuals.len() as f64 * weights(residuals).1;
    let least = deviance(&fit.minimum.residuals);
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut normal = || {
        let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
        radius * (TAU * random.random::<f64>()).cos()
    };
    let mut guesses = Vec::with_capacity(PROPOSED);
    for _ in 0..PROPOSED {
        let xi = DVector::from_fn(spread.ncols(), |_, _| normal());
        let mut moved = &spread * (WIDER * &xi);
        let mut density = xi.norm_squared();
        for &i in &at_bound {
            let eta: f64 = normal();
            let [low, high] = coordinates[i].bounds;
            let inward = if fit.minimum.values[i] - low < high - fit.minimum.values[i] { 1.0 } else { -1.0 };
            moved[i] = FROM_BOUND * eta.abs() * inward;
            density += eta * eta;
        }
        let place = |(i, &value): (usize, &f64)| match moved[i] {
            0.0 => value,
            by => coordinates[i].outer(coordinates[i].inner(value) + by),
        };
        let values: Vec<f64> = fit.minimum.values.iter().enumerate().map(place).collect();
        let Some(residuals) = errors(&values) else { continue };
        let weight = (0.5 * (density - deviance(&residuals) + least)).exp();
        if weight.is_finite() {
            let mut guess = fit.clone();
            (guess.minimum.values, guess.minimum.residuals) = (values, residuals);
            guesses.push((weight, guess));
        }
    }
    Some(resampled(guesses))
}

/// [`KEPT`] of them, each as often as its weight says (Kitagawa, Journal of Computational and Graphical Statistics 5, 1996).
fn resampled<T: Clone>(guesses: Vec<(f64, T)>) -> Vec<T> {
    let total: f64 = guesses.iter().map(|(weight, _)| weight).sum();
    let (mut kept, mut sum) = (Vec::with_capacity(KEPT), 0.0);
    for (weight, guess) in guesses {
        sum += weight;
        while kept.len() < KEPT && (kept.len() as f64 + 0.5) * total < sum * KEPT as f64 {
            kept.push(guess.clone());
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::super::{failing, tests, with_its_noise};
    use super::resampled;
    use crate::diagnosis::data_checks::fixture::{Flight, GAIN, fitted, flight, model};
    use crate::diagnosis::fixture::flight_with;
    use rayon::prelude::*;

    const LEVEL: f64 = 0.01;
    const ROWS: std::ops::Range<usize> = 700..950;

    /// Five seconds out of the middle.
    fn short(flight: &Flight) -> Flight {
        Flight {
            u: flight.u[ROWS].to_vec(),
            q: flight.q[ROWS].to_vec(),
            theta: flight.theta[ROWS].to_vec(),
            supervised: flight.supervised[ROWS].to_vec(),
            reference: flight.reference[ROWS].to_vec(),
            section: flight.section,
        }
    }

    /// Whether the family speaks of missing physics, by the noise of the fit alone and by all noise that is as likely.
    fn missing(flight: &Flight) -> [bool; 2] {
        fitted(&short(flight).recording(), &model(GAIN, 0.06), |_, problem, fit| {
            let places = problem.data.places();
            [with_its_noise(problem, fit, &places), tests(problem, fit, &places, LEVEL)]
                .map(|all| failing(&all, LEVEL).iter().any(|test| test.of_physics))
        })
    }

    #[test]
    fn five_seconds_of_the_model_itself_seldom_lack_physics() {
        let said: Vec<[bool; 2]> = (0..200).into_par_iter().map(|seed| missing(&flight(seed, 0.0))).collect();
        let [alone, all] = [0, 1].map(|which| said.iter().filter(|said| said[which]).count());
        println!("{alone} of 200 by the fitted noise alone, {all} by all that is as likely");
        assert!(all <= 2 && all < alone, "{all} {alone}");
    }

    #[test]
    fn what_is_strong_is_seen_in_five_seconds() {
        let spring = |seed| flight_with(seed, |_, _, angle| -6.0 * (8.0 * angle).tanh());
        let seen = (0..10).into_par_iter().filter(|&seed| missing(&spring(seed))[1]).count();
        assert!(seen >= 8, "{seen} of 10");
    }

    #[test]
    fn a_guess_is_kept_as_often_as_it_is_likely() {
        let kept = resampled(vec![(1.0, 'a'), (0.0, 'b'), (3.0, 'c')]);
        let often = |which| kept.iter().filter(|&&c| c == which).count();
        assert_eq!(['a', 'b', 'c'].map(often), [5, 0, 15]);
        assert!(resampled(Vec::<(f64, char)>::new()).is_empty());
    }
}
