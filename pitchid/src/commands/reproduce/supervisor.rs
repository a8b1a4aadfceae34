//! `pitchid reproduce supervisor`: tests that go wrong.

use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use benchmark::reproduce::supervisor::page::{HEADER, broken, rows};
use benchmark::reproduce::supervisor::supervisor;
use clap::Args;
use std::path::PathBuf;

/// The board's supervisor in simulated tests that go wrong: how far beyond the limit, and whether its promises hold
///
/// Draws craft from stable to unstable, conceals physics in them, lets gusts blow and sensors or servo fail, flies each test by the
/// board's own core, and watches every tick: the attitude against a bound that follows from the delay, the excitation, the controller's
/// law, the recoveries, the estimator, and that all numbers are finite.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Tests
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    tests: u64,

    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    seed: u64,

    /// Folder for the page and the figures as JSON
    #[arg(long, value_name = "DIR", default_value = "pitchid-supervisor")]
    out: PathBuf,

    /// Write the figures as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into the folder of --out:
  supervisor.md    the tables
  supervisor.json  every test

Examples:
  pitchid reproduce supervisor --tests 200
  pitchid reproduce supervisor --tests 10000 --seed 3

Exit status: 0 flown, whether the promises held or not; 2 the folder could not be used.";

/// Flies them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check(arguments.json.as_deref(), &[])?;
    let folder = arguments.out.as_path();
    output::folder(folder)?;
    let progress = Progress::start("flying");
    let study = supervisor(folder, arguments.tests, arguments.seed, &|what| progress.say(what))?;
    drop(progress);
    output::print(&text::table(&HEADER, rows(&study), 1))?;
    for promise in broken(&study) {
        output::print(&format!("broken: {promise}\n"))?;
    }
    output::print(&format!("\nPage: {}\n", folder.join("supervisor.md").display()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    output::write(
        path,
        &output::json(&serde_json::json!({ "schema": "pitchid.supervisor/1", "study": study }))?,
    )
}
