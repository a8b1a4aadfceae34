//! VAF of predictions by horizon: from the filter's state at row k, h seconds ahead, with the input known.
//!
//! ```text
//! VAF_h = 100 (1 − Σ (y_{k+h} − ŷ_{k+h|k})² / Σ (y_{k+h} − ȳ)²)
//! ```
//!
//! A free run rewards a model that copies the controller where the loop is closed, and says nothing of an unstable
//! vehicle; a prediction over a short horizon does neither.

use super::evidence::BLOCK_S;
use super::free_run::judged_channel;
use super::problem::{Problem, Unpacked};
use crate::dataset::Place;
use crate::model::pitch::{Driven, Point};
use core::cell::OnceCell;

/// Predictions start this far apart, s.
const STRIDE_S: f64 = 0.1;

/// VAF of a prediction, per cent, with its standard error over blocks.
pub type Vaf = (f64, f64);

/// VAF at each of `horizons` (s, ascending; to the next reading where none was taken there) over `places` together, `None` where they are too short for any prediction so far
/// ahead. `None` for all where the predictor diverges.
pub fn horizon_vaf(
    problem: &Problem<'_>,
    unpacked: &Unpacked,
    places: &[Place],
    horizons: &[f64],
) -> Option<Vec<Option<Vaf>>> {
    let sums = sums_by_block(problem, unpacked, places, horizons)?;
    Some(sums.iter().map(|blocks| ratio(blocks)).collect())
}

/// Odds that predictions `horizon` s ahead of a model as good as `rival` look as much worse than those of `model` by chance: the
/// squared errors block by block, against the spread of their differences (Diebold and Mariano, J. Bus. Econ. Stat. 13, 1995).
/// `None` where one of them diverges.
pub fn indistinct_ahead(
    problem: &Problem<'_>,
    [model, rival]: [&Unpacked; 2],
    places: &[Place],
    horizon: f64,
) -> Option<f64> {
    let of = |unpacked: &Unpacked| sums_by_block(problem, unpacked, places, &[horizon])?.pop();
    let (model, rival) = (of(model)?, of(rival)?);
    let differences: Vec<f64> = model.iter().zip(&rival).map(|(a, b)| b.1[0] - a.1[0]).collect();
    let n = differences.len().max(2) as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let spread = (differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let score = mean * n.sqrt() / spread.max(f64::MIN_POSITIVE);
    Some(0.5 * statrs::function::erf::erfc(score / std::f64::consts::SQRT_2))
}

/// Sums of a block.
type Block = (usize, [f64; 2]);

/// For each of `horizons`, squared errors and squared deviations from the mean, block by block.
fn sums_by_block(
    problem: &Problem<'_>,
    unpacked: &Unpacked,
    places: &[Place],
    horizons: &[f64],
) -> Option<Vec<Vec<Block>>> {
    let mut starts: Vec<(usize, usize, Point)> = Vec::new();
    let mut awaited = false;
    let visit = |run: usize, k: usize, point: &Point| {
        let stride = (STRIDE_S / problem.data.runs[run].step).round().max(1.0) as usize;
        // where nothing was measured in the row of a start, the next reading is one
        awaited = k.is_multiple_of(stride) || awaited && !problem.data.runs[run].is_measured(k - 1);
        if awaited
            && problem.counted[run][k]
            && let Some(place) = places.iter().position(|p| p.run == run && p.rows.contains(&k))
        {
            starts.push((place, k, *point));
        }
    };
    problem.track(unpacked, visit, &mut |_, _| {})?;
    let mean = mean_of(problem, places);
    let mut sums: Vec<Vec<Block>> = vec![Vec::new(); horizons.len()];
    let models = problem.models(unpacked)?;
    let driven: Vec<OnceCell<Driven<'_, '_>>> = models.iter().map(|_| OnceCell::new()).collect();
    for (place, start, mut point) in starts {
        let index = places[place].run;
        let (run, model) = (&problem.data.runs[index], &models[index]);
        let driven = driven[index].get_or_init(|| model.driven(run));
        let measured = problem.data.judged(&places[place]);
        let block = place << 32 | (start as f64 * run.step / BLOCK_S) as usize;
        let mut row = start;
        for (horizon, sums) in horizons.iter().zip(&mut sums) {
            let end = start + (horizon / run.step).round().max(1.0) as usize;
            let measured_from = (end..places[place].rows.end).find(|&k| run.is_measured(k));
            let Some(end) = measured_from else { break };
            while row < end {
                if !driven.advance(&mut point, row) {
                    return None;
                }
                row += 1;
            }
            let y = measured[end - places[place].rows.start];
            let error = y - judged_channel(problem, &[model.output(&point)])[0];
            let add = [error * error, (y - mean) * (y - mean)];
            match sums.last_mut() {
                Some((last, sum)) if *last == block => {
                    sum[0] += add[0];
                    sum[1] += add[1];
                }
                _ => sums.push((block, add)),
            }
        }
    }
    Some(sums)
}

fn mean_of(problem: &Problem<'_>, places: &[Place]) -> f64 {
    let all = || places.iter().flat_map(|place| problem.data.judged(place));
    all().sum::<f64>() / all().count().max(1) as f64
}

/// 100 (1 − Σ a / Σ b) over blocks, and its standard error (ratio of means; Cochran, Sampling Techniques, 1977, eq. 2.46).
fn ratio(blocks: &[Block]) -> Option<Vaf> {
    let total = blocks.iter().fold([0.0, 0.0], |s, (_, b)| [s[0] + b[0], s[1] + b[1]]);
    if total[1] <= 0.0 {
        return None;
    }
    let ratio = total[0] / total[1];
    let n = blocks.len() as f64;
    let spread: f64 = blocks.iter().map(|(_, b)| (b[0] - ratio * b[1]).powi(2)).sum();
    let error = (spread * n / (n - 1.0).max(1.0)).sqrt() / total[1];
    Some((100.0 * (1.0 - ratio).max(0.0), 100.0 * error))
}

#[cfg(test)]
mod tests;
