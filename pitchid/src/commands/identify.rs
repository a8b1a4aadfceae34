//! `pitchid identify`: the pitch dynamics, by every method side by side.

use super::reading::Reading;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use clap::Args;
use std::path::PathBuf;
use sysid::identify::compare::identify;

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

    /// Write the identification as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,

    /// Write the identified grey box as a model file
    #[arg(long, value_name = "OUT.toml")]
    out_model: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid identify flight.csv
  pitchid identify flight.bin --axis roll
  pitchid identify test1.csv test2.csv --out-model fitted.toml --json fitted.json

Exit status: 0 identified; 2 the input could not be used.";

/// Identifies.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs = [&arguments.json, &arguments.out_model];
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &arguments.reading.inputs())?;
    let recordings = arguments.reading.recordings()?;
    let model = arguments.reading.model()?;
    let progress = Progress::start("reading");
    let found = identify(&recordings, model.as_ref().map(|(_, m)| m), &|what| progress.say(what))?;
    drop(progress);
    if !outputs.into_iter().any(|path| output::is_stdout(path.as_deref())) {
        output::print(&text::identification(&found))?;
    }
    if let Some(path) = &arguments.out_model {
        output::write(path, &found.model.to_toml()?)?;
    }
    if let Some(path) = &arguments.json {
        output::write(path, &output::json(&found)?)?;
    }
    Ok(())
}
