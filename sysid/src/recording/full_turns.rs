//! An angle that was written within one turn, as a heading from −π to π or from 0 to 360 degrees, made continuous.
//!
//! ```text
//! n_k = n_{k−1} − round((x_k − x_{k−1})/2π),    θ_k = x_k + 2π n_k
//! ```
//!
//! where all x lie within one turn and some go by more than half of one from row to row.

use super::clock::counted;
use super::columns::Role;
use super::missing::lines;
use super::table::Table;
use super::{Note, NoteKind};
use std::f64::consts::{PI, TAU};

/// What rounding adds to a turn.
const ROUNDING: f64 = 1e-3;

/// Adds the turns that the angles of `table` were written without; whether the pitch angle was, and so is in radians.
pub(super) fn add(table: &mut Table, notes: &mut Vec<Note>) -> bool {
    let mut of_pitch = false;
    for signal in table.signals.iter_mut().filter(|s| matches!(s.source.role, Role::Theta | Role::Phi)) {
        let jumps = continued(&mut signal.values);
        if jumps.is_empty() {
            continue;
        }
        of_pitch |= signal.source.role == Role::Theta;
        let text = format!(
            "{} jumps by a full turn {} ({}): it was written within one turn, and is made continuous",
            signal.source.name,
            counted(jumps.len(), "time"),
            lines(&table.lines, &jumps)
        );
        notes.push(Note::new(NoteKind::Converted, text));
    }
    of_pitch
}

/// Makes `angle` continuous; the rows that jumped.
fn continued(angle: &mut [f64]) -> Vec<usize> {
    let (low, high) =
        angle.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    let jumps: Vec<usize> = (1..angle.len()).filter(|&k| (angle[k] - angle[k - 1]).abs() > PI).collect();
    if high - low > TAU * (1.0 + ROUNDING) || jumps.is_empty() {
        return Vec::new();
    }
    let (mut before, mut turns) = (angle[0], 0.0);
    for x in angle.iter_mut() {
        turns -= ((*x - before) / TAU).round();
        before = *x;
        *x += TAU * turns;
    }
    jumps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_goes_on_over_the_turn_and_what_was_continuous_stays() {
        let heading: Vec<f64> = (0..200).map(|k| 9.0 * (0.05 * f64::from(k)).sin()).collect();
        let within =
            |from: f64| heading.iter().map(|x| (x - from).rem_euclid(TAU) + from).collect::<Vec<_>>();
        for from in [-PI, 0.0] {
            let mut written = within(from);
            assert!(!continued(&mut written).is_empty());
            let turns = ((written[0] - heading[0]) / TAU).round() * TAU;
            assert!(written.iter().zip(&heading).all(|(a, b)| (a - turns - b).abs() < 1e-9));
        }
        let mut whole = heading.clone();
        assert!(continued(&mut whole).is_empty() && whole == heading);
        let mut leap = vec![0.0, 0.1, 9.0, 0.2];
        assert!(continued(&mut leap).is_empty(), "further than a turn is no turn: {leap:?}");
    }
}
