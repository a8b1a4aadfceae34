//! Rows in which a slower sensor's last reading was logged again.
//!
//! While a signal moves by several of its smallest steps at each change, a reading exactly as the one before is that one: nothing
//! new had arrived. At rest, and where it turns about, it may be news, and counts as such once in as many rows as a reading is
//! held for while the signal moves. A sensor that is slower than the log keeps its pace: where the readings are held for whatever
//! time, it is the body that stands still.

use super::checks::extremes;
use super::columns::Role;
use super::missing::bridge;
use super::table::{Signal, Table};
use super::{Note, NoteKind};
use std::ops::Range;

/// Smallest steps from which on a change is motion.
const MOVES: f64 = 3.0;
/// Share of the rows that repeat the one before, among those in motion, from which on a sensor is slower than its log.
const REPEATED: f64 = 0.02;
/// Share of the readings that are held for as many rows as half of them, or one more or less, of a sensor that keeps its pace. What
/// moves in jerks stands still for as long as it likes.
const EVEN: f64 = 0.9;
/// Fewest rows in motion that are judged.
const FEWEST: usize = 20;

/// A signal that is logged faster than it is measured.
struct Slow {
    /// For every row, whether it repeats an older reading.
    stale: Vec<bool>,
    /// Rows for which a reading is held, mean and median.
    mean: f64,
    median: usize,
}

/// For every row, whether no output is new in it; empty where all are. Tells which are slower than the log of `step` s. Readings of
/// a slower one beside one that is new in each row are joined by straight lines.
pub(super) fn rows(table: &mut Table, step: f64, notes: &mut Vec<Note>) -> Vec<bool> {
    let outputs = table.signals.iter_mut().filter(|s| matches!(s.source.role, Role::Q | Role::Theta));
    let mut slow: Vec<(&mut Signal, Option<Slow>)> = outputs
        .map(|signal| {
            let slow = slow(&signal.values);
            (signal, slow)
        })
        .collect();
    let all = slow.iter().all(|(_, slow)| slow.is_some());
    for (signal, slow) in slow.iter_mut().filter_map(|(signal, slow)| Some((signal, slow.as_ref()?))) {
        let left_out = if all {
            "; rows in which no output is new do not count"
        } else {
            let values = signal.values.iter_mut().zip(&slow.stale);
            values.filter(|(_, stale)| **stale).for_each(|(value, _)| *value = f64::NAN);
            bridge(&mut signal.values, false);
            "; its readings are joined by straight lines"
        };
        let late = step * (slow.median.max(2) as f64 - 1.0);
        let text = format!(
            "{} changes only every {:.1} samples while it moves: it is measured more slowly than it is logged, and up to {late:.4} s \
             late{left_out}",
            signal.source.name, slow.mean
        );
        notes.push(Note::new(NoteKind::Repeated, text));
    }
    if !all {
        return Vec::new();
    }
    (0..table.t.len())
        .map(|row| slow.iter().all(|(_, slow)| slow.as_ref().is_some_and(|s| s.stale[row])))
        .collect()
}

/// The step than which one in a thousand is smaller: a single value that was bridged or made continuous stands between two others.
fn usual_least_step(values: &[f64]) -> Option<f64> {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    let place = steps.len() / 1000;
    (place < steps.len()).then(|| *steps.select_nth_unstable_by(place, f64::total_cmp).1)
}

