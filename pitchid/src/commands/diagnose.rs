//! `pitchid diagnose`: what the model leaves out.

use super::reading::{Asked, ByAxis, Reading, long};
use crate::export::{self, Language};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::Report;
use crate::report::content::Content;
use crate::report::repeat::Repeat;
use crate::{output, text};
use clap::Args;
use flight_logs::axes::Axis;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use sysid::diagnosis::axes::{AxesDiagnosis, AxisRecordings, diagnose_axes};
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::model::file::to_toml;
use sysid::recording::Recording;

/// Says what physics the model of these recordings leaves out, and what adding it gains
///
/// Reads recordings, and the logs of PX4, ArduPilot, Betaflight and INAV as they are (see pitchid show).
///
/// Prints the verdict, a summary, the checks of the data, the VAF before and after of each section by models that were
/// selected and fitted without it, the parameters with units and 95 % intervals, where the model differs, what is left, and
/// the next experiment where candidates remain.
///
/// With --axis all, every axis is asked, and first what they share: a lag of the rotors is one effect of one size. The answers
/// are short then; the whole of one axis is that of --axis roll, pitch or yaw.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    reading: Reading,

    /// Write the answer as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,

    /// Write a report: one HTML file with pictures that needs nothing else; for each term, what the data say with that term
    /// taken out of the model
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,

    /// Draw the section that shows most: measured, the model before, the model after, and what each leaves over
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,

    /// Write each picture of the report as an SVG file into this folder, which is made where it is not there
    #[arg(long, value_name = "FOLDER")]
    pictures: Option<PathBuf>,

    /// Write the model with what was missing; `pitchid simulate --model` flies it
    #[arg(long, value_name = "EXTENDED.toml")]
    out_model: Option<PathBuf>,

    /// Write the linear part of that model as a script with its state-space matrices and delay: .m for the Control System
    /// Toolbox, .py for scipy and python-control
    #[arg(long, value_name = "MODEL.m|py")]
    export: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Verdicts:
  no_mismatch   the model, its parameters estimated again, explains the data down to the noise
  named         the missing physics is identified, its rivals are ruled out, and what is left beside it is small
  ambiguous     physics is missing and candidates remain, listed with the experiment that separates them
  unlisted      physics is missing and nothing in the catalogue explains it
  not_excited   the data cannot tell: too short, too weak, too noisy
  check_data    something about the recording has to be put right first; the option that does it is named

Examples:
  pitchid diagnose flight.csv --model sim.toml --report flight.html --out-model extended.toml
  pitchid diagnose log.csv --column q_rad_s=gyro_y --section I=5..30 --section IV=65..90
  pitchid diagnose flight.csv --plot flight.svg
  pitchid diagnose flight.ulg --axis roll --time 120..160
  pitchid diagnose flight.ulg --axis all --model vehicle.toml
  pitchid diagnose rig.csv --input interpolated --json - | jq .verdict

Exit status: 0 a diagnosis was made, whatever it says; 2 the input could not be used.";

/// Diagnoses.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs =
        [&arguments.json, &arguments.report, &arguments.plot, &arguments.out_model, &arguments.export];
    arguments.export.as_deref().map(Language::of).transpose()?;
    let reading = arguments.reading.resolved()?;
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &reading.inputs())?;
    if reading.all_axes() {
        return all_axes(arguments, &reading);
    }
    if let Some(folder) = &arguments.pictures {
        output::folder(folder)?;
    }
    reading.say_what_is_large();
    let progress = Progress::start("reading");
    let asked = reading.asked()?;
    progress.note(long(&asked.recordings).as_deref());
    let diagnosed = Diagnosed::new(asked, &|step| progress.say(step))?;
    drop(progress);
    output::print(&text::diagnosis(&diagnosed.content))?;
    let repeat = Repeat::of_this_run(&reading.inputs());
    output::print(&write(arguments, &diagnosed.report(repeat))?)
}

/// A diagnosis, and what it is shown with.
pub struct Diagnosed {
    /// In words.
    pub content: Content,
    /// What was found.
    pub found: Diagnosis,
    /// What was asked.
    pub recordings: Arc<[Recording]>,
}

