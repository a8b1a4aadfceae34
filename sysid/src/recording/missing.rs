//! Cells without a number: empty, NaN, or a word that loggers write for it.
//!
//! A row without time, input, rate or angle is left out: the clock then sees a gap. A command that was logged less often than the
//! motion is carried from each of its rows to the next, and the readings of a rate or an angle that was logged less often than the
//! other are joined by straight lines. A column that is not needed in every
//! row is bridged there, commands held, measured signals by straight lines. A column without any number, and a rate or
//! angle that is missing in most rows while the other is there, is not used. All of it is told.

use super::airborne::median;
use super::clock::counted;
use super::columns::Role;
use super::options::InputHold;
use super::table::{Signal, Table};
use super::{Note, NoteKind};
use crate::error::{Error, ErrorKind};

/// Lines that a note names.
const LINES_TOLD: usize = 5;

/// Rows with a measurement between two with the command, by their median, from which on it was logged less often.
const SLOWER: f64 = 1.5;
/// Readings of a rate or an angle that follow each other in this time or less, s, are joined, over so many times as long at most.
const SLOWEST_JOINED_S: f64 = 0.06;
const LONGEST_JOINED: f64 = 3.5;
/// Times its usual distance for which such a command is held; longer, it is missing.
const LONGEST_HOLD: f64 = 10.0;

/// Whether a cell says that nothing was measured: empty, or one of the words that loggers write for it.
pub(super) fn is_missing(cell: &str) -> bool {
    const WORDS: [&str; 8] = ["nan", "na", "n/a", "null", "none", "nil", "-", "#n/a"];
    let bare = cell.trim_start_matches(['+', '-']);
    cell.is_empty()
        || WORDS.iter().any(|word| cell.eq_ignore_ascii_case(word))
        || bare.get(..3).is_some_and(|start| start.eq_ignore_ascii_case("nan"))
            && (bare.len() == 3 || bare[3..].starts_with('('))
}

/// Leaves no cell without a number in `table`, whose input is as `hold` says between its rows.
pub(super) fn leave_out(table: &mut Table, hold: InputHold, notes: &mut Vec<Note>) -> Result<(), Error> {
    join_slower_output(table, notes);
    drop_sparse(table, notes)?;
    carry_slower_commands(table, hold == InputHold::Held, notes);
    for signal in table.signals.iter_mut().filter(|signal| !is_needed(signal)) {
        let rows = missing(&signal.values);
        if let (Some(&first), Some(&last)) = (rows.first(), rows.last()) {
            let how = if signal.source.role.is_held() { "the value before" } else { "straight lines" };
            let text = format!(
                "{}: {} without a number ({}), bridged by {how}",
                signal.source.name,
                counted(rows.len(), "cell"),
                lines(&table.lines, &rows)
            );
            notes.push(over(&table.t, first, last, text));
            bridge(&mut signal.values, signal.source.role.is_held());
        }
    }
    let needed: Vec<&Signal> = table.signals.iter().filter(|signal| is_needed(signal)).collect();
    let without =
        |row: &usize| table.t[*row].is_nan() || needed.iter().any(|signal| signal.values[*row].is_nan());
    let rows: Vec<usize> = (0..table.t.len()).filter(without).collect();
    let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { return Ok(()) };
    let mut columns: Vec<&str> = needed
        .iter()
        .filter(|signal| signal.values.iter().any(|value| value.is_nan()))
        .map(|signal| signal.source.name.as_str())
        .collect();
    columns.extend(table.t.iter().any(|t| t.is_nan()).then_some(table.time.name.as_str()));
    let text = format!(
        "{} without a number in {}: left out as a gap ({})",
        counted(rows.len(), "row"),
        columns.join(", "),
        lines(&table.lines, &rows)
    );
    notes.push(over(&table.t, first, last, text));
    table.remove(&rows);
    Ok(())
}

/// Carries a command that was logged less often than the motion, or in rows of its own, from each row that has it to the next: `held`,
/// or along a straight line.
fn carry_slower_commands(table: &mut Table, held: bool, notes: &mut Vec<Note>) {
    let outputs: Vec<&Signal> = table.signals.iter().filter(|signal| is_output(signal)).collect();
    let measured: Vec<bool> =
        (0..table.t.len()).map(|row| outputs.iter().any(|s| !s.values[row].is_nan())).collect();
    let count = |rows: std::ops::Range<usize>| measured[rows].iter().filter(|measured| **measured).count();
    let t = &table.t;
    for signal in table.signals.iter_mut().filter(|signal| signal.source.role.is_input()) {
        let known: Vec<usize> =
            (0..t.len()).filter(|&row| !signal.values[row].is_nan() && t[row].is_finite()).collect();
        let pairs: Vec<(f64, usize)> =
            known.windows(2).map(|pair| (t[pair[1]] - t[pair[0]], count(pair[0] + 1..pair[1] + 1))).collect();
        let Some(usual) = median(pairs.iter().map(|pair| pair.0)) else { continue };
        let between = median(pairs.iter().map(|pair| pair.1 as f64)).unwrap_or(0.0);
        let with_motion = known.iter().filter(|&&row| measured[row]).count();
        if between < SLOWER && 2 * with_motion >= known.len() {
            continue;
        }
        for (i, &from) in known.iter().enumerate() {
            let next = known.get(i + 1).copied();
            let (to, value) = (next.unwrap_or(t.len()), signal.values[from]);
            let slope =
                next.filter(|_| !held).map_or(0.0, |to| (signal.values[to] - value) / (t[to] - t[from]));
            for row in from + 1..to {
                if t[row] - t[from] <= LONGEST_HOLD * usual {
                    signal.values[row] = value + slope * (t[row] - t[from]);
                }
            }
        }
        let how = if held { "it is held from each" } else { "it goes along a straight line from each" };
        let text = format!(
            "{} has a number in {} of the {} with a measurement: logged less often, {how} to the next",
            signal.source.name,
            with_motion,
            counted(count(0..t.len()), "row")
        );
        notes.push(Note::new(NoteKind::Missing, text));
    }
}

