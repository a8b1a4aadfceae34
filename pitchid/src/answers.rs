//! The questions of the command, asked by another program.
//!
//! Files are named by the words that would stand behind the command's name, so that each option means the same here and
//! there; recordings may also be at hand. The JSON of an answer has the same bytes as the command's.

use crate::axes::AxisChoice;
use crate::commands::reading::{Asked, Reading, model_at};
use crate::commands::show::content::{Shown, of_recording};
use crate::commands::{compare, diagnose, identify, plan, prove, show, simulate};
use crate::export::{Linear, linear};
use crate::failure::Failure;
use crate::report::identified;
use crate::report::repeat::Repeat;
use crate::text::comparison::{self, AxisAnswer};
use crate::{output, text};
use benchmark::html::Document;
use benchmark::{Proof, Table};
use clap::{Args, Parser, ValueEnum};
use maud::PreEscaped;
use std::path::Path;
use std::sync::Arc;
use sysid::identify::compare::identify as identify_by_all;
use sysid::identify::linear_model::LinearModel;
use sysid::model::file::ModelFile;
use sysid::model::state_space::StateSpace;
use sysid::progress::Progress;
use sysid::recording::Recording;

/// An answer with all that it can be shown as.
pub struct Answer {
    /// What the command writes with `--json`.
    pub json: String,
    /// What the command prints.
    pub text: String,
    /// The model that was found.
    pub model: Option<Model>,
    /// Sampled state-space models, by the method that found them.
    pub methods: Vec<(String, StateSpace)>,
    page: Option<Page>,
    pictures: Option<Pictures>,
}

/// Draws a page.
type Page = Box<dyn Fn() -> Result<String, Failure> + Send + Sync>;
/// Draws pictures: name and SVG.
type Pictures = Box<dyn Fn() -> Vec<(String, String)> + Send + Sync>;

/// A model of one axis.
pub struct Model {
    /// As a model file.
    pub toml: String,
    /// Its linear part; none where effectiveness or damping are not determined.
    pub linear: Option<Linear>,
}

impl Model {
    fn new(model: &ModelFile) -> Result<Self, Failure> {
        Ok(Self { toml: model.to_toml()?, linear: linear(model) })
    }
}

impl Answer {
    fn new(json: String, text: String) -> Self {
        Self { json, text, model: None, methods: Vec::new(), page: None, pictures: None }
    }

    /// The report: one HTML page that needs nothing else. None of an answer that has no report.
    ///
    /// # Errors
    /// A page that could not be made.
    pub fn html(&self) -> Result<Option<String>, Failure> {
        self.page.as_ref().map(|page| page()).transpose()
    }

    /// The pictures, name and SVG.
    #[must_use]
    pub fn pictures(&self) -> Vec<(String, String)> {
        self.pictures.as_ref().map(|draw| draw()).unwrap_or_default()
    }
}

/// What a question is about, and how to ask it again.
pub struct Question {
    asked: Asked,
    repeat: Repeat,
}

impl Question {
    /// Reads recordings and model as `words` say: file names and options of `pitchid diagnose`.
    ///
    /// # Errors
    /// Words or files that cannot be used.
    pub fn read(command: &str, words: &[String]) -> Result<Self, Failure> {
        Self::of(command, words, &parse::<Reading>(words)?.resolved()?)
    }

    fn of(command: &str, words: &[String], reading: &Reading) -> Result<Self, Failure> {
        let words = std::iter::once(command.to_owned()).chain(words.iter().cloned());
        Ok(Self { asked: reading.asked()?, repeat: Repeat::of(words, &reading.inputs()) })
    }

    /// Of recordings at hand, of one axis, with the user's model.
    ///
    /// # Errors
    /// No such axis, or a model that cannot be used.
    pub fn of_recordings(
        recordings: Arc<[Recording]>,
        axis: &str,
        model: Option<&Path>,
    ) -> Result<Self, Failure> {
        let axis = axis_named(axis)?;
        let model = match model {
            Some(path) => Some((path.display().to_string(), model_at(path, Some(axis))?)),
            None => None,
        };
        let names = recordings.iter().map(|recording| recording.name.clone()).collect();
        Ok(Self { asked: Asked { recordings, names, axis, model }, repeat: Repeat::default() })
    }

