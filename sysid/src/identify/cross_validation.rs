//! Order and block size of a subspace model by cross-validation:
//!
//! ```text
//! score(n, i) = mean over folds f of VAF(model from all folds but f, free run over f)
//! ```
//!
//! A fold is a section; of more than five sections every fifth; a section that holds more than two thirds of the motion is cut in
//! halves. Only cells that are stable in every fold and when learnt from all sections can be chosen, so nothing that a model is
//! later judged by takes part.
//!
//! Source: Riccardi, Panizza, Lovera, ERF 2014, section 4; Verhaegen, Dewilde, Int. J. Control 56, 1992.

use super::continuous::{ContinuousStateSpace, to_continuous};
use super::fir::Piece;
use super::pi_moesp::{Candidate, Grid, Method, search};
use crate::error::{Error, ErrorKind};
use crate::model::state_space::StateSpace;
use crate::validate::vaf::variance;
use core::ops::{Range, RangeInclusive};
use core::slice;
use rayon::prelude::*;
use serde::Serialize;

/// Folds at most.
const MOST_FOLDS: usize = 5;
/// Share of the motion beyond which a section is cut in halves: without it too little would be left to learn from.
const MOST_OF_THE_MOTION: f64 = 2.0 / 3.0;
/// Models within this many points of VAF of the best count as equally good.
const AS_GOOD: f64 = 0.5;

/// One cell of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// n.
    pub order: usize,
    /// i.
    pub block_size: usize,
    /// Mean VAF over the folds, per cent; `None` where a model is unstable or absent.
    pub vaf_percent: Option<f64>,
    /// Largest magnitude of the poles, learnt from all sections.
    pub spectral_radius: Option<f64>,
}

/// The choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The model, learnt from all sections; stable.
    pub model: StateSpace,
    /// n.
    pub order: usize,
    /// i.
    pub block_size: usize,
    /// Its score, per cent.
    pub vaf_percent: f64,
    /// All cells, order by order and by block size within.
    pub table: Vec<Cell>,
    /// The best model with a continuous-time equivalent, with its n and i; `None` where no stable one has.
    pub continuous: Option<(ContinuousStateSpace, usize, usize)>,
    /// What was chosen and how flat the choice was.
    pub reason: String,
}

/// Chooses among `orders` and `block_sizes`, and learns the chosen model from all `pieces`.
///
/// # Errors
/// As [`search`]; no cell that is stable throughout.
pub fn cross_validated(
    pieces: &[Piece],
    orders: RangeInclusive<usize>,
    block_sizes: RangeInclusive<usize>,
    method: &Method,
) -> Result<Chosen, Error> {
    let search =
        |learn: &[Piece], judge: &[Piece]| search(learn, judge, orders.clone(), block_sizes.clone(), method);
    let (whole, folds) = rayon::join(
        || search(pieces, pieces),
        || {
            folds(pieces)
                .par_iter()
                .map(|(learn, judge)| search(learn, judge).ok())
                .collect::<Vec<Option<Grid>>>()
        },
    );
    let whole = whole?;
    let score = |cell: usize| -> Option<f64> {
        whole.candidates[cell].model.as_ref()?;
        let vafs: Option<Vec<f64>> =
            folds.iter().map(|grid| grid.as_ref()?.candidates.get(cell)?.vaf).collect();
        vafs.map(|vafs| vafs.iter().sum::<f64>() / vafs.len() as f64)
    };
    let scores: Vec<Option<f64>> = (0..whole.candidates.len()).map(score).collect();
    choose(&whole.candidates, &scores, folds.len(), method.held_input)
}

/// Σ (y − ȳ)² of each of `pieces` about its mean, summed.
fn motion(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|piece| piece.rows.len() as f64 * variance(&piece.y[piece.rows.clone()])).sum()
}

/// What is learnt from and judged by, fold by fold.
fn folds<'a>(pieces: &[Piece<'a>]) -> Vec<(Vec<Piece<'a>>, Vec<Piece<'a>>)> {
    let most = MOST_OF_THE_MOTION * motion(pieces);
    let cut = |piece: &Piece<'a>| {
        let Range { start, end } = piece.rows;
        let part = |rows| Piece { rows, ..piece.clone() };
        if pieces.len() > 1 && motion(slice::from_ref(piece)) <= most {
            return vec![piece.clone()];
        }
        let middle = (start + end) / 2;
        vec![part(start..middle), part(middle..end)]
    };
    let parts: Vec<Piece<'a>> = pieces.iter().flat_map(cut).collect();
    let count = parts.len().min(MOST_FOLDS);
    let of = |fold: usize, inside: bool| {
        parts
            .iter()
            .enumerate()
            .filter(|(k, _)| (k % count == fold) == inside)
            .map(|(_, p)| p.clone())
            .collect()
    };
    (0..count).map(|fold| (of(fold, false), of(fold, true))).collect()
}

fn choose(
    candidates: &[Candidate],
    scores: &[Option<f64>],
    folds: usize,
    held_input: bool,
) -> Result<Chosen, Error> {
    let mut ranked: Vec<(usize, f64)> =
        scores.iter().enumerate().filter_map(|(cell, score)| Some((cell, (*score)?))).collect();
    // a stable sort: of equals the lowest order
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    let none = || {
        let found = format!("none of {} models is stable in all {folds} folds", candidates.len());
        Error::new(ErrorKind::Numerical, found, "give longer sections in which the input moves")
    };
    let &(best, vaf) = ranked.first().ok_or_else(none)?;
    let chosen = &candidates[best];
    let model = chosen.model.clone().ok_or_else(none)?;
    let continuous = ranked.iter().find_map(|(cell, _)| {
        let candidate = &candidates[*cell];
        Some((
            to_continuous(candidate.model.as_ref()?, held_input).ok()?,
            candidate.order,
            candidate.block_size,
        ))
    });
    let equals: Vec<&Candidate> =
        ranked.iter().filter(|(_, v)| *v >= vaf - AS_GOOD).map(|(cell, _)| &candidates[*cell]).collect();
    let lowest = equals.iter().map(|c| c.order).min().unwrap_or(chosen.order);
    let flat = if 4 * equals.len() > ranked.len() { "flat" } else { "clear" };
    let reason = format!(
        "n = {}, i = {} has the largest cross-validated VAF, {vaf:.2} %, of {} models that are stable in each of {folds} folds; \
         {} of {} are not, or do not exist. Within {AS_GOOD} points of it, itself included: {}, down to n = {lowest}; the choice is {flat}.",
        chosen.order,
        chosen.block_size,
        ranked.len(),
        candidates.len() - ranked.len(),
        candidates.len(),
        equals.len(),
    );
    let cell = |(candidate, vaf_percent): (&Candidate, &Option<f64>)| Cell {
        order: candidate.order,
        block_size: candidate.block_size,
        vaf_percent: *vaf_percent,
        spectral_radius: candidate.spectral_radius,
    };
    Ok(Chosen {
        model,
        order: chosen.order,
        block_size: chosen.block_size,
        vaf_percent: vaf,
        table: candidates.iter().zip(scores).map(cell).collect(),
        continuous,
        reason,
    })
}
