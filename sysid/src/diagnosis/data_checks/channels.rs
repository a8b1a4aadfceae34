//! Clock, saturation and dead channels: what reading the recordings brought to light, and what it did not.

use super::{DataCheck, Gravity, joined};
use crate::dataset::Dataset;
use crate::estimate::digits;
use crate::recording::plateaus::plateaus;
use crate::recording::{InputUnit, NoteKind, Recording};
use std::ops::Range;

/// The whole command, per cent, and what is surely more.
const ALL: f64 = 100.0;
const ALL_AND_SOME: f64 = 105.0;
/// Share of the samples beyond it that are no wild values.
const SEVERAL: f64 = 0.01;
/// Runs of one value at an extreme of the input, each at least this long, that count as clipping.
const PLATEAU: usize = 3;
/// Share of samples in which an input changes, from which it is no sequence of steps (which has plateaus anyway).
const CHANGING: f64 = 0.5;
/// Most values that an input takes which was made of levels: its extremes are meant.
const LEVELS: usize = 5;
/// Shortest time over which an output that stays at one value counts as frozen, s.
const FROZEN_S: f64 = 1.0;
/// How much longer than any other run of one value a frozen one is.
const FAR_LONGER: usize = 10;
/// Share of its spread that another signal keeps where the motion goes on.
const GOES_ON: f64 = 0.5;

fn notes_of(recording: &Recording, kinds: &[NoteKind]) -> Option<String> {
    let notes = recording.notes.iter().filter(|note| kinds.contains(&note.kind));
    let texts: Vec<&str> = notes.map(|note| note.text.as_str()).collect();
    (!texts.is_empty()).then(|| texts.join("; "))
}

/// Irregular stamps, gaps, missing and double samples.
pub fn clock(recordings: &[Recording]) -> DataCheck {
    const CAUSE: &str = "clock";
    let kinds = [NoteKind::Resampled, NoteKind::Filled, NoteKind::Gap, NoteKind::Duplicate];
    if let Some(words) = joined(recordings, |recording| notes_of(recording, &kinds)) {
        return DataCheck::found(CAUSE, Gravity::Told, words);
    }
    let regular = |recording: &Recording| {
        let jitter = notes_of(recording, &[NoteKind::Snapped]);
        Some(format!(
            "{} samples, one every {} s, none missing or double{}",
            recording.len(),
            digits(recording.step),
            jitter.map_or(String::new(), |text| format!("; {text}"))
        ))
    };
    DataCheck::ruled_out(CAUSE, joined(recordings, regular).unwrap_or_default())
}

/// Signals that stay at their extreme values as recorded, and commands of more than there is.
pub fn saturation(recordings: &[Recording]) -> DataCheck {
    const CAUSE: &str = "saturation";
    let clipped = |recording: &Recording| {
        let parts = [notes_of(recording, &[NoteKind::Clipped]), clipped_input(recording)];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    };
    let (beyond, clipped) = (joined(recordings, more_than_all), joined(recordings, clipped));
    let gravity = if beyond.is_some() { Gravity::Stops } else { Gravity::Told };
    let words: Vec<String> = beyond.into_iter().chain(clipped).collect();
    if !words.is_empty() {
        return DataCheck::found(CAUSE, gravity, words.join("; "));
    }
    let extremes = |recording: &Recording| {
        let described: Vec<String> = outputs(recording)
            .map(|(name, values)| {
                let (low, high) = range(values);
                format!("{name} reaches {} and {}", digits(low), digits(high))
            })
            .collect();
        Some(format!("{}, without a plateau there", described.join(", ")))
    };
    DataCheck::ruled_out(CAUSE, joined(recordings, extremes).unwrap_or_default())
}

/// A command in per cent that goes beyond a hundred: the log has it before the limit that the actuator has.
fn more_than_all(recording: &Recording) -> Option<String> {
    let beyond: Vec<f64> = recording.u.iter().map(|u| u.abs()).filter(|u| *u > ALL_AND_SOME).collect();
    if recording.u_unit != InputUnit::Percent || (beyond.len() as f64) < SEVERAL * recording.len() as f64 {
        return None;
    }
    let (column, largest) = (recording.u_unit.column(), beyond.iter().copied().fold(0.0, f64::max));
    Some(format!(
        "{column} reaches {} %, and there is no more than 100 to give: the log has the command before it is limited; read it as the \
         actuator gets it with {}, or from 0 where it has one side; where it is no share of the whole command, name its unit or divide it by \
         the whole, u_norm",
        digits(largest),
        recording.option_to_limit(column, [-ALL, ALL]).unwrap_or_default()
    ))
}

