//! The clock of a recording: duplicates, order, step, gaps, and the uniform grid.
//!
//! Step T: median m of the differences d of the time stamps, then T = Σd / Σround(d/m) over the differences that
//! are no gap, so that stamps written with few digits do not drift against the grid; of rows that come in bursts the
//! median of the means of eight differences. With K the count of steps from the start of a segment, the stamps lie at
//! t_0 + K T + e; the stamps are snapped where |e| ≤ `SNAP`·T, and where the [rows are even](super::even_rows) though the
//! stamps are not.

use std::ops::Range;

use super::columns::Role;
use super::even_rows::{EvenRows, even_rows};
use super::options::{InputHold, ReadOptions};
use super::table::Table;
use super::{Note, NoteKind};
use super::{same_stamps, stale};
use crate::error::{Error, ErrorKind};

/// A difference beyond this many steps is a gap; up to two missing samples are filled.
const GAP: f64 = 3.5;
/// A difference beyond this many steps has a row missing in it.
const MISSING: f64 = 1.5;
/// Rows over which bursts of stamps even out.
const BURSTS: usize = 8;
/// Jitter, in steps, that is snapped to the grid; more is resampled.
const SNAP: f64 = 0.05;
/// Jitter, in steps, that is the rounding of the numbers and not worth a word.
const ROUNDING: f64 = 1e-4;
/// Relative difference of two steps that is the rounding of the sums alone.
const SAME_STEP: f64 = 1e-10;
/// Step, s, below which rows may be that far apart in truth.
const SLOW: f64 = 2.0;
/// Steps, s, that a rig of this kind can have: 100 kHz to 2 Hz.
const STEPS: Range<f64> = 1e-5..0.5;
/// Notes of one kind that are written out; the rest are counted.
const MOST_NOTES: usize = 5;

/// The uniform grid: `Table` holds the data on it.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) step: f64,
    pub(super) segments: Vec<Range<usize>>,
}

/// Fewer samples than needed.
pub(super) fn too_short(found: usize, step: f64) -> Error {
    let found = match step * found as f64 {
        seconds if seconds > 0.0 => format!("{found} samples ({seconds:.3} s)"),
        _ => format!("{found} samples"),
    };
    Error::new(ErrorKind::TooShort, found, "record longer, or join sections that belong together")
}

/// Checks the time stamps and puts the table onto a uniform grid, segment by segment.
pub(super) fn onto_grid(
    table: &mut Table,
    options: &ReadOptions,
    notes: &mut Vec<Note>,
) -> Result<Grid, Error> {
    let needed = options.min_samples.max(3);
    let expected = format!("at least {needed} samples without a gap");
    drop_duplicates(table, notes);
    same_stamps::spread(table, notes);
    refuse_bad_order(table)?;
    if table.t.len() < needed {
        return Err(too_short(table.t.len(), 0.0).expecting(expected));
    }
    let (median, in_bursts) = usual_step(&table.t);
    check_step(table, median)?;
    let stretches = split_at_gaps(&table.t, median);
    let longest = stretches.iter().map(ExactSizeIterator::len).max().unwrap_or(0);
    if longest < needed {
        let error = too_short(longest, median).expecting(expected);
        return Err(Error {
            found: format!("gaps every few samples: no stretch is longer than {}", error.found).into(),
            ..error
        });
    }
    let step = if in_bursts { median } else { refine_step(&table.t, median) };
    note_gaps(table, &stretches, step, notes);
    let jitter = stretches.iter().map(|rows| jitter(&table.t[rows.clone()], step)).fold(0.0, f64::max);
    let even = if jitter > SNAP { even_rows(table, &stretches, median) } else { None };
    let varying = jitter > SNAP && even.is_none();
    let step = even.as_ref().map_or(step, |even| even.step);
    if let Some(even) = even {
        note_even(&even, notes);
        table.t = even.t;
    } else if varying {
        note_resampled(&table.t, &stretches, step, options.input_hold, notes);
    } else {
        snap(&mut table.t, &stretches, step, jitter, notes);
    }
    if !table.unmeasured.contains(&true) {
        table.unmeasured = stale::rows(table, step, notes);
    }
    let segments = resample(table, &stretches, step, varying, options.input_hold, notes);
    Ok(Grid { step, segments })
}

/// Refuses stamps that do not grow.
fn refuse_bad_order(table: &Table) -> Result<(), Error> {
    let wrong: Vec<usize> = (1..table.t.len()).filter(|&row| table.t[row] <= table.t[row - 1]).collect();
    let told = wrong.iter().take(Error::MOST_TOLD).map(|&row| bad_order(table, row)).collect();
    Error::of_several(told, wrong.len()).map_or(Ok(()), Err)
}

