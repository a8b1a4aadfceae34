//! Does the input answer to the motion in sections that claim to be open loop?
//!
//! Each is asked by what is [new](super::news) in its input, beside the fitted model and in the [rows](super::own_rows) as they were logged. Where nothing is new between its switches, there is an excitation
//! and nothing else; where something is, averages rule nothing out. Dwells that follow the motion as far as the input made
//! it, and no further, decide nothing.

use super::dwells::dwells;
use super::news::{Section, Test};
use super::{DataCheck, Gravity, own_rows};
use crate::dataset::{Place, Run};
use crate::estimate::digits;
use crate::likelihood::fit::Fit;
use crate::likelihood::free_run::{simulate, starting_points};
use crate::likelihood::problem::{Problem, Unpacked};
use crate::model::pitch::Output;
use crate::recording::{InputHold, NoteKind, Recording, WHOLE};
use core::ops::Range;

/// Odds of finding feedback by chance in one recording.
pub const ODDS: f64 = 1e-3;
/// Odds below which no section is called open loop either.
const DOUBTFUL: f64 = 0.01;
/// Least share of what is new in the input that the innovations must explain: below it, the bias is small.
const LEAST_SHARE: f64 = 0.005;
/// Share of overridden samples from which the summary says so.
const OVERRIDDEN: f64 = 0.5;
/// Name of the check.
pub const FEEDBACK: &str = "feedback";

/// What is known of each section's loop.
#[derive(Default)]
pub struct Loops {
    tests: Vec<(String, Test)>,
    /// Sections whose dwells were asked, and the odds that they follow the motion by chance.
    dwells: Vec<(String, f64)>,
    /// Sections that are closed on purpose.
    closed: Vec<String>,
    /// Sections that the supervisor entered, and the share of their samples that it decided.
    overridden: Vec<(String, f64)>,
    /// That share of all sections that claim to be open loop.
    share: f64,
    /// Logged samples that were averaged into a row.
    averaged: usize,
    /// Whether anything is new in the input of some section between its switches.
    new_between: bool,
    /// Whether rows were asked as they were logged.
    asked_as_logged: bool,
    /// Whether the outputs were smoothed both ways in time.
    smoothed: bool,
}

impl Loops {
    /// Tests the sections that claim to be open loop, the rows of the supervisor left out.
    pub fn new(recordings: &[Recording], problem: &Problem<'_>, fit: &Fit) -> Self {
        let averaged = problem.data.thinned;
        let mut loops = Self { averaged, smoothed: problem.data.is_smoothed(), ..Self::default() };
        let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
        let Some(innovations) = innovations(problem, &unpacked) else { return loops };
        let places = problem.data.places();
        let starts = starting_points(problem, &unpacked, &places);
        let rates: Vec<Vec<f64>> = problem.data.runs.iter().map(Run::rate_or_slope).collect();
        let angles: Vec<Vec<f64>> = problem.data.runs.iter().map(Run::angle_or_sum).collect();
        let (mut entered, mut rows) = (0usize, 0usize);
        for (i, place) in places.into_iter().enumerate() {
            if closed_by_design(recordings, problem, &place) {
                loops.closed.push(place.label);
                continue;
            }
            let run = &problem.data.runs[place.run];
            let supervised = &run.supervised[place.rows.clone()];
            let count = supervised.iter().filter(|s| **s).count();
            if count > 0 {
                loops.overridden.push((place.label.clone(), count as f64 / place.rows.len() as f64));
            }
            entered += count;
            rows += place.rows.len();
            if loops.smoothed {
                continue;
            }
            let u = &run.u[place.rows.clone()];
            let motion: Vec<Output> =
                place.rows.clone().map(|k| [rates[place.run][k], angles[place.run][k]]).collect();
            let one = std::slice::from_ref(&place);
            let start = starts.as_ref().map(|starts| &starts[i..=i]);
            let simulated = start.and_then(|start| simulate(problem, &unpacked, one, start)?.pop());
            let dwells = dwells(u, &motion, supervised, simulated.as_deref());
            loops.dwells.extend(dwells.iter().map(|dwells| (place.label.clone(), dwells.by_motion)));
            let e = &innovations[place.run][place.rows.clone()];
            let notes = recordings.get(run.recording).map_or(&[][..], |recording| &recording.notes);
            let interpolated = notes.iter().any(|note| note.kind == NoteKind::Resampled);
            let section = Section { u, e, supervised, step: run.step, averaged, interpolated, dwells };
            let as_logged = || {
                // what was measured between two rows is no command that was given in one
                let recording = recordings.get(run.recording)?;
                let is_command = recording.input_hold == InputHold::Held;
                let effect = unpacked.plant.dm_du;
                is_command.then(|| asked_as_logged(recording, run, &place, averaged, effect)).flatten()
            };
            let as_logged = if interpolated { None } else { as_logged() };
            loops.asked_as_logged |= as_logged.is_some();
            let (by_model, new_between) =
                section.test().map_or((None, false), |(test, new)| (Some(test), new));
            loops.new_between |= new_between;
            let test = clearer(by_model, as_logged);
            loops.tests.extend(test.map(|test| (place.label, test)));
        }
        loops.share = entered as f64 / rows.max(1) as f64;
        loops
    }

