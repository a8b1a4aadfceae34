//! How sure a subspace model and the grey box matched to it are: parametric bootstrap.
//!
//! The model's free run over the data it was learnt from, plus noise of the colour that was left over (an
//! autoregression), makes records of which the model is the truth. Each is identified and matched as the first was; the
//! spread of the answers is the interval. It holds the choice of order and block size, and says nothing of dynamics that
//! the model lacks.
//!
//! Source: Efron, Tibshirani, An Introduction to the Bootstrap, 1993, section 6.5.

use super::butterworth::Butterworth;
use super::continuous::to_continuous;
use super::fir::Piece;
use super::hinf_match::hinf_match;
use super::linear_model::LinearModel;
use super::output_error::colour::autoregression;
use super::pi_moesp::{Method, identify};
use crate::error::{Error, ErrorKind};
use crate::model::plant::Plant;
use crate::model::state_space::StateSpace;
use crate::progress::{Counted, Progress};
use nalgebra::Complex;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What is repeated.
pub struct Recipe<'a> {
    /// The data.
    pub pieces: &'a [Piece<'a>],
    /// The model learnt from them.
    pub model: &'a StateSpace,
    /// i.
    pub block_size: usize,
    /// How it was learnt.
    pub method: Method,
    /// What is matched to it, and with which weight; nothing where the model stands alone.
    pub matched: Option<(Plant, Butterworth)>,
    /// Frequencies, rad/s, at which responses are wanted.
    pub omegas: &'a [f64],
}

/// The answers.
#[derive(Clone, Debug, Default)]
pub struct Replicates {
    /// Matched grey boxes.
    pub plants: Vec<Plant>,
    /// Responses of the models at the wanted frequencies.
    pub responses: Vec<Vec<Complex<f64>>>,
    /// Records that gave no model, or one that could not be matched.
    pub failed: usize,
}

impl Replicates {
    /// The middle 95 % of `value` over the matched grey boxes, moved so that their median lies on that of `found`;
    /// everything where fewer than forty are left.
    #[must_use]
    pub fn interval(&self, found: &Plant, value: impl Fn(&Plant) -> f64) -> [f64; 2] {
        middle(self.plants.iter().map(&value).collect(), value(found))
    }

    /// The same for the gain at the `k`th frequency, about `gain`.
    #[must_use]
    pub fn gain_interval(&self, gain: f64, k: usize) -> [f64; 2] {
        middle(self.responses.iter().map(|r| r[k].norm()).collect(), gain)
    }
}

fn middle(mut values: Vec<f64>, found: f64) -> [f64; 2] {
    const ENOUGH: usize = 40;
    if values.len() < ENOUGH {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let place = share * (values.len() - 1) as f64;
        let (low, rest) = (place.floor() as usize, place.fract());
        values[low] + rest * (values[(low + 1).min(values.len() - 1)] - values[low])
    };
    [0.025, 0.975].map(|share| found + at(share) - at(0.5))
}

/// Repeats `recipe` `count` times with noise from `seed`; the same answer on any number of cores.
///
/// # Errors
/// A model that is unstable on its own data.
pub fn bootstrap(
    recipe: &Recipe,
    count: usize,
    seed: u64,
    progress: &Progress<'_>,
) -> Result<Replicates, Error> {
    let model = LinearModel::Sampled(recipe.model.clone());
    let runs: Option<Vec<Vec<f64>>> = recipe.pieces.iter().map(|piece| model.simulate(piece)).collect();
    let runs = runs.ok_or_else(|| {
        Error::new(ErrorKind::Numerical, "the model is unstable on its own data", "choose another order")
    })?;
    let errors: Vec<Vec<f64>> = recipe
        .pieces
        .iter()
        .zip(&runs)
        .map(|(piece, run)| {
            let errors: Vec<f64> = piece.y[piece.rows.clone()].iter().zip(run).map(|(y, s)| y - s).collect();
            let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
            errors.iter().map(|e| e - mean).collect()
        })
        .collect();
    let ar = autoregression(&errors);
    let deviation = innovation(&errors, &ar);
    let counted = Counted::new(progress, "repeating the H∞ match on simulated data", count);
    let answers: Vec<Option<Answer>> = (0..count as u64)
        .into_par_iter()
        .map(|k| {
            let mut generator =
                Pcg64::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(k));
            let answer = repeat(recipe, &runs, &ar, deviation, &mut generator);
            counted.one();
            answer
        })
        .collect();
    let mut all =
        Replicates { failed: answers.iter().filter(|a| a.is_none()).count(), ..Replicates::default() };
    for (plant, response) in answers.into_iter().flatten() {
        all.plants.extend(plant);
        all.responses.push(response);
    }
    Ok(all)
}

/// A matched grey box, where there is something to match, and the response.
type Answer = (Option<Plant>, Vec<Complex<f64>>);

/// One record, identified and matched.
fn repeat(
    recipe: &Recipe,
    runs: &[Vec<f64>],
    ar: &[f64],
    deviation: f64,
    generator: &mut Pcg64,
) -> Option<Answer> {
    let outputs: Vec<Vec<f64>> = recipe
        .pieces
        .iter()
        .zip(runs)
        .map(|(piece, run)| {
            let mut y = piece.y.to_vec();
            let noise = coloured(run.len(), ar, deviation, generator);
            for ((y, s), e) in y[piece.rows.clone()].iter_mut().zip(run).zip(noise) {
                *y = s + e;
            }
            y
        })
        .collect();
    let pieces: Vec<Piece> =
        recipe.pieces.iter().zip(&outputs).map(|(piece, y)| Piece { y, ..piece.clone() }).collect();
    let found = identify(&pieces, recipe.model.order(), recipe.block_size, &recipe.method).ok()?.model;
    let response: Option<Vec<_>> =
        recipe.omegas.iter().map(|omega| found.frequency_response(*omega)).collect();
    let plant = match &recipe.matched {
        None => None,
        Some((start, weight)) => {
            let target = to_continuous(&found, recipe.method.held_input).ok()?;
            let target = target.with_delay(start.delay).ok()?;
            Some(hinf_match(&target, start, weight, None).ok()?.plant)
        }
    };
    Some((plant, response?))
}

/// Standard deviation of what the autoregression leaves.
fn innovation(errors: &[Vec<f64>], ar: &[f64]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for e in errors {
        for k in ar.len()..e.len() {
            let left = e[k] - ar.iter().enumerate().map(|(j, a)| a * e[k - 1 - j]).sum::<f64>();
            sum += left * left;
            count += 1;
        }
    }
    (sum / f64::from(count.max(1))).sqrt()
}

/// Noise of the colour, settled before it is used.
fn coloured(count: usize, ar: &[f64], deviation: f64, generator: &mut Pcg64) -> Vec<f64> {
    const SETTLING: usize = 500;
    let mut e: Vec<f64> = Vec::with_capacity(count + SETTLING);
    for k in 0..count + SETTLING {
        // Box, Muller: 1 − u is never zero
        let (u, turn): (f64, f64) = (generator.random(), generator.random());
        let draw = (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * turn).cos();
        let past: f64 = ar.iter().enumerate().filter(|(j, _)| *j < k).map(|(j, a)| a * e[k - 1 - j]).sum();
        e.push(past + deviation * draw);
    }
    e.split_off(SETTLING)
}