/// Joins the readings of a rate or an angle that was logged less often than the other, where they follow on each other quickly.
fn join_slower_output(table: &mut Table, notes: &mut Vec<Note>) {
    let t = &table.t;
    let found = |signal: &Signal| t.len() - missing(&signal.values).len();
    let most = table.signals.iter().filter(|signal| is_output(signal)).map(found).max().unwrap_or(0);
    for signal in table.signals.iter_mut().filter(|signal| is_output(signal)) {
        let known: Vec<usize> =
            (0..t.len()).filter(|&row| !signal.values[row].is_nan() && t[row].is_finite()).collect();
        let usual = median(known.windows(2).map(|pair| t[pair[1]] - t[pair[0]]));
        let Some(usual) = usual.filter(|usual| *usual <= SLOWEST_JOINED_S && 2 * known.len() < most) else {
            continue;
        };
        for pair in known.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let (begins, lasts) = (t[from], t[to] - t[from]);
            let (before, after) = (signal.values[from], signal.values[to]);
            for row in (from + 1..to).filter(|_| lasts > 0.0 && lasts <= LONGEST_JOINED * usual) {
                signal.values[row] = before + (after - before) * (t[row] - begins) / lasts;
            }
        }
        let text = format!(
            "{} has a number in {} of {}: logged less often, its readings are joined by straight lines",
            signal.source.name,
            known.len(),
            counted(t.len(), "row")
        );
        notes.push(Note::new(NoteKind::Missing, text));
    }
}

/// Whether no row can do without it.
fn is_needed(signal: &Signal) -> bool {
    signal.source.role.is_input() || is_output(signal)
}

fn is_output(signal: &Signal) -> bool {
    matches!(signal.source.role, Role::Q | Role::Theta)
}

/// Leaves out columns that hold no number, and the output that is missing in most rows while the other is there.
fn drop_sparse(table: &mut Table, notes: &mut Vec<Note>) -> Result<(), Error> {
    let rows = table.t.len();
    let found = |signal: &Signal| rows - missing(&signal.values).len();
    let most = table.signals.iter().filter(|signal| is_output(signal)).map(found).max().unwrap_or(0);
    let empty = |name: &str| {
        let advice = "check the logger and the column; map another one with --column";
        Err(Error::new(ErrorKind::Value, "no cell of this column holds a number", advice).in_column(name))
    };
    if rows > 0 && table.t.iter().all(|t| t.is_nan()) {
        return empty(&table.time.name);
    }
    let mut kept = Vec::new();
    for signal in std::mem::take(&mut table.signals) {
        let count = found(&signal);
        let none = rows > 0 && count == 0;
        if none && (signal.source.role.is_input() || is_output(&signal) && most == 0) {
            return empty(&signal.source.name);
        }
        if none {
            let text = format!("{} holds no number and is not used", signal.source.name);
            notes.push(Note::new(NoteKind::Missing, text));
        } else if is_output(&signal) && 2 * count < most {
            let text =
                format!("{} has a number in {count} of {rows} rows only and is not used", signal.source.name);
            notes.push(Note::new(NoteKind::Missing, text));
        } else {
            kept.push(signal);
        }
    }
    table.signals = kept;
    Ok(())
}

fn missing(values: &[f64]) -> Vec<usize> {
    (0..values.len()).filter(|&row| values[row].is_nan()).collect()
}

/// The lines of these rows, for a message.
pub(super) fn lines(lines: &[u32], rows: &[usize]) -> String {
    let mut stretches: Vec<[usize; 2]> = Vec::new();
    for &row in rows {
        match stretches.last_mut() {
            Some([_, last]) if *last + 1 == row => *last = row,
            _ => stretches.push([row, row]),
        }
    }
    // columns in memory have no lines
    let word = if lines.is_empty() { "row" } else { "line" };
    let line = |row: usize| lines.get(row).map_or(row + 1, |&line| line as usize);
    let told = stretches.iter().take(LINES_TOLD).map(|&[first, last]| match last - first {
        0 => format!("{}", line(first)),
        _ => format!("{} to {}", line(first), line(last)),
    });
    let mut told: Vec<String> = told.collect();
    if stretches.len() > LINES_TOLD {
        told.push("...".to_owned());
    }
    format!("{word} {}", told.join(", "))
}

/// A note over the rows, as far as their times are known.
pub(super) fn over(t: &[f64], first: usize, last: usize, text: String) -> Note {
    let known = |row: &usize| !t[*row].is_nan();
    let before = (0..=first).rev().find(known).or_else(|| (first..t.len()).find(known));
    let after = (last..t.len()).find(known).or_else(|| (0..=last).rev().find(known));
    match before.zip(after) {
        Some((from, to)) => Note::over(NoteKind::Missing, t[from], t[to], text),
        None => Note::new(NoteKind::Missing, text),
    }
}

/// Fills what is missing from the neighbours that are there, by number of the row.
pub(super) fn bridge(values: &mut [f64], held: bool) {
    let known: Vec<usize> = (0..values.len()).filter(|&row| !values[row].is_nan()).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else { return };
    let (head, tail) = (values[first], values[last]);
    values[..first].fill(head);
    values[last..].fill(tail);
    for pair in known.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (before, after) = (values[from], values[to]);
        for (steps, value) in values[from + 1..to].iter_mut().enumerate() {
            let part = (steps + 1) as f64 / (to - from) as f64;
            *value = if held { before } else { before + part * (after - before) };
        }
    }
}
