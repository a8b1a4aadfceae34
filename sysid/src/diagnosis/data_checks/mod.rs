//! Checks of the data first: what makes model and measurement differ without any physics being missing. Each is ruled out or
//! named from the data, or the data cannot tell; none is left unasked.
//!
//! | cause | asked of |
//! | --- | --- |
//! | `clock`, `saturation`, `dead_channel` | the recordings (`channels`) |
//! | `smoothing` | whether each row brings news (`channels`) |
//! | `rate_sign`, `rate_unit` | the rate's integral against the angle (`motion`) |
//! | `input_sign`, `input_unit` | ∂M/∂u as fitted against the user's model (`input`) |
//! | `delay`, `input_hold` | the likelihood, the delay set free (`timing`) |
//! | `feedback` | the innovations against later inputs (`news`), the rows as they were logged (`own_rows`), the motion at a switch against the next (`dwells`) |

mod channels;
mod dwells;
mod feedback;
#[cfg(test)]
pub(crate) mod fixture;
mod input;
mod motion;
mod news;
mod own_rows;
mod timing;

use super::answer::{Answer, Location, Verdict};
use super::questions::questions;
use crate::dataset::{Dataset, Run};
use crate::estimate::Estimate;
use crate::likelihood::fit::{Fit, fit_baseline};
use crate::likelihood::problem::Problem;
use crate::model::baseline::Baseline;
use crate::model::effect::Locus;
use crate::recording::{NoteKind, Recording};
pub use feedback::{FEEDBACK, Loops};
use input::Response;
use serde::Serialize;

/// Whether a check of the data is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// The data speak against it.
    RuledOut,
    /// It is there.
    Found,
    /// The data do not decide, or nothing is there to compare with.
    CannotTell,
}

/// What a check of the data that was found does to the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gravity {
    /// It is told.
    Told,
    /// The summary begins with it.
    Headline,
    /// It would be taken for physics: no physics is named before it is put right.
    Stops,
}

/// One check of the data, and what the data say of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DataCheck {
    /// Which one.
    pub cause: &'static str,
    /// Whether it is there.
    pub state: State,
    /// Why, with numbers and units; where it is found, what to do.
    pub words: String,
    /// What it does to the answer.
    #[serde(skip)]
    pub gravity: Gravity,
}

impl DataCheck {
    /// The data speak against `cause`.
    pub fn ruled_out(cause: &'static str, words: impl Into<String>) -> Self {
        Self { cause, state: State::RuledOut, words: words.into(), gravity: Gravity::Told }
    }

    /// The data do not decide on `cause`.
    pub fn cannot_tell(cause: &'static str, words: impl Into<String>) -> Self {
        Self { cause, state: State::CannotTell, words: words.into(), gravity: Gravity::Told }
    }

    /// `cause` is there.
    pub fn found(cause: &'static str, gravity: Gravity, words: impl Into<String>) -> Self {
        Self { cause, state: State::Found, words: words.into(), gravity }
    }

    fn stops(&self) -> bool {
        self.state == State::Found && self.gravity == Gravity::Stops
    }
}

/// Degrees per radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// What only a fit can tell.
const OF_FIT: [&str; 5] = ["input_sign", "input_unit", "delay", "input_hold", "feedback"];

/// What the recordings alone say. `dm_du` is the user's ∂M/∂u, where the model has one.
pub fn of_recordings(recordings: &[Recording], data: &Dataset, dm_du: Option<f64>) -> Vec<DataCheck> {
    vec![
        channels::clock(recordings),
        channels::saturation(recordings),
        channels::dead(recordings),
        channels::smoothing(data),
        motion::sign(recordings, data, dm_du),
        motion::unit(recordings, data),
    ]
}

/// What a fit says beyond that, of which `told` is told; `loops` by the innovations.
pub fn of_fit(
    recordings: &[Recording],
    problem: &Problem<'_>,
    fit: &Fit,
    told: Vec<Estimate>,
    dm_du: Option<f64>,
    loops: &Loops,
) -> Vec<DataCheck> {
    if !problem.data.input_changes() {
        return without_fit("the input never changes").collect();
    }
    let delay = timing::delay(problem, fit, &told);
    let response = Response::new(recordings, problem, told, dm_du);
    vec![response.sign(!loops.any_open()), response.unit(), delay, timing::hold(problem, fit), loops.check()]
}

