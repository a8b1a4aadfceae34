//! What was flown: the ground holds a craft, so what it does there says nothing of its dynamics.
//!
//! A stretch lies on the ground where both say so: the thrust that was logged is below half of its usual value for a second or
//! longer, and the rate is stiller there, by its median size, than half of what it is elsewhere. A throttle that is closed in
//! flight fails the second, as does a rig that swings with its motors off.

use super::clock::Grid;
use super::columns::Role;
use super::options::SectionSpec;
use super::table::Table;
use super::{Note, NoteKind};
use std::ops::Range;

/// Share of the usual thrust below which a craft may stand on the ground.
const LOW: f64 = 0.5;
/// Share of the largest thrust below which the motors count as off: the usual thrust is that of all else.
const OFF: f64 = 0.1;
/// Share of the usual size of the rate below which the craft is still.
const STILL: f64 = 0.5;
/// Shortest stop on the ground, s.
const SHORTEST_STOP_S: f64 = 1.0;
/// Left out at both ends of a flight, s: the ground holds the craft.
const NEAR_GROUND_S: f64 = 1.0;
/// Shortest flight that is used, s.
const SHORTEST_FLIGHT_S: f64 = 3.0;

/// Leaves the stretches in flight in `grid`, where the thrust was logged and something else is left out by that, and those of the
/// `sections` that the user names that would have nothing left.
pub(super) fn keep(table: &Table, grid: &mut Grid, sections: &[SectionSpec], notes: &mut Vec<Note>) {
    let of = |role: Role| table.signals.iter().find(|signal| signal.source.role == role);
    let (Some(thrust), Some(rate)) = (of(Role::Thrust), of(Role::Q)) else { return };
    let Some(flown) = flown(&thrust.values, &rate.values, &grid.segments, grid.step) else { return };
    let touches = |section: &SectionSpec, rows: &Range<usize>| {
        table.t[rows.start] < section.to && section.from <= table.t[rows.end - 1]
    };
    let grounded = sections.iter().filter(|section| !flown.iter().any(|rows| touches(section, rows)));
    let named = grounded.flat_map(|section| {
        grid.segments.iter().filter(|rows| touches(section, rows)).map(|rows| {
            let at = |time: f64| rows.start + table.t[rows.clone()].partition_point(|t| *t < time);
            at(section.from)..at(section.to)
        })
    });
    let named: Vec<Range<usize>> = named.collect();
    let mut flown = [flown.clone(), named].concat();
    flown.sort_by_key(|rows| rows.start);
    let seconds =
        |all: &[Range<usize>]| all.iter().map(ExactSizeIterator::len).sum::<usize>() as f64 * grid.step;
    let text = format!(
        "{:.1} of {:.1} s are used: the rest is on the ground or near it, by {} and {}; what --section names is used there too",
        seconds(&flown),
        seconds(&grid.segments),
        thrust.source.name,
        rate.source.name
    );
    let used = |[from, to]: [f64; 2]| {
        flown.iter().any(|rows| table.t[rows.start] <= to && from <= table.t[rows.end - 1])
    };
    notes.retain(|note| note.time_s.is_none_or(used));
    notes.push(Note::new(NoteKind::Ground, text));
    grid.segments = flown;
}