impl Diagnosed {
    /// Diagnoses.
    pub fn new(asked: Asked, progress: &sysid::progress::Progress<'_>) -> Result<Self, Failure> {
        let Asked { recordings, names, axis, model } = asked;
        let mut found = diagnose(&recordings, model.as_ref().map(|(_, m)| m), progress)?;
        let axis = axis.to_string();
        found.answer.tell_of(&axis);
        let named = model.as_ref().map(|(name, m)| (name.as_str(), m));
        let content = Content::new(&found.answer, &found.traces, names, named).of_axis(&axis);
        Ok(Self { content, found, recordings })
    }

    /// What a report is made of.
    pub fn report(&self, repeat: Repeat) -> Report<'_> {
        Report { content: &self.content, found: &self.found, recordings: &self.recordings, repeat }
    }
}

/// Diagnoses every axis, and what they share.
fn all_axes(arguments: &Arguments, reading: &Reading) -> Result<(), Failure> {
    if arguments.report.is_some()
        || arguments.pictures.is_some()
        || arguments.plot.is_some()
        || arguments.export.is_some()
    {
        return Err(Failure::new(
            "--axis all: a report, its pictures and a linear part are of one axis",
            "choose --axis roll, pitch or yaw for them",
        ));
    }
    reading.say_what_is_large();
    let progress = Progress::start("reading");
    let found = by_axis(reading, &|step| progress.say(step))?;
    drop(progress);
    output::print(&text::axes::diagnoses(&found))?;
    if let Some(path) = &arguments.out_model {
        output::write(path, &models(&found)?)?;
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    output::write(path, &json_by_axis(&found)?)
}

/// Asks every axis, and what they share.
pub fn by_axis(
    reading: &Reading,
    progress: &sysid::progress::Progress<'_>,
) -> Result<AxesDiagnosis, Failure> {
    let ByAxis { read, refused } = reading.recordings_by_axis()?;
    if read.is_empty()
        && let Some(refusal) = refused.into_iter().next()
    {
        return Err(refusal);
    }
    let with_model = |(axis, recordings): (Axis, Vec<Recording>)| {
        let model = reading.model_of(Some(axis))?;
        Ok(AxisRecordings { name: axis.to_string(), recordings, model })
    };
    let axes = read.into_iter().map(with_model).collect::<Result<Vec<AxisRecordings>, Failure>>()?;
    Ok(diagnose_axes(&axes, progress)?)
}

/// The models of all axes as a file.
pub fn models(found: &AxesDiagnosis) -> Result<String, Failure> {
    let models: Vec<_> = found.axes.iter().map(|(axis, d)| (axis.as_str(), &d.model)).collect();
    Ok(to_toml(&models)?)
}

/// The answers of all axes as JSON.
pub fn json_by_axis(found: &AxesDiagnosis) -> Result<String, Failure> {
    let answers: Vec<_> =
        found.axes.iter().map(|(axis, d)| serde_json::json!({ "axis": axis, "answer": d.answer })).collect();
    let answer = serde_json::json!({
        "schema": "pitchid.diagnoses/1",
        "shared": found.shared,
        "axes": answers,
    });
    output::json(&answer)
}

/// Writes what was asked for and says so.
fn write(arguments: &Arguments, report: &Report<'_>) -> Result<String, Failure> {
    let found = report.found;
    let mut said = String::new();
    let mut put = |what: &str, path: &Path, text: &str| -> Result<(), Failure> {
        if said.is_empty() {
            said.push('\n');
        }
        said.push_str(&format!("{what}: {}\n", path.display()));
        output::write(path, text)
    };
    if let Some(path) = &arguments.out_model {
        put("extended model", path, &found.model.to_toml()?)?;
    }
    if let Some(path) = &arguments.export {
        let unit = report.recordings.first().map_or("", |recording| recording.u_unit.symbol());
        put("linear part", path, &export::script(&found.model, unit, Language::of(path)?)?)?;
    }
    if let Some(path) = &arguments.report {
        put("report", path, &report.html())?;
    }
    if let Some(path) = &arguments.plot {
        let help = "leave out --plot; --report says why";
        let picture = report.picture().ok_or_else(|| Failure::new("there is nothing to draw", help))?;
        put("picture", path, &picture)?;
    }
    if let Some(folder) = &arguments.pictures {
        for (name, svg) in report.pictures() {
            put("picture", &folder.join(name), &svg)?;
        }
    }
    if let Some(path) = &arguments.json {
        put("answer", path, &output::json(&found.answer)?)?;
    }
    Ok(said)
}