/// Sections in which an input that changes from sample to sample sits at its extreme value again and again, and at least twice as long
/// as at any other that it runs into and out of: steps that were commanded within a loop have levels of their own. None and
/// the level that it begins at are those of a loop that is open.
fn clipped_input(recording: &Recording) -> Option<String> {
    let described = recording.sections.iter().flat_map(|section| {
        let u = &recording.u[section.rows.clone()];
        let changes = u.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let (low, high) = range(u);
        let steps = low == high || (changes as f64) < CHANGING * u.len() as f64 || takes_few_values(u);
        let clips = |level: f64| {
            let runs = if steps { Vec::new() } else { plateaus(u, level, PLATEAU) };
            let samples: usize = runs.iter().map(Range::len).sum();
            let longest = runs.iter().map(Range::len).max().unwrap_or(0);
            let inner = u.chunk_by(|a, b| a == b).filter(|run| {
                run.len() >= PLATEAU && 2 * run.len() >= longest && ![low, high, 0.0, u[0]].contains(&run[0])
            });
            let mut stepped = inner.map(|run| plateaus(u, run[0], run.len()));
            (runs.len() >= 2 && stepped.all(|plateaus| plateaus.is_empty())).then(|| {
                format!(
                    "{} stays at {} for {samples} samples in {} runs of section {}: the command was limited there",
                    recording.u_unit.column(),
                    digits(level),
                    runs.len(),
                    section.label
                )
            })
        };
        [low, high].map(clips).into_iter().flatten()
    });
    let described: Vec<String> = described.collect();
    (!described.is_empty()).then(|| described.join("; "))
}

/// Whether the signal takes no more than [`LEVELS`] values.
fn takes_few_values(signal: &[f64]) -> bool {
    let mut values: Vec<f64> = Vec::new();
    signal.iter().all(|value| {
        if !values.contains(value) {
            values.push(*value);
        }
        values.len() <= LEVELS
    })
}

/// Outputs that were smoothed both ways in time.
pub fn smoothing(data: &Dataset) -> DataCheck {
    const CAUSE: &str = "smoothing";
    let Some(found) = data.smoothing else {
        return DataCheck::ruled_out(
            CAUSE,
            "no output follows from its rows before as one does that was smoothed both ways in time",
        );
    };
    const HOW: &str =
        "smoothed both ways in time after it was measured (a spline, a filter run forwards and backwards";
    let left_out = found.left_out.map(|output| format!("{output} was {HOW}), and is left out"));
    if !found.in_use {
        return DataCheck::found(CAUSE, Gravity::Told, left_out.unwrap_or_default());
    }
    let step = data.runs.first().map_or(0.0, |run| run.step);
    let words = format!(
        "the motion was {HOW}; a simulation without noise is like that too), and moves before its cause: {} samples were averaged \
         into one of {} s, no lag, slew or mode is asked for that it would hide, and gain and damping are those of the smoothed motion; \
         better give the log as it was measured",
        data.thinned,
        digits(step)
    );
    if found.left_out.is_some() {
        return DataCheck::found(
            CAUSE,
            Gravity::Headline,
            format!("{words}; so was the angle, which is left out"),
        );
    }
    DataCheck::found(CAUSE, Gravity::Headline, words)
}