    /// Odds below which a section is not open loop.
    fn limit(&self) -> f64 {
        ODDS / self.tests.len().max(1) as f64
    }

    fn is_closed(&self, test: &Test) -> bool {
        test.p_value < self.limit() && test.share > LEAST_SHARE
    }

    /// Whether any section was found to be open loop.
    pub fn any_open(&self) -> bool {
        self.tests.iter().any(|(_, test)| !self.is_closed(test))
    }

    /// Whether a section that claims to be open loop was found not to be. Where the supervisor overrides the excitation it says
    /// so, row by row.
    pub fn any_closed_unsaid(&self) -> bool {
        self.tests.iter().any(|(_, test)| self.is_closed(test))
    }

    /// Whether some section is closed, by design or as found, and none was found to be open loop.
    pub fn all_closed(&self) -> bool {
        let asked = !self.closed.is_empty() || !self.tests.is_empty();
        asked && !self.smoothed && !self.any_open()
    }

    /// Whether some section is closed that does not say so, or all are.
    pub fn closed(&self) -> bool {
        self.any_closed_unsaid() || self.all_closed()
    }

    /// In words.
    pub fn check(&self) -> DataCheck {
        let mut found: Vec<_> = self.tests.iter().filter(|(_, test)| self.is_closed(test)).collect();
        // of a section that a gap cuts the clearest piece is told
        found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.p_value.total_cmp(&b.1.p_value)));
        found.dedup_by(|a, b| a.0 == b.0);
        let mut parts: Vec<String> = found
            .iter()
            .map(|(label, test)| {
                format!("{} is not open loop: {} (p = {:.0e})", called(label), test.told(), test.p_value)
            })
            .collect();
        let heavy = !parts.is_empty() || self.share > OVERRIDDEN;
        if !self.overridden.is_empty() {
            let described: Vec<String> = self
                .overridden
                .iter()
                .map(|(label, share)| format!("{:.1} % of {label}", 100.0 * share))
                .collect();
            parts.push(format!(
                "the supervisor overrode the excitation in {}: the input answers to the motion there",
                described.join(", ")
            ));
        }
        if !parts.is_empty() {
            let gravity = if heavy { Gravity::Headline } else { Gravity::Told };
            let words =
                format!("{} (free runs are biased by it, one-step predictions are not)", parts.join("; "));
            return DataCheck::found(FEEDBACK, gravity, words);
        }
        let by_design = match self.closed.as_slice() {
            [] => String::new(),
            labels => format!("; a closed loop by design: {}", labels.join(", ")),
        };
        let Some(least) = self.tests.iter().map(|(_, test)| test.p_value).min_by(f64::total_cmp) else {
            let reason = if self.smoothed {
                "the outputs were smoothed both ways in time, and know of later inputs by that"
            } else {
                "no section that could be tested"
            };
            return DataCheck::cannot_tell(FEEDBACK, format!("{reason}{by_design}"));
        };
        let mut undecided: Vec<String> =
            self.dwells.iter().filter(|(_, p)| *p < self.limit()).map(|(label, _)| called(label)).collect();
        undecided.dedup();
        if !undecided.is_empty() {
            let words = format!(
                "in {} the times between the switches follow the motion, or those before them: the motion is the input's \
                 own, and cannot tell the two apart{by_design}",
                undecided.join(", ")
            );
            return DataCheck::cannot_tell(FEEDBACK, words);
        }
        let mut labels: Vec<String> = self.tests.iter().map(|(label, _)| called(label)).collect();
        labels.dedup();
        if self.averaged > 1 && self.new_between && !self.asked_as_logged {
            let words = format!(
                "{} samples were averaged into one, and a controller that answers within them is not seen; over longer times the \
                 motion says nothing of later inputs (least p = {}){by_design}",
                self.averaged,
                digits(least)
            );
            return DataCheck::cannot_tell(FEEDBACK, words);
        }
        if least < DOUBTFUL / self.tests.len() as f64 {
            let words = format!(
                "in {} the motion may tell a little of later inputs (least p = {}), too little to be sure of it or to bias a fit\
                 {by_design}",
                labels.join(", "),
                digits(least)
            );
            return DataCheck::cannot_tell(FEEDBACK, words);
        }
        let words = format!(
            "in {} the motion says nothing of later inputs (least p = {}{}){by_design}",
            labels.join(", "),
            digits(least),
            match self.tests.len() {
                1 => String::new(),
                several => format!(" of {several}"),
            }
        );
        DataCheck::ruled_out(FEEDBACK, words)
    }
}