/// A motion that is over within so many rows of its cause is more like what a controller makes of it.
const QUICK_ROWS: f64 = 4.0;
/// Rows for which a command keeps its value in the mean that is no answer to what is over within [`QUICK_ROWS`].
const DECIDED_ROWS: usize = 10;
/// Rows for which a command that was decided beforehand keeps a value at least, in the mean.
const HELD_ROWS: usize = 2;

/// Whether `fit` has the motion come before the input, by more than averages over a row make of it, and the loop is closed: the
/// fit is that of the controller then.
///
/// Such a fit tells the controller's answer itself, and what it leaves does not show that. Where the input has another value in each row and the
/// motion settles within a few of them, as a command does that is made of the motion and an airframe hardly can, the loop is asked
/// with the input first as well: the answer to a quick rig under a random input whose stamps are off is then humbler than it need be.
/// Otherwise stamps that are off are the simpler answer.
pub fn is_of_the_controller(recordings: &[Recording], problem: &Problem<'_>, fit: &Fit) -> bool {
    let delay = fit.delay(problem);
    let within_a_row = 0.5 * (1.0 - 1.0 / problem.data.thinned as f64) * problem.sizes.step;
    if problem.baseline.input_first || delay >= -within_a_row && delay > problem.earliest() {
        return false;
    }
    let is_held = |run: &Run| run.leads || run.holds_longer_than(HELD_ROWS);
    let with_the_input_first = || {
        let baseline = Baseline { input_first: true, ..problem.baseline.clone() };
        let first = Problem::new(problem.data, &baseline, &[]);
        fit_baseline(&first).is_some_and(|fit| Loops::new(recordings, &first, &fit).all_closed())
    };
    Loops::new(recordings, problem, fit).all_closed()
        || settles_like_a_command(problem, fit)
            && !problem.data.runs.iter().all(is_held)
            && with_the_input_first()
}

/// Whether the terms of `extended` turn cause and effect about: the motion comes as long before its input as stamps may be off, comes
/// after it by the `baseline` alone, and settles like a command that is made of it. That is how a controller answers the motion, and
/// no physics.
pub fn turns_cause_about(problem: &Problem<'_>, baseline: &Fit, extended: &Fit) -> bool {
    let first = extended.delay(problem) <= problem.earliest();
    !problem.baseline.input_first
        && first
        && baseline.delay(problem) > 0.0
        && settles_like_a_command(problem, extended)
}

/// Whether the motion by `fit` settles within a few rows, as a command does that is made of it and an airframe hardly can. A command
/// that keeps its value for much longer is made of nothing that is over so soon: a servo does that.
fn settles_like_a_command(problem: &Problem<'_>, fit: &Fit) -> bool {
    let plant = problem.unpack(&fit.effects, &fit.minimum.values).plant;
    -plant.dm_dq * QUICK_ROWS * problem.sizes.step > plant.inertia
        && !problem.data.runs.iter().all(|run| run.holds_longer_than(DECIDED_ROWS))
}

/// Whether `fit`, with the input first, has the motion follow without any delay, and the loop is closed or the motion settles like a
/// command that is made of it: nothing but the controller moves the input then. A fit that copies the controller to the last digit
/// leaves nothing that would show the loop.
pub fn is_the_controller_alone(problem: &Problem<'_>, fit: &Fit, loops: &Loops) -> bool {
    let at_once = problem.baseline.input_first && fit.delay(problem) <= problem.earliest();
    at_once && (loops.all_closed() || settles_like_a_command(problem, fit))
}

/// The causes that only a fit can tell, where there is none.
pub fn without_fit(reason: &str) -> impl Iterator<Item = DataCheck> + '_ {
    OF_FIT.into_iter().map(move |cause| DataCheck::cannot_tell(cause, reason))
}

