//! Where a signal is held at its limit, and where it only comes to rest there.
//!
//! What is clipped runs into its limit and out of it: over a few rows before and after, it moves as it does elsewhere. What
//! friction holds, and what turns about, arrives slowly:
//!
//! ```text
//! |x_i − x_{i−w}|, |x_{j+w} − x_j| ≥ √⟨(x_{k+w} − x_k)²⟩/4 and 3 of its smallest steps,    plateau i .. j,  w = (j − i)/2, 1 to 5 rows
//! ```

use std::ops::Range;

/// Least speed of arrival and departure, relative to the signal's usual one.
const AT_SPEED: f64 = 0.25;
/// and in smallest steps: of a coarse signal one step is what rounding makes.
const ROUNDED: f64 = 2.5;
/// Most rows over which the speed is taken.
const MOST_ROWS: usize = 5;

/// Runs of at least `shortest` rows at exactly `level`, which the signal runs into and out of at speed.
pub(crate) fn plateaus(values: &[f64], level: f64, shortest: usize) -> Vec<Range<usize>> {
    let mut start = 0;
    let runs = values.chunk_by(|a, b| a == b).map(|run| {
        start += run.len();
        (run[0], start - run.len()..start)
    });
    let long = runs.filter(|(value, rows)| *value == level && rows.len() >= shortest);
    let mut long = long.map(|(_, rows)| rows).peekable();
    if long.peek().is_none() {
        return Vec::new();
    }
    let rounding = ROUNDED * smallest_step(values);
    let least: Vec<f64> = (1..=MOST_ROWS).map(|w| rounding.max(AT_SPEED * usual(values, w))).collect();
    long.filter(|rows| {
        let over = (rows.len() / 2).clamp(1, MOST_ROWS);
        at_speed(values, rows, over, least[over - 1])
    })
    .collect()
}

/// Whether a signal moves by `least` in the `over` rows before and after. An end of it cannot be judged, and is given the benefit of
/// the other one.
fn at_speed(values: &[f64], rows: &Range<usize>, over: usize, least: f64) -> bool {
    let before = rows.start.checked_sub(over).map(|first| (values[rows.start] - values[first]).abs());
    let after = values.get(rows.end - 1 + over).map(|last| (last - values[rows.start]).abs());
    let mut ends = before.into_iter().chain(after).peekable();
    ends.peek().is_some() && ends.all(|moved| moved >= least)
}

/// Root mean square of what a signal moves in `over` rows.
fn usual(values: &[f64], over: usize) -> f64 {
    let squares: f64 = values.windows(over + 1).map(|w| (w[over] - w[0]).powi(2)).sum();
    (squares / values.len().saturating_sub(over).max(1) as f64).sqrt()
}

/// The smallest change from one value to the next; infinite where there is none.
pub(super) fn smallest_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::plateaus;

    fn sine(k: usize) -> f64 {
        (0.05 * k as f64).sin()
    }

    #[test]
    fn a_sine_that_is_cut_is_held_and_one_that_is_rounded_is_not() {
        let cut: Vec<f64> = (0..1000).map(|k| sine(k).clamp(-2.0, 0.8)).collect();
        assert_eq!(plateaus(&cut, 0.8, 3).len(), 8);
        for levels in [4.0, 12.0, 100.0] {
            let rounded: Vec<f64> = (0..1000).map(|k| (levels * sine(k)).round() / levels).collect();
            assert!(plateaus(&rounded, 1.0, 3).is_empty());
        }
    }

    #[test]
    fn what_slows_down_comes_to_rest_and_is_not_held() {
        // up by a parabola, at rest, and down by another
        let slide = |k: usize| {
            let x = (k % 200) as f64 / 40.0;
            if x < 1.0 {
                1.0 - (1.0 - x).powi(2)
            } else if x < 2.5 {
                1.0
            } else if x < 3.5 {
                1.0 - (x - 2.5).powi(2)
            } else {
                0.0
            }
        };
        let values: Vec<f64> = (0..2000).map(slide).collect();
        assert!(plateaus(&values, 1.0, 3).is_empty());
        // into a stop and away from it
        let values: Vec<f64> = values.iter().map(|x| x.min(0.6)).collect();
        assert_eq!(plateaus(&values, 0.6, 3).len(), 10);
    }
}
