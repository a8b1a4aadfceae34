//! `pitchid identify`: the pitch dynamics, by every method side by side.

use super::reading::{Reading, long};
use crate::board::taps::TapsFile;
use crate::export::{self, Language};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::identified;
use crate::report::repeat::Repeat;
use crate::{output, text};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use sysid::identify::compare::{Identification, Settings, identify_with};
use sysid::monitor::{Design, design};

/// Identifies the pitch dynamics by every method and judges each on data that it has not seen
///
/// Prints one line for each method with its VAF on section IV (closed loop) and on an unused PRBS (the last one), and the
/// parameters of the grey box with units and 95 % intervals. With fewer sections, the last one, or the last part of a single
/// one, is held out.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    reading: Reading,

    /// What the estimator on board came to, as pitchid fly --taps wrote it: a line "LMS on board" beside the others, and its
    /// settings for the estimator that is replayed
    #[arg(long, value_name = "TAPS.json")]
    taps: Option<PathBuf>,

    /// Write the identification as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,

    /// Write a report: one HTML file with pictures that needs nothing else
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,

    /// Draw gain, phase and coherence of the data, and every linear model beside them
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,

    /// Write the identified grey box as a model file
    #[arg(long, value_name = "OUT.toml")]
    out_model: Option<PathBuf>,

    /// Write the identified grey box as a script with its state-space matrices and delay: .m for the Control System Toolbox,
    /// .py for scipy and python-control
    #[arg(long, value_name = "MODEL.m|py")]
    export: Option<PathBuf>,

    /// Write what `pitchid monitor` and the board need to tell whether the craft still is what was identified
    #[arg(long, value_name = "OUT.toml")]
    monitor_out: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid identify flight.csv
  pitchid identify flight.bin --axis roll
  pitchid identify flight.csv --taps taps.json
  pitchid identify test1.csv test2.csv --out-model fitted.toml --json fitted.json
  pitchid identify flight.csv --report flight.html --plot response.svg
  pitchid identify flight.csv --export model.py
  pitchid identify flight.csv --monitor-out craft.toml

Exit status: 0 identified; 2 the input could not be used.";

/// Identifies.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs = [
        &arguments.json,
        &arguments.report,
        &arguments.plot,
        &arguments.out_model,
        &arguments.export,
        &arguments.monitor_out,
    ];
    let reading = arguments.reading.resolved()?;
    let mut inputs = reading.inputs();
    inputs.extend(arguments.taps.as_deref());
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &inputs)?;
    let language = arguments.export.as_deref().map(Language::of).transpose()?;
    let model = reading.model()?;
    let on_board = arguments.taps.as_deref().map(TapsFile::read).transpose()?.map(|file| file.on_board());
    let settings = Settings { on_board, ..Settings::default() };
    reading.say_what_is_large();
    let progress = Progress::start("reading");
    let recordings = reading.recordings()?;
    progress.note(long(&recordings).as_deref());
    let model = model.as_ref().map(|(_, m)| m);
    let found = identify_with(&recordings, model, &settings, &|step| progress.say(step))?;
    drop(progress);
    output::print(&text::identification(&found))?;
    if let Some(path) = &arguments.report {
        let repeat = Repeat::of_this_run(&inputs);
        output::write(path, &identified::page(&found, &recordings, &repeat))?;
    }
    if let Some(path) = &arguments.plot {
        let help = "there are too few samples for a response; leave out --plot";
        let chart = identified::responses(&found, &recordings);
        let chart = chart.ok_or_else(|| Failure::new("there is nothing to draw", help))?;
        output::write(path, &chart.file(900))?;
    }
    if let Some(path) = &arguments.out_model {
        output::write(path, &(cautions(&found, "# ") + &found.model.to_toml()?))?;
    }
    if let Some((path, language)) = arguments.export.as_deref().zip(language) {
        let unit = recordings.first().map_or("", |recording| recording.u_unit.symbol());
        let script = export::script(&found.model, unit, language)?;
        output::write(path, &(cautions(&found, language.comment()) + &script))?;
    }
    if let Some(path) = &arguments.monitor_out {
        let made = design(&recordings, model)?;
        output::write(path, &made.to_toml()?)?;
        output::print(&format!("\n{}", text::paragraph(&monitor_told(&made))))?;
    }
    if let Some(path) = &arguments.json {
        output::write(path, &json(&found)?)?;
    }
    Ok(())
}

/// The answer as JSON.
pub fn json(found: &Identification) -> Result<String, Failure> {
    #[derive(Serialize)]
    struct Answer<'a> {
        schema: &'static str,
        #[serde(flatten)]
        found: &'a Identification,
    }
    output::json(&Answer { schema: "pitchid.identification/1", found })
}

/// What speaks against the model, as lines of comment above it.
fn cautions(found: &Identification, comment: &str) -> String {
    found.cautions.iter().map(|caution| text::indented(caution, comment, comment)).collect()
}

/// What the monitor is, in words.
fn monitor_told(made: &Design) -> String {
    let [of, kept] = made.states;
    let mut told = format!("monitor: {kept} states");
    if kept < of {
        told += &format!(
            " of {of}; what the others would have moved the innovations by is at most {:.1e} deviations",
            made.reduction_error
        );
    }
    for note in &made.notes {
        told += "; ";
        told += note;
    }
    told
}