/// Drops rows that repeat the one before in time and all values.
fn drop_duplicates(table: &mut Table, notes: &mut Vec<Note>) {
    let again = |row: &usize| table.t[*row] == table.t[row - 1] && same_values(table, *row);
    let dropped: Vec<usize> = (1..table.t.len()).filter(again).collect();
    let (Some(&first), Some(&last)) = (dropped.first(), dropped.last()) else { return };
    let text = format!(
        "{} dropped: same time and values as the row before (first {}t = {} s)",
        counted(dropped.len(), "duplicate row"),
        table.lines.get(first).map_or("at ".to_owned(), |line| format!("in line {line}, ")),
        table.t[first]
    );
    notes.push(Note::over(NoteKind::Duplicate, table.t[first], table.t[last], text));
    table.remove(&dropped);
}

fn same_values(table: &Table, row: usize) -> bool {
    table.signals.iter().all(|s| s.values[row] == s.values[row - 1])
        && (table.labels.is_empty() || table.labels[row] == table.labels[row - 1])
        && (table.supervised.is_empty() || table.supervised[row] == table.supervised[row - 1])
}

fn bad_order(table: &Table, row: usize) -> Error {
    let (before, now) = (table.t[row - 1], table.t[row]);
    let (found, advice) = if now < before {
        (
            format!("time runs backwards: {now} s after {before} s"),
            "if two recordings were joined, separate them; if the clock was reset or wrapped, correct the stamps",
        )
    } else {
        (
            format!("time stands still at {now} s while the values change"),
            "write the time with more decimals, or delete the rows of one of the two sources; where rows that were taken at an even pace were \
             stamped as they came in, count them: --column 't_s=row*0.01' for rows of 0.01 s",
        )
    };
    let error = Error::new(ErrorKind::Clock, found, advice)
        .in_column(table.time.name.as_str())
        .expecting("time stamps that grow from row to row");
    Error { line: table.lines.get(row).map(|&line| line as usize), ..error }
}

/// The median of the differences, or, of rows that come in bursts, that of the means of [`BURSTS`] of them; and whether they do.
fn usual_step(t: &[f64]) -> (f64, bool) {
    let single = median_step(t, 1);
    let of_many = median_step(t, BURSTS.min(t.len() - 1));
    let in_bursts = of_many > MISSING * single;
    (if in_bursts { of_many } else { single }, in_bursts)
}

