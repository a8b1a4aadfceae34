//! Clock, saturation and dead channels: what reading the recordings brought to light, and what it did not.

use super::{DataCheck, Gravity, joined};
use crate::estimate::digits;
use crate::recording::{NoteKind, Recording};

/// Runs of one value at an extreme of the input, each at least this long, that count as clipping.
const PLATEAU: usize = 3;
/// Share of samples in which an input changes, from which it is no sequence of steps (which has plateaus anyway).
const CHANGING: f64 = 0.5;

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

/// Signals that stay at their extreme values as recorded.
pub fn saturation(recordings: &[Recording]) -> DataCheck {
    const CAUSE: &str = "saturation";
    let clipped = |recording: &Recording| {
        let parts = [notes_of(recording, &[NoteKind::Clipped]), clipped_input(recording)];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    };
    if let Some(words) = joined(recordings, clipped) {
        return DataCheck::found(CAUSE, Gravity::Told, words);
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

/// Sections in which an input that changes from sample to sample sits at its extreme value again and again.
fn clipped_input(recording: &Recording) -> Option<String> {
    let described = recording.sections.iter().flat_map(|section| {
        let u = &recording.u[section.rows.clone()];
        let changes = u.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let (low, high) = range(u);
        let steps = (changes as f64) < CHANGING * u.len() as f64;
        [low, high].into_iter().filter(move |_| !steps && low < high).filter_map(|level| {
            let plateaus: Vec<usize> = u
                .chunk_by(|a, b| a == b)
                .filter(|run| run[0] == level && run.len() >= PLATEAU)
                .map(<[f64]>::len)
                .collect();
            let (runs, samples) = (plateaus.len(), plateaus.iter().sum::<usize>());
            (runs >= 2).then(|| {
                format!(
                    "{} stays at {} for {samples} samples in {runs} runs of section {}: the command was limited there",
                    recording.u_unit.column(),
                    digits(level),
                    section.label
                )
            })
        })
    });
    let described: Vec<String> = described.collect();
    (!described.is_empty()).then(|| described.join("; "))
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
