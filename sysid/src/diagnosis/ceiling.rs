//! What an unstructured linear model reaches: one class, chosen by the same rotation as the models, the same in every run
//! on the same data.

use super::parts::Part;
use crate::dataset::Place;
use crate::identify::fir::{FirOptions, Piece, ceiling_vaf, fit};
use crate::likelihood::problem::Problem;
use crate::validate::vaf::vaf;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Memories of the impulse responses that are tried, s.
const MEMORIES_S: [f64; 4] = [0.25, 0.5, 1.0, 2.0];
/// Taps at most: more of them cost more than they tell.
const MOST_TAPS: usize = 100;

/// By part, the VAF in per cent of an impulse response fitted to the part itself; its memory is the one that predicts each
/// part best from the others.
pub fn ceilings(problem: &Problem<'_>, parts: &[Part]) -> BTreeMap<String, f64> {
    let held_out = |memory: &f64| -> f64 {
        (0..parts.len()).map(|held| from_the_others(problem, parts, held, *memory).unwrap_or(0.0)).sum()
    };
    let scores: Vec<f64> = MEMORIES_S.par_iter().map(held_out).collect();
    // Of memories that predict alike the shortest: what more taps add is the noise's.
    let best = (0..scores.len()).rev().max_by(|&a, &b| scores[a].total_cmp(&scores[b]));
    let memory = best.map_or(MEMORIES_S[0], |best| MEMORIES_S[best]);
    parts.iter().map(|part| (part.label.clone(), of_itself(problem, part, memory))).collect()
}

fn taps(problem: &Problem<'_>, place: &Place, memory: f64) -> usize {
    let step = problem.data.runs[place.run].step;
    ((memory / step) as usize).min(place.rows.len() / 6).clamp(1, MOST_TAPS)
}

fn pieces<'d>(problem: &'d Problem<'_>, parts: impl Iterator<Item = &'d Part>) -> Vec<Piece<'d>> {
    let piece = |place: &'d Place| {
        let run = &problem.data.runs[place.run];
        let y = run.rate.as_ref().or(run.angle.as_ref())?;
        Some(Piece {
            u: &run.u,
            y,
            supervised: &run.supervised,
            rows: place.rows.clone(),
            run: place.run,
            step: run.step,
        })
    };
    parts.flat_map(|part| part.places.iter().filter_map(piece)).collect()
}

fn from_the_others(problem: &Problem<'_>, parts: &[Part], held: usize, memory: f64) -> Option<f64> {
    let others = parts.iter().enumerate().filter(|(i, _)| *i != held).map(|(_, part)| part);
    let pieces = pieces(problem, others);
    let shortest = parts.iter().flat_map(|p| &p.places).map(|place| taps(problem, place, memory)).min()?;
    let options = FirOptions { taps: shortest, first_lag: 1, use_supervised: true };
    let found = fit(&pieces, &options).ok()?;
    let place = parts[held].places.iter().max_by_key(|place| place.rows.len())?;
    let run = &problem.data.runs[place.run];
    let simulated = found.fir.simulate(&run.u);
    Some(vaf(problem.data.judged(place), &simulated[place.rows.clone()]))
}

/// Mean over the part's places, by their lengths.
fn of_itself(problem: &Problem<'_>, part: &Part, memory: f64) -> f64 {
    let of = |place: &Place| {
        let u = &problem.data.runs[place.run].u[place.rows.clone()];
        ceiling_vaf(u, problem.data.judged(place), taps(problem, place, memory)).unwrap_or(0.0)
    };
    let rows: usize = part.places.iter().map(|place| place.rows.len()).sum();
    let sum: f64 = part.places.iter().map(|place| place.rows.len() as f64 * of(place)).sum();
    (sum / rows.max(1) as f64).clamp(0.0, 100.0)
}

#[cfg(test)]
mod tests;