/// Median of the mean differences of `rows` rows in turn.
pub(super) fn median_step(t: &[f64], rows: usize) -> f64 {
    let mut steps: Vec<f64> = t.windows(rows + 1).map(|few| (few[rows] - few[0]) / rows as f64).collect();
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn check_step(table: &Table, step: f64) -> Result<(), Error> {
    if STEPS.contains(&step) {
        return Ok(());
    }
    let scaled =
        |unit: &str, factor| format!("this looks like {unit}: read it with {}", table.time.scaled_by(factor));
    let advice = match step {
        s if s < STEPS.start => "check the unit of the time stamps: they must be seconds".to_owned(),
        s if s < SLOW => format!(
            "if the stamps are milliseconds, read it with {}; rows so far apart in seconds are too few to tell a lag or a delay",
            table.time.scaled_by(1e-3)
        ),
        s if s < 500.0 => scaled("milliseconds", 1e-3),
        s if s < 5e5 => scaled("microseconds", 1e-6),
        _ => scaled("nanoseconds", 1e-9),
    };
    let error =
        Error::new(ErrorKind::Clock, format!("a step of {step:.6} s between samples (median)"), advice)
            .in_column(table.time.name.as_str())
            .expecting(format!("a step between {:e} and {} s", STEPS.start, STEPS.end));
    Err(Error { line: table.lines.get(1).map(|&line| line as usize), ..error })
}

fn split_at_gaps(t: &[f64], median: f64) -> Vec<Range<usize>> {
    let mut starts = vec![0];
    starts.extend((1..t.len()).filter(|&k| t[k] - t[k - 1] > GAP * median));
    let ends = starts.iter().skip(1).copied().chain([t.len()]);
    starts.iter().copied().zip(ends).map(|(start, end)| start..end).collect()
}

/// T = Σd / Σround(d/m), rounded to a short decimal where only the sum's rounding stands between the two.
fn refine_step(t: &[f64], median: f64) -> f64 {
    let mut step = median;
    for _ in 0..2 {
        let (mut time, mut steps) = (0.0, 0.0);
        for d in t.windows(2).map(|pair| pair[1] - pair[0]).filter(|&d| d <= GAP * median) {
            time += d;
            steps += (d / step).round().max(1.0);
        }
        step = time / steps;
    }
    let short = [1e6, 1e9].map(|scale| (step * scale).round() / scale);
    short.into_iter().find(|s| (s - step).abs() < SAME_STEP * step).unwrap_or(step)
}

/// Count of steps from the first stamp, for every stamp of a stretch.
fn step_counts(t: &[f64], step: f64) -> impl Iterator<Item = f64> {
    let mut count = 0.0;
    let increments = t.windows(2).map(move |pair| ((pair[1] - pair[0]) / step).round().max(1.0));
    std::iter::once(0.0).chain(increments).map(move |n| {
        count += n;
        count
    })
}

/// Least and largest deviation of the stamps from t_0 + K T, s.
fn deviations(t: &[f64], step: f64) -> [f64; 2] {
    let start = t.first().copied().unwrap_or(0.0);
    let deviations = t.iter().zip(step_counts(t, step)).map(|(t, count)| t - start - count * step);
    deviations.fold([0.0, 0.0], |[low, high]: [f64; 2], e| [low.min(e), high.max(e)])
}

/// Half the spread of the deviations, in steps.
fn jitter(t: &[f64], step: f64) -> f64 {
    let [low, high] = deviations(t, step);
    0.5 * (high - low) / step
}

fn snap(t: &mut [f64], stretches: &[Range<usize>], step: f64, jitter: f64, notes: &mut Vec<Note>) {
    if jitter <= ROUNDING {
        return;
    }
    for rows in stretches {
        let stamps = &mut t[rows.clone()];
        let [low, high] = deviations(stamps, step);
        let start = stamps[0] + 0.5 * (low + high);
        let counts: Vec<f64> = step_counts(stamps, step).collect();
        for (stamp, count) in stamps.iter_mut().zip(counts) {
            *stamp = start + count * step;
        }
    }
    let text = format!(
        "time stamps jitter by up to {:.1} % of the step ({:.7} s): snapped to a uniform grid",
        100.0 * jitter,
        step
    );
    notes.push(Note::new(NoteKind::Snapped, text));
}

fn note_even(even: &EvenRows, notes: &mut Vec<Note>) {
    let text = format!(
        "the rows were sampled every {:.7} s and stamped up to {:.1} ms off: by their count the motion is smoother than by the stamps, \
         which were put onto a uniform grid",
        even.step,
        1e3 * even.off
    );
    notes.push(Note::new(NoteKind::Snapped, text));
}

fn note_gaps(table: &Table, stretches: &[Range<usize>], step: f64, notes: &mut Vec<Note>) {
    let t = &table.t;
    for rows in stretches.iter().skip(1).take(MOST_NOTES) {
        let (from, to) = (t[rows.start - 1], t[rows.start]);
        let missing = ((to - from) / step).round() - 1.0;
        let text = format!(
            "gap of {:.3} s after t = {from} s ({}{missing} samples missing): the recording is split there, nothing is interpolated across it",
            to - from,
            table.lines.get(rows.start).map_or(String::new(), |line| format!("line {line}; "))
        );
        notes.push(Note::over(NoteKind::Gap, from, to, text));
    }
    if stretches.len() > MOST_NOTES + 1 {
        let (first, last) = (stretches[MOST_NOTES + 1].start, stretches[stretches.len() - 1].start);
        let text = format!("{} more gaps like these", stretches.len() - 1 - MOST_NOTES);
        notes.push(Note::over(NoteKind::Gap, t[first - 1], t[last], text));
    }
}

fn note_resampled(t: &[f64], stretches: &[Range<usize>], step: f64, hold: InputHold, notes: &mut Vec<Note>) {
    let steps = stretches.iter().flat_map(|rows| t[rows.clone()].windows(2).map(|pair| pair[1] - pair[0]));
    let (low, high) = steps.fold((f64::INFINITY, 0.0_f64), |(low, high), d| (low.min(d), high.max(d)));
    let input = match hold {
        InputHold::Held => "input held",
        InputHold::Interpolated => "input interpolated",
    };
    let text = format!(
        "the step varies from {low:.6} to {high:.6} s: resampled to {step:.7} s ({input}, outputs interpolated)"
    );
    notes.push(Note::new(NoteKind::Resampled, text));
}

/// Where a grid point lies: behind row `row` by the fraction `part` of the way to the next.
struct Point {
    row: usize,
    part: f64,
    /// The row whose held values it has: the nearer one, unless rows are missing between the two. The one before would be late by
    /// a share of the step that wanders with the stamps, as no loop's delay does.
    held: usize,
    /// The nearer row.
    nearer: usize,
    /// Whether rows are missing there, and none was measured within half a step.
    is_filled: bool,
}

/// Lays the grid over every stretch and moves the table onto it; returns the stretches' new rows.
fn resample(
    table: &mut Table,
    stretches: &[Range<usize>],
    step: f64,
    varying: bool,
    hold: InputHold,
    notes: &mut Vec<Note>,
) -> Vec<Range<usize>> {
    let complete = |rows: &Range<usize>| {
        step_counts(&table.t[rows.clone()], step).last() == Some(rows.len() as f64 - 1.0)
    };
    if !varying && stretches.iter().all(complete) {
        return stretches.to_vec();
    }
    let (mut points, mut times, mut segments, mut filled) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for rows in stretches {
        let t = &table.t[rows.clone()];
        let span = t[t.len() - 1] - t[0];
        let count = (span / step + ROUNDING.max(1e-3)).floor() as usize + 1;
        let first = points.len();
        let mut at = 0;
        for k in 0..count {
            let time = t[0] + k as f64 * step;
            while at + 2 < t.len() && t[at + 1] <= time + 1e-3 * step {
                at += 1;
            }
            let point = place(t, at, time, step);
            let [row, held, nearer] = [point.row, point.held, point.nearer].map(|row| rows.start + row);
            points.push(Point { row, held, nearer, ..point });
            times.push(time);
        }
        filled += count.saturating_sub(rows.len());
        segments.push(first..points.len());
    }
    if !varying {
        let text = format!("{} filled (input held, outputs interpolated)", counted(filled, "missing sample"));
        notes.push(Note::new(NoteKind::Filled, text));
    }
    move_onto(table, &points, times, hold);
    segments
}

fn place(t: &[f64], at: usize, time: f64, step: f64) -> Point {
    let on = |row: usize| Point { row, part: 0.0, held: row, nearer: row, is_filled: false };
    let Some(next) = t.get(at + 1) else { return on(at) };
    let near = 1e-3 * step;
    if (time - next).abs() <= near {
        return on(at + 1);
    }
    if time - t[at] <= near {
        return on(at);
    }
    let part = ((time - t[at]) / (next - t[at])).clamp(0.0, 1.0);
    let is_missing = next - t[at] > MISSING * step;
    let nearer = if part > 0.5 { at + 1 } else { at };
    let is_filled = is_missing && part.min(1.0 - part) * (next - t[at]) > 0.5 * step;
    Point { row: at, part, held: if is_missing { at } else { nearer }, nearer, is_filled }
}

fn move_onto(table: &mut Table, points: &[Point], times: Vec<f64>, hold: InputHold) {
    let is_stale = |row: usize| table.unmeasured.get(row) == Some(&true);
    for signal in &mut table.signals {
        let old = &signal.values;
        let held = signal.source.role.is_held()
            && !(signal.source.role.is_command() && hold == InputHold::Interpolated);
        let is_output = matches!(signal.source.role, Role::Q | Role::Theta);
        let on_grid = |point: &Point| {
            if held {
                return old[point.held];
            }
            // what stands between an old reading and a new one was never measured
            if is_output && (is_stale(point.row) || is_stale(point.row + 1)) {
                return old[if is_stale(point.nearer) { point.row } else { point.nearer }];
            }
            let value = old[point.row];
            match old.get(point.row + 1) {
                Some(next) if point.part > 0.0 => value + point.part * (next - value),
                _ => value,
            }
        };
        signal.values = points.iter().map(on_grid).collect();
    }
    table.unmeasured = points.iter().map(|point| point.is_filled || is_stale(point.nearer)).collect();
    let rows = || points.iter().map(|point| point.row);
    if !table.labels.is_empty() {
        table.labels = rows().map(|row| table.labels[row]).collect();
    }
    if !table.supervised.is_empty() {
        table.supervised = rows().map(|row| table.supervised[row]).collect();
    }
    if !table.lines.is_empty() {
        table.lines = rows().map(|row| table.lines[row]).collect();
    }
    table.t = times;
}

/// `1 row`, `2 rows`.
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
