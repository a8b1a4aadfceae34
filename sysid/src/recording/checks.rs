//! What looks wrong in the data: clipping, units, signs and constant signals. Nothing is changed here.

use super::clock::{Grid, counted};
use super::columns::{InputUnit, Role};
use super::expression::Expression;
use super::plateaus::plateaus;
use super::rate_and_angle::rate_and_angle;
use super::table::{Signal, Table};
use super::{Note, NoteKind, missing};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Beyond half a turn and a little, a pitch angle in radians is not one (rad).
const LARGEST_ANGLE: f64 = 3.2;
/// 1150 °/s: beyond what the gyros of such rigs measure (rad/s).
const LARGEST_RATE: f64 = 20.0;
/// A blade pitch of 90° (rad).
const LARGEST_BLADE_PITCH: f64 = 1.6;
/// Time over which ∫q dt is compared with Δθ (s): long against noise, short against drift.
const COMPARED_OVER: f64 = 0.2;
/// Correlation of ∫q dt with Δθ from which unit and sign are judged.
const CORRELATED: f64 = 0.7;
/// A normalised command beyond this is in another unit.
const BEYOND_FULL: f64 = 2.0;
/// A servo's pulses, µs.
const PULSES_US: Range<f64> = 700.0..2300.0;
/// Degrees per radian.
const DEGREES: f64 = 180.0 / PI;
/// How far beyond all others a few commands are no commands, but what a logger writes for nothing, or a lost decimal point.
const FAR_BEYOND: f64 = 30.0;
/// Share of the rows that are a few.
const FEW: f64 = 0.01;

/// Adds the notes on the signals of a table that is on its grid; the angle is known to be in radians where it was written `in_turns`.
pub(super) fn inspect(table: &Table, grid: &Grid, in_turns: bool, notes: &mut Vec<Note>) {
    let of = |role: Role| table.signals.iter().find(|s| s.source.role == role);
    let (q, theta) = (of(Role::Q), of(Role::Theta));
    if let Some(input) = table.signals.iter().find(|s| s.source.role.is_input()) {
        check_input(input, grid, notes);
        check_far_beyond(table, input, notes);
    }
    for output in [q, theta].into_iter().flatten() {
        if is_constant(&output.values) {
            let text = format!(
                "{} is constant ({}): the channel is dead or not connected",
                column(output),
                output.values[0]
            );
            notes.push(Note::new(NoteKind::DeadOutput, text));
            continue;
        }
        check_clipping(table, output, notes);
    }
    let told = match (q, theta) {
        (Some(q), Some(theta)) => compare_rate_with_angle(q, theta, grid, notes),
        _ => false,
    };
    if !told {
        check_size(q, grid, LARGEST_RATE, "rad/s", notes);
        check_size(theta.filter(|_| !in_turns), grid, LARGEST_ANGLE, "rad", notes);
    }
}

fn column(signal: &Signal) -> &str {
    &signal.source.name
}

fn is_constant(values: &[f64]) -> bool {
    values.iter().all(|v| Some(v) == values.first())
}

/// The least and the largest value.
pub(super) fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
}

fn check_input(input: &Signal, grid: &Grid, notes: &mut Vec<Note>) {
    if is_constant(&input.values) {
        let value = input.values[0];
        let text = if input.source.expression.names().is_empty() {
            format!("nothing is commanded ({value} throughout): only motion that was under way informs")
        } else {
            format!(
                "the input {} never changes ({value}): what it was before the first row is unknown, and only motion that was under way then \
                 informs",
                column(input)
            )
        };
        notes.push(Note::new(NoteKind::DeadInput, text));
    } else if input.source.role == Role::Input(InputUnit::Rad) {
        check_size(Some(input), grid, LARGEST_BLADE_PITCH, "rad", notes);
    } else if input.source.role == Role::Input(InputUnit::Normalised) {
        check_full_command(input, grid, notes);
    }
}

/// A command of which 1 is all there is, and that is far more.
fn check_full_command(input: &Signal, grid: &Grid, notes: &mut Vec<Note>) {
    let used = || grid.segments.iter().flat_map(|rows| &input.values[rows.clone()]).copied();
    let (low, high) =
        used().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)));
    let most = high.max(-low);
    if most <= BEYOND_FULL {
        return;
    }
    let remedy = if low >= PULSES_US.start && high <= PULSES_US.end {
        format!(
            "these look like a servo's pulses in µs: --column 'u_norm=({}-1500)/500'",
            Expression::column(column(input))
        )
    } else {
        "1 stands for a full command: divide it by what that is".to_owned()
    };
    let text = format!("{} reaches {most:.4} as u_norm, used as it is; {remedy}", column(input));
    notes.push(Note::new(NoteKind::Unit, text));
}