    /// The recordings, and their axis.
    #[must_use]
    pub fn recordings(&self) -> (Arc<[Recording]>, String) {
        (self.asked.recordings.clone(), self.asked.axis.to_string())
    }
}

fn axis_named(name: &str) -> Result<flight_logs::axes::Axis, Failure> {
    let choice = <AxisChoice as ValueEnum>::from_str(name, false);
    choice.map_err(|_| Failure::new(format!("axis {name:?}"), "choose roll, pitch or yaw"))?.single()
}

/// A command line without the command.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Words<T: Args> {
    #[command(flatten)]
    arguments: T,
}

fn parse<T: Args>(words: &[String]) -> Result<T, Failure> {
    let parsed = Words::<T>::try_parse_from(words);
    let refused = |error: clap::Error| {
        let told = error.render().to_string();
        let told = told.strip_prefix("error: ").unwrap_or(&told);
        let message =
            told.split("\n\n").next().unwrap_or(told).split_whitespace().collect::<Vec<_>>().join(" ");
        Failure::new(message, "see the options of the command: pitchid COMMAND --help")
    };
    Ok(parsed.map_err(refused)?.arguments)
}

/// `pitchid diagnose`, of files.
///
/// # Errors
/// Words or files that cannot be used.
pub fn diagnose_files(words: &[String], progress: &Progress<'_>) -> Result<Answer, Failure> {
    let reading = parse::<Reading>(words)?.resolved()?;
    if !reading.all_axes() {
        return diagnose(Question::of("diagnose", words, &reading)?, progress);
    }
    let found = diagnose::by_axis(&reading, progress)?;
    let model = Model { toml: diagnose::models(&found)?, linear: None };
    let answer = Answer::new(diagnose::json_by_axis(&found)?, text::axes::diagnoses(&found));
    Ok(Answer { model: Some(model), ..answer })
}

/// `pitchid diagnose`.
///
/// # Errors
/// Recordings that do not go together.
pub fn diagnose(question: Question, progress: &Progress<'_>) -> Result<Answer, Failure> {
    let Question { asked, repeat } = question;
    let diagnosed = Arc::new(diagnose::Diagnosed::new(asked, progress)?);
    let answer = Answer::new(output::json(&diagnosed.found.answer)?, text::diagnosis(&diagnosed.content));
    let model = Some(Model::new(&diagnosed.found.model)?);
    let drawn = diagnosed.clone();
    let pictures = Some(Box::new(move || drawn.report(Repeat::default()).pictures()) as Pictures);
    let page = Some(Box::new(move || Ok(diagnosed.report(repeat.clone()).html())) as Page);
    Ok(Answer { model, page, pictures, ..answer })
}

/// `pitchid identify`.
///
/// # Errors
/// Recordings that do not go together, or on which the grey box has no finite free run.
pub fn identify(question: Question, progress: &Progress<'_>) -> Result<Answer, Failure> {
    let Question { asked, repeat } = question;
    let Asked { recordings, model, .. } = asked;
    let found = identify_by_all(&recordings, model.as_ref().map(|(_, model)| model), progress)?;
    let sampled = found.methods.iter().filter_map(|method| match &method.model {
        Some(LinearModel::Sampled(model)) => Some((method.name.clone(), model.clone())),
        _ => None,
    });
    let methods = sampled.collect();
    let answer = Answer::new(identify::json(&found)?, text::identification(&found));
    let model = Some(Model::new(&found.model)?);
    let page = Some(Box::new(move || Ok(identified::page(&found, &recordings, &repeat))) as Page);
    Ok(Answer { model, methods, page, ..answer })
}

/// `pitchid compare`, of files.
///
/// # Errors
/// Words or files that cannot be used.
pub fn compare_files(words: &[String], progress: &Progress<'_>) -> Result<Answer, Failure> {
    let arguments = parse::<compare::Arguments>(words)?;
    let vehicle = arguments.vehicle()?;
    compared(&arguments.names(), compare::compared(&arguments, vehicle.as_ref(), progress)?)
}

