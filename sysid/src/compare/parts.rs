//! What a part of a recording says by itself of the response to the input.
//!
//! In a closed loop a fit may find the controller, or a mixture of it and the craft, and find it again wherever data are left
//! out one span at a time: the starts are the same and the rest outvotes the span. Fitted afresh, parts that are no
//! realisations of one craft differ by more than their intervals.

use super::side::{fitted, posed};
use crate::dataset::pieces;
use crate::likelihood::problem::Problem;
use crate::model::file::ModelFile;
use crate::recording::Recording;
use std::ops::Range;

/// Least length of a part, s, and how many there are.
const PART_S: f64 = 8.0;
const PARTS: [usize; 2] = [3, 8];

/// The response to the input.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// ∂M/∂u.
    pub gain: f64,
    /// ∂M/∂q.
    pub damping: f64,
    /// Delay and time constant of the servo's lag together, s.
    pub late: f64,
}

/// The response in each part of equal length that can be fitted by itself.
pub fn responses(recordings: &[Recording], model: Option<&ModelFile>) -> Vec<Response> {
    let rows = |recording: &Recording| recording.segments.iter().map(ExactSizeIterator::len).sum::<usize>();
    let seconds: f64 = recordings.iter().map(|r| rows(r) as f64 * r.step).sum();
    let count = ((seconds / PART_S) as usize).clamp(PARTS[0], PARTS[1]);
    let part = |k: usize| {
        let cut = |recording: &Recording| Recording {
            segments: share(&recording.segments, k, count),
            ..recording.clone()
        };
        recordings.iter().map(cut).filter(|cut| !cut.segments.is_empty()).collect::<Vec<Recording>>()
    };
    (0..count).filter_map(|k| response(&part(k), model)).collect()
}

/// The `k`-th of `count` equal shares of the rows of `segments`.
fn share(segments: &[Range<usize>], k: usize, count: usize) -> Vec<Range<usize>> {
    let all: usize = segments.iter().map(ExactSizeIterator::len).sum();
    pieces(segments.iter().map(ExactSizeIterator::len), k * all / count..(k + 1) * all / count)
        .map(|(i, rows)| segments[i].start + rows.start..segments[i].start + rows.end)
        .filter(|rows| rows.len() > 1)
        .collect()
}

fn response(part: &[Recording], model: Option<&ModelFile>) -> Option<Response> {
    let (data, baseline, _) = posed(part, model).ok()?;
    let problem = Problem::new(&data, &baseline, &[]);
    let fit = fitted(&problem, false)?;
    Some(Response::of(&problem, &fit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_hold_every_row_once_and_no_gap() {
        let segments = [Range { start: 0, end: 100 }, Range { start: 120, end: 170 }];
        let shares: Vec<Range<usize>> = (0..3).flat_map(|k| share(&segments, k, 3)).collect();
        assert_eq!(shares, [0..50, 50..100, 120..170]);
    }
}