/// The stretches in flight; `None` where all is, or none.
fn flown(thrust: &[f64], rate: &[f64], segments: &[Range<usize>], step: f64) -> Option<Vec<Range<usize>>> {
    let largest = thrust.iter().fold(0.0_f64, |most, &t| most.max(t));
    let level = LOW * median(thrust.iter().copied().filter(|&t| t > OFF * largest))?;
    let size = |rows: Range<usize>| median(rate[rows].iter().map(|q| q.abs()));
    let running = (0..thrust.len()).filter(|&k| thrust[k] >= level).map(|k| rate[k].abs());
    let still = STILL * median(running)?;
    let rows_of = |seconds: f64| (seconds / step).ceil() as usize;
    let [stop, margin, shortest] = [SHORTEST_STOP_S, NEAR_GROUND_S, SHORTEST_FLIGHT_S].map(rows_of);
    let (mut grounded, mut stretches) = (false, Vec::new());
    for segment in segments {
        let mut from = segment.start;
        let mut fly = |rows: Range<usize>| {
            // the end of a recording that has ground in it may be another take-off or landing
            let rows = rows.start + margin..rows.end.saturating_sub(margin);
            if rows.end > rows.start && rows.len() >= shortest {
                stretches.push(rows);
            }
        };
        let mut at = segment.start;
        for run in thrust[segment.clone()].chunk_by(|a, b| (*a >= level) == (*b >= level)) {
            let rows = at..at + run.len();
            at = rows.end;
            if run[0] < level && run.len() >= stop && size(rows.clone()).is_some_and(|q| q < still) {
                grounded = true;
                fly(from..rows.start);
                from = rows.end;
            }
        }
        fly(from..segment.end);
    }
    (grounded && !stretches.is_empty()).then_some(stretches)
}

/// The middle one of the values; the upper of two.
pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(rows: usize) -> [Range<usize>; 1] {
        [Range { start: 0, end: rows }]
    }

    #[test]
    fn what_the_user_names_is_used_on_the_ground_too() {
        use crate::recording::{ReadOptions, parse};
        let mut text = "t_s,u_norm,q_rad_s,thrust_norm\n".to_owned();
        let rate = moving(100..600);
        for (k, rate) in rate.iter().enumerate() {
            let thrust = if (100..600).contains(&k) { 0.6 } else { 0.0 };
            text += &format!("{:.2},{},{rate},{thrust}\n", 0.01 * k as f64, (0.3 * k as f64).cos());
        }
        let used = |sections: &[&str], on_ground: bool| {
            let sections = sections.iter().map(|section| section.parse().unwrap()).collect();
            let options = ReadOptions { sections, on_ground, ..ReadOptions::default() };
            let segments = parse("a.csv", text.as_bytes(), &options).unwrap().segments;
            segments.into_iter().map(|rows| [rows.start, rows.end]).collect::<Vec<_>>()
        };
        assert_eq!(used(&[], false), [[200, 500]]);
        assert_eq!(used(&["I=3..7"], false), [[200, 500]], "part of it flies");
        assert_eq!(used(&["I=3..4", "II=6..9"], false), [[200, 500], [600, 900]], "nothing else is meant");
        assert_eq!(used(&[], true), [[0, 1000]]);
    }

    fn moving(rows: Range<usize>) -> Vec<f64> {
        (0..1000).map(|k| if rows.contains(&k) { f64::from(k as u32).sin() } else { 0.001 }).collect()
    }

    #[test]
    fn only_what_was_flown_is_used() {
        let mut thrust = vec![0.0; 1000];
        thrust[200..500].fill(0.6);
        thrust[700..800].fill(0.6);
        let rate = moving(200..500);
        assert_eq!(flown(&thrust, &rate, &all(1000), 0.01), None, "1 s away from the ground is too short");
        thrust[100..600].fill(0.6);
        let rate = moving(100..600);
        assert_eq!(
            flown(&thrust, &rate, &all(1000), 0.01).as_deref(),
            Some(&[Range { start: 200, end: 500 }][..])
        );
    }

    #[test]
    fn what_moves_with_little_thrust_and_what_has_no_thrust_is_used() {
        let mut thrust = vec![0.6; 1000];
        thrust[300..600].fill(0.1);
        assert_eq!(flown(&thrust, &moving(0..1000), &all(1000), 0.01), None);
        thrust[300..600].fill(0.6);
        thrust[300..380].fill(0.0);
        assert_eq!(flown(&thrust, &moving(0..0), &all(1000), 0.01), None, "a blip is no stop");
        assert_eq!(flown(&[0.0; 1000], &moving(0..1000), &all(1000), 0.01), None);
    }
}