/// What there is of held readings in `values`; `None` where no more repeat than chance and rounding make.
fn slow(values: &[f64]) -> Option<Slow> {
    let smallest = usual_least_step(values)?;
    let (low, high) = extremes(values);
    let mut start = 0;
    let runs: Vec<Range<usize>> = values
        .chunk_by(|a, b| a == b)
        .map(|run| {
            start += run.len();
            start - run.len()..start
        })
        .collect();
    // what stays at its extreme may clip, and the length of the first and the last is not known
    let moves = |row: usize| (values[row] - values[row - 1]).abs() >= MOVES * smallest;
    let in_motion = |run: &Range<usize>| {
        let inside = values[run.start] > low && values[run.start] < high;
        inside && run.start > 0 && run.end < values.len() && moves(run.start) && moves(run.end)
    };
    let mut lengths: Vec<usize> =
        runs.iter().filter(|run| in_motion(run)).map(ExactSizeIterator::len).collect();
    let rows: usize = lengths.iter().sum();
    let repeats = rows - lengths.len();
    // a rounded signal makes about twice as many smallest steps as repetitions
    let small =
        values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|d| *d > 0.0 && *d <= 1.5 * smallest);
    if rows < FEWEST || (repeats as f64) < REPEATED * rows as f64 || 2 * small.count() > repeats {
        return None;
    }
    lengths.sort_unstable();
    let median = lengths[lengths.len() / 2];
    let even = lengths.iter().filter(|length| length.abs_diff(median) <= 1).count();
    if (even as f64) < EVEN * lengths.len() as f64 {
        return None;
    }
    let mut stale = vec![false; values.len()];
    for run in &runs {
        // one reading comes a row early or late
        let is_one = in_motion(run) && run.len() <= 2 * median || median > 1 && run.len() == median + 1;
        let held_for = if is_one { run.len() } else { median };
        run.clone().for_each(|row| stale[row] = !(row - run.start).is_multiple_of(held_for));
    }
    Some(Slow { stale, mean: rows as f64 / lengths.len() as f64, median })
}

#[cfg(test)]
mod tests {
    use super::slow;

    fn swing(row: usize) -> f64 {
        (0.05 * row as f64).sin() + 0.4 * (0.21 * row as f64).sin()
    }

    /// `value` in steps of `step`.
    fn rounded(value: f64, step: f64) -> f64 {
        (value / step).round() * step
    }

    #[test]
    fn a_reading_that_is_held_while_it_moves_is_new_once() {
        let held = |rows: usize| -> Vec<f64> { (0..600).map(|row| swing(row / rows * rows)).collect() };
        assert!(slow(&held(1)).is_none());
        for rows in [2, 6] {
            let slow = slow(&held(rows)).unwrap();
            assert_eq!((slow.median, slow.mean), (rows, rows as f64));
            let fresh = slow.stale.iter().filter(|stale| !**stale).count();
            assert_eq!(fresh, 600 / rows);
        }
    }

    #[test]
    fn now_and_then_late_is_told_by_row() {
        let late = |row: usize| swing(if row % 8 == 5 { row - 1 } else { row });
        let values: Vec<f64> = (0..400).map(late).collect();
        let slow = slow(&values).unwrap();
        assert_eq!(slow.median, 1);
        let stale: Vec<usize> = (0..400).filter(|row| slow.stale[*row]).collect();
        assert!(stale.len() >= 45 && stale.iter().all(|row| row % 8 == 5), "{stale:?}");
    }

    #[test]
    fn rounding_rest_and_a_limit_are_no_held_readings() {
        let of = |value: fn(usize) -> f64| slow(&(0..600).map(value).collect::<Vec<_>>()).is_none();
        assert!(of(|row| rounded(swing(row), 0.05)));
        assert!(of(|row| rounded(swing(row).max(0.0), 1e-4)), "at rest half of the time");
        assert!(of(|row| swing(row).clamp(-0.9, 0.9)));
        assert!(of(|_| 0.3));
    }

    #[test]
    fn what_moves_in_jerks_is_no_slow_sensor() {
        let mut values = Vec::new();
        for jerk in 0..80_usize {
            values.extend(std::iter::repeat_n(swing(3 * jerk), 1 + jerk * 7 % 6));
        }
        assert!(slow(&values).is_none());
    }

    #[test]
    fn at_rest_a_reading_counts_as_often_as_one_comes() {
        let moved = |row: usize| if row < 300 { swing(row / 5 * 5) } else { swing(295) };
        let slow = slow(&(0..600).map(moved).collect::<Vec<_>>()).unwrap();
        let fresh = (300..600).filter(|row| !slow.stale[*row]).count();
        assert_eq!(fresh, 60);
    }
}