/// A section as it is called; a recording without sections is one.
fn called(label: &str) -> String {
    if label == WHOLE { "the recording".into() } else { format!("section {label}") }
}

/// The clearer of two tests of one section, its odds doubled: one that finds the loop closed, or the less probable.
fn clearer(a: Option<Test>, b: Option<Test>) -> Option<Test> {
    match (a, b) {
        (Some(a), Some(b)) => {
            let closed = |test: &Test| test.p_value < ODDS && test.share > LEAST_SHARE;
            let is_b = closed(&b) && !closed(&a) || closed(&b) == closed(&a) && b.p_value < a.p_value;
            let clearer = if is_b { b } else { a };
            Some(Test { p_value: (2.0 * clearer.p_value).min(1.0), ..clearer })
        }
        (a, b) => a.or(b),
    }
}

/// Asks the rows of `place` as they were logged; `effect` is the gain of the input.
fn asked_as_logged(
    recording: &Recording,
    run: &Run,
    place: &Place,
    averaged: usize,
    effect: f64,
) -> Option<Test> {
    let rows = logged_rows(recording, run, place, averaged);
    let in_use =
        [run.rate.as_ref().and(recording.q.as_ref()), run.angle.as_ref().and(recording.theta.as_ref())];
    let motion: Vec<&[f64]> = in_use.into_iter().flatten().map(|signal| &signal[rows.clone()]).collect();
    let counts: Vec<bool> = recording.supervised[rows.clone()].iter().map(|supervised| !supervised).collect();
    own_rows::answers(&recording.u[rows], &motion, &counts, effect)
}

/// The rows of the recording that those of `place` were made of, `averaged` of them each.
fn logged_rows(recording: &Recording, run: &Run, place: &Place, averaged: usize) -> Range<usize> {
    // an averaged row stands in the middle of those that it was made of
    let early = if averaged > 1 { 0.5 * run.step } else { 0.0 } + 0.5 * recording.step;
    let row = |k: usize| recording.t.partition_point(|t| *t < run.time(k) - early);
    row(place.rows.start)..row(place.rows.end)
}

fn innovations(problem: &Problem<'_>, unpacked: &Unpacked) -> Option<Vec<Vec<Output>>> {
    let mut all = vec![Vec::new(); problem.data.runs.len()];
    problem.predict(unpacked, |run, e| all[run] = e.iter().map(|e| problem.pack(*e)).collect())?;
    Some(all)
}

/// Section IV, any section that is called closed, and any whose attitude reference moves.
fn closed_by_design(recordings: &[Recording], problem: &Problem<'_>, place: &Place) -> bool {
    let label = place.label.rsplit(':').next().unwrap_or("");
    let called = label.split(['#', ' ']).next() == Some("IV") || label.to_lowercase().contains("closed");
    let run = &problem.data.runs[place.run];
    let Some(recording) = recordings.get(run.recording) else { return called };
    let (from, to) = (run.time(place.rows.start), run.time(place.rows.end));
    let moves = |reference: &Vec<f64>| {
        let inside = recording.t.iter().zip(reference).filter(|(t, _)| (from..to).contains(*t));
        let mut values = inside.map(|(_, r)| *r);
        let first = values.next();
        values.any(|r| Some(r) != first)
    };
    called || recording.theta_ref.as_ref().is_some_and(moves)
}