/// Says of the loop what a fit tells that is not sure enough to be asked the rest.
pub fn tell_loop(checks: &mut [DataCheck], loops: &Loops) {
    let told = loops.check();
    checks.iter_mut().filter(|check| check.cause == told.cause).for_each(|check| *check = told.clone());
}

/// Whether no physics may be named.
pub fn stop(causes: &[DataCheck]) -> bool {
    causes.iter().any(DataCheck::stops)
}

/// Writes the checks into an answer: its list, the beginning of its summary, and, where one stops the diagnosis, its
/// verdict.
pub fn write(answer: &mut Answer, checks: Vec<DataCheck>) {
    let of = |gravity: Gravity| -> Vec<&str> {
        let found = checks.iter().filter(|c| c.state == State::Found && c.gravity == gravity);
        found.map(|c| c.words.as_str()).collect()
    };
    let (stops, headlines) = (of(Gravity::Stops), of(Gravity::Headline));
    let foremost = [stops.clone(), headlines].concat();
    if stops.is_empty() || answer.verdict == Verdict::NotExcited {
        if !foremost.is_empty() {
            answer.summary = format!("{} {}", sentence(&foremost), answer.summary);
        }
    } else {
        answer.verdict = Verdict::CheckData;
        answer.summary = format!(
            "{} No physics is named before that is put right: what is missing beside it would be mistaken for something else.",
            sentence(&foremost)
        );
    }
    answer.data_checks = checks;
    answer.questions = questions(answer);
}

/// Parts as one sentence; the name of a column keeps its small letter.
fn sentence(parts: &[&str]) -> String {
    let text = parts.join("; ");
    let first = text.split(' ').next().unwrap_or_default();
    let mut letters = text.chars();
    match letters.next() {
        Some(letter) if !first.contains('_') => {
            letter.to_uppercase().chain(letters).collect::<String>() + "."
        }
        _ => text + ".",
    }
}

fn locus(causes: &[DataCheck]) -> Locus {
    let of_input = causes.iter().any(|c| c.stops() && c.cause.starts_with("input"));
    if of_input { Locus::Actuator } else { Locus::Sensor }
}

/// Where a check of the data that stops the diagnosis sits: everywhere in the data.
pub fn everywhere(causes: &[DataCheck], data: &Dataset) -> Location {
    let end = data.runs.iter().map(|run| run.time(run.len().saturating_sub(1)));
    let step = data.runs.first().map_or(0.02, |run| run.step);
    let locus = locus(causes);
    let variable = match locus {
        Locus::Actuator => "u",
        _ if data.has_rate => "q",
        _ => "theta",
    };
    Location {
        locus,
        time_s: vec![[0.0, end.fold(0.0, f64::max)]],
        band_rad_s: [0.0, std::f64::consts::PI / step],
        variable: variable.into(),
        condition: "in all of the recording: the data, not the physics".into(),
        dependence: Vec::new(),
    }
}

/// What reading said of a signal that is too large for its unit.
fn too_large<'r>(recording: &'r Recording, target: &str) -> Option<&'r str> {
    noted(recording, NoteKind::Unit, target, "reaches")
}

/// The note of this kind on a signal, by whatever name its column has in the file, that begins with what the signal does.
fn noted<'r>(recording: &'r Recording, kind: NoteKind, target: &str, does: &str) -> Option<&'r str> {
    let column = recording.columns.iter().find(|map| map.target == target)?;
    let begin = format!("{} {does}", column.source.label());
    let mut notes = recording.notes.iter();
    notes.find(|n| n.kind == kind && n.text.starts_with(&begin)).map(|n| n.text.as_str())
}

/// Texts of several recordings as one, each with its file's name where there are several.
fn joined(recordings: &[Recording], described: impl Fn(&Recording) -> Option<String>) -> Option<String> {
    let all: Vec<String> = recordings
        .iter()
        .filter_map(|recording| {
            let words = described(recording)?;
            Some(if recordings.len() > 1 { format!("{}: {words}", recording.name) } else { words })
        })
        .collect();
    (!all.is_empty()).then(|| all.join("; "))
}

#[cfg(test)]
mod tests;
