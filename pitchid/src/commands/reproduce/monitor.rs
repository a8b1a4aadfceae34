//! `pitchid reproduce monitor`: what the monitor tells in simulated flights.

use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use benchmark::reproduce::monitor::{Amount, monitor, page};
use clap::Args;
use std::path::PathBuf;

/// The board's monitor in simulated flights: false alarms, and how soon and how rightly a change is told
///
/// Identifies vehicles, flies them where nothing changes, in quiet air and in gusts, and where one thing changes at a random
/// moment. Prints the time to the verdict beside that of a test that knows cause, size and model.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Flights in which something changes
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    flights: u64,

    /// Hours of flight in which nothing changes, in quiet air, and as many in gusts
    #[arg(long, value_name = "H", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    hours: u64,

    /// Vehicles in each of three airs
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..=99))]
    vehicles: u64,

    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    seed: u64,

    /// Folder for the page and the figures as JSON
    #[arg(long, value_name = "DIR", default_value = "pitchid-monitor")]
    out: PathBuf,

    /// Write the figures as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into the folder of --out:
  monitor.md    the table
  monitor.json  every flight

Examples:
  pitchid reproduce monitor
  pitchid reproduce monitor --flights 200 --hours 2 --seed 5

Exit status: 0 reproduced; 2 the folder could not be used.";

/// Flies them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = arguments.out.as_path();
    output::check(arguments.json.as_deref(), &[])?;
    output::folder(folder)?;
    let progress = Progress::start("identifying the vehicles");
    let Arguments { flights, hours, vehicles, seed, .. } = *arguments;
    let study = monitor(folder, Amount { vehicles, flights, hours, seed }, &|step| progress.say(step))?;
    drop(progress);
    output::print(&text::table(&page::HEADER, page::rows(&study), 2))?;
    output::print(&format!("\n{}", text::paragraph(&page::totals(&study))))?;
    output::print(&format!("\nPage: {}\n", folder.join("monitor.md").display()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = serde_json::json!({ "schema": "pitchid.monitor-study/1", "study": study });
    output::write(path, &output::json(&answer)?)
}
