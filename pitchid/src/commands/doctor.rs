//! `pitchid doctor`: what is wrong with a set-up or a file, and what to do about it.

mod file;
mod set_up;

use crate::failure::Failure;
use crate::output;
use crate::text::indented;
use crate::vehicle::Wanted;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use sysid::recording::ColumnMap;

/// Says what is wrong with the set-up, or with a file that fails, and what to do about it
///
/// Without a file: version, terminal, serial devices, the vehicle's file, and whether the working directory can be written. With
/// files: each is read step by step up to the first thing that is wrong; where all is well, the next command is told.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Files of any kind; - is standard input
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,

    /// A column of another name, or arithmetic over columns, as `pitchid diagnose` takes it: t_s=millis/1000
    #[arg(long = "column", value_name = "NAME=EXPR")]
    columns: Vec<ColumnMap>,

    #[command(flatten)]
    wanted: Wanted,

    /// Write the answer as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid doctor
  pitchid doctor flight.ulg
  pitchid doctor *.csv --json health.json

Exit status: 0 it was looked at, whatever was found; 2 the arguments could not be used.";

/// What came of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum State {
    Well,
    Doubtful,
    Wrong,
}

/// One thing that was looked at.
#[derive(Debug, Serialize)]
struct Step {
    state: State,
    words: String,
    /// What to do.
    remedy: Option<String>,
}

impl Step {
    fn well(words: impl Into<String>) -> Self {
        Self { state: State::Well, words: words.into(), remedy: None }
    }

    fn doubtful(words: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { state: State::Doubtful, words: words.into(), remedy: Some(remedy.into()) }
    }

    fn wrong(words: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { state: State::Wrong, words: words.into(), remedy: Some(remedy.into()) }
    }

    fn of(failure: &Failure) -> Self {
        Self::wrong(failure.to_string(), failure.help())
    }
}

/// All that was looked at in one place.
#[derive(Debug, Serialize)]
struct Examined {
    /// The file; none of the set-up.
    name: Option<String>,
    steps: Vec<Step>,
    /// The command to go on with.
    next: Option<String>,
}

/// Examines.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs: Vec<&Path> = arguments.files.iter().map(PathBuf::as_path).collect();
    output::check(arguments.json.as_deref(), &inputs)?;
    crate::input::once(inputs)?;
    let vehicle = arguments.wanted.find();
    let examined: Vec<Examined> = match arguments.files.as_slice() {
        [] => vec![set_up::examined(&vehicle)],
        files => files.iter().map(|path| file::examined(path, &arguments.columns, &vehicle)).collect(),
    };
    output::print(&examined.iter().map(told).collect::<Vec<_>>().join("\n"))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = serde_json::json!({
        "schema": "pitchid.doctor/1",
        "version": env!("CARGO_PKG_VERSION"),
        "examined": examined,
    });
    output::write(path, &output::json(&answer)?)
}

fn told(examined: &Examined) -> String {
    let mut text = format!("{}\n", examined.name.as_deref().unwrap_or("The set-up"));
    for step in &examined.steps {
        let mark = match step.state {
            State::Well => "well",
            State::Doubtful => "doubt",
            State::Wrong => "WRONG",
        };
        text += &indented(&step.words, &format!("  {mark:<6} "), "         ");
        if let Some(remedy) = &step.remedy {
            text += &indented(&format!("what to do: {remedy}"), "         ", "         ");
        }
    }
    match &examined.next {
        Some(next) => text + &format!("  next   {next}\n"),
        None => text,
    }
}