/// `pitchid compare`, of recordings at hand.
///
/// # Errors
/// Recordings that cannot be compared, or a model that cannot be used.
pub fn compare(
    [before, after]: [Recording; 2],
    axis: &str,
    model: Option<&Path>,
    friction: bool,
    progress: &Progress<'_>,
) -> Result<Answer, Failure> {
    let axis = axis_named(axis)?;
    let model = model.map(|path| model_at(path, Some(axis))).transpose()?;
    let names = [before.name.clone(), after.name.clone()];
    let found = sysid::compare::compare(&[before], &[after], model.as_ref(), friction, progress)?;
    compared(&names, vec![AxisAnswer::new(Some(axis), found)])
}

fn compared(names: &[String; 2], answers: Vec<AxisAnswer>) -> Result<Answer, Failure> {
    let answer = Answer::new(compare::json(names, &answers)?, comparison::text(&answers));
    let pictures = move || vec![("changes.svg".to_owned(), comparison::picture(&answers))];
    Ok(Answer { pictures: Some(Box::new(pictures)), ..answer })
}

/// `pitchid plan`.
///
/// # Errors
/// Words or files that cannot be used, or limits that no excitation keeps.
pub fn plan(words: &[String], progress: &Progress<'_>) -> Result<Answer, Failure> {
    let arguments = parse::<plan::Arguments>(words)?;
    let vehicle = arguments.vehicle()?;
    let planned = plan::Planned::new(&arguments, vehicle.as_ref(), progress)?;
    let answer = Answer::new(output::json(&planned.plan)?, plan::words::text(&planned.plan, &planned.wishes));
    let all = std::iter::once("plan".to_owned()).chain(words.iter().cloned());
    let repeat = Repeat::of(all, &arguments.inputs(vehicle.as_ref()));
    let page = move || plan::page::page(&planned.plan, &planned.wishes, &planned.craft, &repeat);
    Ok(Answer { page: Some(Box::new(page)), ..answer })
}

/// `pitchid show`, of files.
///
/// # Errors
/// Words or files that cannot be used.
pub fn show_files(words: &[String]) -> Result<Answer, Failure> {
    shown(show::shown(&parse(words)?)?)
}

/// `pitchid show`, of a recording at hand.
///
/// # Errors
/// No such axis.
pub fn show(recording: &Recording, axis: &str) -> Result<Answer, Failure> {
    shown(vec![Shown::Recording(of_recording(recording, Some(axis_named(axis)?)))])
}

fn shown(shown: Vec<Shown>) -> Result<Answer, Failure> {
    let answer = Answer::new(output::json(&shown)?, show::words::text(&shown));
    Ok(Answer { page: Some(Box::new(move || Ok(show::page::page(&shown)))), ..answer })
}

/// A flight on the simulated test-bed.
pub struct Flight {
    /// What was flown.
    pub answer: Answer,
    /// What was really there, as `--truth` writes it.
    pub truth: String,
    /// The recording, as `--out` writes it.
    pub recording: String,
}

/// `pitchid simulate`.
///
/// # Errors
/// Words or a model that cannot be used.
pub fn simulate(words: &[String]) -> Result<Flight, Failure> {
    let (flight, flown) = simulate::flown(&parse(words)?)?;
    let answer = Answer::new(output::json(&flown)?, flown.told());
    Ok(Flight { answer, truth: output::json(&flight.truth)?, recording: flight.recording() })
}

/// What `pitchid prove` prints of the seals.
#[must_use]
pub fn told_seals(seals: &str) -> String {
    prove::told_seals(seals)
}

/// What `pitchid prove` prints at its end.
#[must_use]
pub fn told_proof(tables: &[Table], proof: &Proof) -> String {
    prove::told(tables, &proof.report())
}

/// A page in the style of the reports, with this in its body; charts on it answer to mouse, touch and keys.
#[must_use]
pub fn page(title: &str, body: &str) -> String {
    let body = PreEscaped(body.to_owned());
    Document { title, style: include_str!("report/report.css"), body, json: None }.html(true)
}

/// Keeps this program's own words off the terminal: the caller speaks.
pub fn be_quiet() {
    output::be_quiet(true);
}