/// A few commands far beyond all others. They are not left out: a blow with a hammer looks the same.
fn check_far_beyond(table: &Table, input: &Signal, notes: &mut Vec<Note>) {
    let mut by_size: Vec<usize> = (0..input.values.len()).collect();
    let size = |row: &usize| input.values[*row].abs();
    let larger_first = |a: &usize, b: &usize| size(b).total_cmp(&size(a)).then(a.cmp(b));
    let few = (FEW * by_size.len() as f64) as usize;
    if few == 0 {
        return;
    }
    by_size.select_nth_unstable_by(few, larger_first);
    by_size.truncate(few + 1);
    by_size.sort_by(larger_first);
    let beyond = |count: &usize| size(&by_size[count - 1]) > FAR_BEYOND * size(&by_size[*count]);
    let Some(count) = (1..=few).rev().filter(|count| size(&by_size[*count]) > 0.0).find(beyond) else {
        return;
    };
    let mut rows = by_size[..count].to_vec();
    rows.sort_unstable();
    let (first, last) = (rows[0], rows[count - 1]);
    let text = format!(
        "{}: {} ({}) more than {FAR_BEYOND} times as large as any other, used as it is: where nothing was measured there, or a decimal \
         point was lost, empty the cells and run again",
        column(input),
        counted(count, "value"),
        missing::lines(&table.lines, &rows)
    );
    notes.push(Note::over(NoteKind::Wild, table.t[first], table.t[last], text));
}

/// Values too large for radians, but for a column that says degrees and was converted, and for what would be several turns in
/// degrees as well.
fn check_size(signal: Option<&Signal>, grid: &Grid, limit: f64, unit: &str, notes: &mut Vec<Note>) {
    let Some(signal) = signal.filter(|signal| signal.source.factor == 1.0) else { return };
    let used = grid.segments.iter().flat_map(|rows| &signal.values[rows.clone()]);
    let most = used.fold(0.0_f64, |most, v| v.abs().max(most));
    if most > limit && most <= DEGREES * limit {
        let turns = match signal.source.role {
            Role::Theta => format!(" ({:.1} turns)", most / TAU),
            _ => String::new(),
        };
        let text = format!(
            "{} reaches {most:.4} {unit}{turns}, which looks like degrees; used as it is. If so: {}",
            column(signal),
            signal.source.scaled_by(1.0 / DEGREES)
        );
        notes.push(Note::new(NoteKind::Unit, text));
    }
}

/// A signal clips where it is held at its extreme value in several runs, each longer than its ordinary runs. At exactly zero nothing
/// clips: a wheel stands still there.
fn check_clipping(table: &Table, signal: &Signal, notes: &mut Vec<Note>) {
    let values = &signal.values;
    let ordinary = values.len().div_ceil(values.chunk_by(|a, b| a == b).count().max(1));
    let (low, high) = extremes(values);
    for extreme in [low, high].into_iter().filter(|extreme| *extreme != 0.0) {
        let runs = plateaus(values, extreme, 3 * ordinary);
        let samples: usize = runs.iter().map(Range::len).sum();
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else { continue };
        if runs.len() >= 2 || samples >= 10 * ordinary {
            let text = format!(
                "{} stays at its extreme value {extreme} for {samples} samples in {}: it clips, the motion beyond is not in the data",
                column(signal),
                counted(runs.len(), "run")
            );
            let (from, to) = (table.t[first.start], table.t[last.end - 1]);
            notes.push(Note::over(NoteKind::Clipped, from, to, text));
        }
    }
}

/// Δθ against ∫q dt over windows of `COMPARED_OVER`: slope 1 is right, 57.3 or 1/57.3 a unit, negative a sign.
/// Returns whether anything was said of a unit.
fn compare_rate_with_angle(q: &Signal, theta: &Signal, grid: &Grid, notes: &mut Vec<Note>) -> bool {
    let compared = rate_and_angle(&q.values, &theta.values, &grid.segments, grid.step, COMPARED_OVER);
    let Some(compared) = compared else { return false };
    let (slope, correlation) = (compared.slope(), compared.correlation);
    if correlation.abs() < CORRELATED {
        return false;
    }
    if correlation < 0.0 {
        let text = format!(
            "sign: {} falls while {} is positive (correlation {correlation:.2}): one of the two looks reversed; used as it is. If it is the rate: {}; if the angle: {}",
            column(theta),
            column(q),
            q.source.scaled_by(-1.0),
            theta.source.scaled_by(-1.0)
        );
        notes.push(Note::new(NoteKind::Sign, text));
    }
    let near = |factor: f64| (slope / factor).ln().abs() < 0.3;
    let (wrong, right) = match (near(DEGREES), near(1.0 / DEGREES)) {
        (true, _) => (theta, q),
        (_, true) => (q, theta),
        _ => return false,
    };
    let text = format!(
        "unit: {} is {:.1} times what {} says, which is degrees where radians belong; used as it is. To convert: {}",
        column(wrong),
        slope.max(1.0 / slope),
        column(right),
        wrong.source.scaled_by(1.0 / DEGREES)
    );
    notes.push(Note::new(NoteKind::Unit, text));
    true
}