/// Signals that do not move.
pub fn dead(recordings: &[Recording]) -> DataCheck {
    const CAUSE: &str = "dead_channel";
    let input = |recording: &Recording| notes_of(recording, &[NoteKind::DeadInput]);
    let output = |recording: &Recording| {
        let advice = "delete or rename that column and run again";
        Some(format!("{}; {advice}", notes_of(recording, &[NoteKind::DeadOutput])?))
    };
    if let Some(words) = joined(recordings, output) {
        return DataCheck::found(CAUSE, Gravity::Stops, words);
    }
    if let Some(words) = joined(recordings, |recording| Frozen::longest(recording).map(|f| f.told(recording)))
    {
        return DataCheck::found(CAUSE, Gravity::Stops, words);
    }
    let partly = |recording: &Recording| {
        let described: Vec<String> = still_sections(recording).collect();
        (!described.is_empty()).then(|| described.join("; "))
    };
    if let Some(words) = joined(recordings, input).or_else(|| joined(recordings, partly)) {
        return DataCheck::found(CAUSE, Gravity::Headline, words);
    }
    let moving: Vec<&str> = recordings.first().into_iter().flat_map(outputs).map(|(name, _)| name).collect();
    DataCheck::ruled_out(CAUSE, format!("the input and {} move in every section", moving.join(" and ")))
}

/// An output that stays at one value while the motion goes on: it is held there, not measured.
struct Frozen {
    name: &'static str,
    value: f64,
    rows: Range<usize>,
    /// What goes on beside it.
    beside: &'static str,
}

impl Frozen {
    fn longest(recording: &Recording) -> Option<Self> {
        let stretches = outputs(recording).flat_map(|(name, values)| {
            let frozen = far_longer_runs(values, (FROZEN_S / recording.step).ceil() as usize);
            frozen.into_iter().filter_map(move |rows| {
                let mut others = outputs(recording).filter(|(other, _)| *other != name).peekable();
                let input = ("the input", recording.u.as_slice());
                let alone = others.peek().is_none() && rows.end == values.len();
                let mut witnesses = others.chain(alone.then_some(input));
                let (beside, _) =
                    witnesses.find(|(_, other)| spread(&other[rows.clone()]) > GOES_ON * spread(other))?;
                Some(Self { name, value: values[rows.start], rows, beside })
            })
        });
        stretches.max_by_key(|frozen| frozen.rows.len())
    }

    fn told(&self, recording: &Recording) -> String {
        let Self { name, value, rows, beside } = self;
        let time = |row: usize| recording.t[row.min(recording.len() - 1)];
        let (before, after) = (0..rows.start, rows.end..recording.len());
        let rest = if before.len() >= after.len() { before } else { after };
        format!(
            "{name} stays at {} from {:.2} to {:.2} s while {beside} goes on: nothing was measured there; leave that out with \
             --section \"A={:.2}..{:.2}\", or the column by renaming it",
            digits(*value),
            time(rows.start),
            time(rows.end),
            time(rest.start),
            time(rest.end)
        )
    }
}

/// Runs of one value at least `least` rows long and far longer than all others, but for those at an extreme of the signal,
/// where a stop or a range may hold it.
fn far_longer_runs(values: &[f64], least: usize) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut runs: Vec<Range<usize>> = values
        .chunk_by(|a, b| a == b)
        .map(|run| {
            start += run.len();
            start - run.len()..start
        })
        .collect();
    runs.sort_by_key(|run| std::cmp::Reverse(run.len()));
    let falls = |pair: &[Range<usize>]| pair[0].len() >= least && pair[0].len() >= FAR_LONGER * pair[1].len();
    let Some(last) = runs.windows(2).rposition(falls) else { return Vec::new() };
    runs.truncate(last + 1);
    let (low, high) = range(values);
    runs.retain(|run| low < values[run.start] && values[run.start] < high);
    runs
}

fn spread(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt()
}

/// Outputs that are constant in a whole section.
fn still_sections(recording: &Recording) -> impl Iterator<Item = String> {
    recording.sections.iter().flat_map(move |section| {
        outputs(recording).filter_map(move |(name, values)| {
            let (low, high) = range(&values[section.rows.clone()]);
            (low == high && section.rows.len() > 1)
                .then(|| format!("{name} is constant ({}) in section {}", digits(low), section.label))
        })
    })
}

fn outputs(recording: &Recording) -> impl Iterator<Item = (&'static str, &[f64])> {
    let q = recording.q.as_deref().map(|values| ("q_rad_s", values));
    let theta = recording.theta.as_deref().map(|values| ("theta_rad", values));
    q.into_iter().chain(theta)
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
}
