//! `pitchid reproduce benchmarks`: EMPS and Silverbox in their official split.

use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use benchmark::reproduce::benchmarks::{page, published};
use clap::Args;
use std::path::PathBuf;

/// EMPS and Silverbox: diagnosed on the training data, then free runs over the test data of the official split
///
/// The diagnosis of the training data gives plant and terms. Terms without which the free run over the last quarter of the
/// training data is no worse are dropped; the others are fitted to all training data by output error. The test data give the
/// state at their start (EMPS: 20 samples, Silverbox: 50) and nothing else. Prints the root mean square error of each free
/// run after that beside published ones.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Folder with the split: emps_train.csv, emps_test.csv, silverbox_multisine_train.csv, silverbox_multisine_test.csv,
    /// silverbox_arrow.csv; columns t_s, u_N or u_V, and the position as theta_rad
    #[arg(long, value_name = "DIR")]
    data: PathBuf,

    /// Folder for the page and the figures as JSON
    #[arg(long, value_name = "DIR", default_value = "pitchid-benchmarks")]
    out: PathBuf,

    /// Write the figures as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into the folder of --out:
  benchmarks.md    the table, and what was named and kept
  benchmarks.json  the same as figures

Example:
  pitchid reproduce benchmarks --data nonlinear_benchmarks

Exit status: 0 reproduced; 2 a file of the split or the folder could not be used.";

/// Runs them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check(arguments.json.as_deref(), &[])?;
    let progress = Progress::start("reading");
    let outcomes = published(&arguments.data, &arguments.out, &|step| progress.say(step))?;
    drop(progress);
    output::print(&text::table(&page::HEADER, page::rows(&outcomes), 1))?;
    for outcome in &outcomes {
        output::print(&format!("\n{}", text::paragraph(&page::told(outcome))))?;
    }
    output::print(&format!("\nPage: {}\n", arguments.out.join("benchmarks.md").display()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = serde_json::json!({ "schema": "pitchid.benchmarks/1", "benchmarks": outcomes });
    output::write(path, &output::json(&answer)?)
}
