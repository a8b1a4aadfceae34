//! An angle that was written within one turn, as a heading from −π to π or from 0 to 360 degrees, made continuous.
//!
//! ```text
//! n_k = n_{k−1} − round((x_k − x_{k−1})/2π),    θ_k = x_k + 2π n_k
//! ```
//!
//! where all x lie within one turn and span it, and some go by a whole one from row to row, but for a quarter. A swing that is seen on
//! one side before a gap and on the other after it does not.

use super::checks::extremes;
use super::clock::counted;
use super::columns::Role;
use super::missing::lines;
use super::table::Table;
use super::{Note, NoteKind};
use std::f64::consts::{PI, TAU};

/// What rounding adds to a turn.
const ROUNDING: f64 = 1e-3;
/// Share of a turn that a heading which goes round spans.
const SPANNED: f64 = 0.9;

/// Adds the turns that the angles of `table` were written without, and to the angle that was asked for those that bring it next to the
/// pitch angle; whether that was written so, and is in radians.
pub(super) fn add(table: &mut Table, notes: &mut Vec<Note>) -> bool {
    let mut of_pitch = None;
    for signal in table.signals.iter_mut().filter(|s| matches!(s.source.role, Role::Theta | Role::Phi)) {
        let jumps = continued(&mut signal.values);
        if jumps.is_empty() {
            continue;
        }
        if signal.source.role == Role::Theta {
            of_pitch = Some(signal.values.clone());
        }
        let text = format!(
            "{} jumps by a full turn {} ({}): it was written within one turn, and is made continuous",
            signal.source.name,
            counted(jumps.len(), "time"),
            lines(&table.lines, &jumps)
        );
        notes.push(Note::new(NoteKind::Converted, text));
    }
    let Some(theta) = of_pitch else { return false };
    for asked in table.signals.iter_mut().filter(|s| s.source.role == Role::ThetaRef) {
        for (asked, theta) in asked.values.iter_mut().zip(&theta) {
            *asked += TAU * ((theta - *asked) / TAU).round();
        }
    }
    true
}

/// Makes `angle` continuous; the rows that jumped.
fn continued(angle: &mut [f64]) -> Vec<usize> {
    let (low, high) = extremes(angle);
    let step = |k: usize| (angle[k] - angle[k - 1]).abs();
    let jumps: Vec<usize> = (1..angle.len()).filter(|&k| step(k) > PI).collect();
    let one_turn = TAU * SPANNED..TAU * (1.0 + ROUNDING);
    if !one_turn.contains(&(high - low)) || jumps.iter().any(|&k| step(k) < 1.5 * PI) {
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
        let mut swing = vec![1.6, 1.68, -1.65, -1.6];
        assert!(continued(&mut swing).is_empty(), "a gap within a swing: {swing:?}");
        let mut about = vec![-2.9, 0.0, 2.9, -0.8, 0.1];
        assert!(continued(&mut about).is_empty(), "half a turn and more is none: {about:?}");
    }
}
