//! `pitchid reproduce`: a published experiment again, and public benchmarks.

mod benchmarks;
mod monitor;
mod plans;
mod supervisor;

use super::reading::read_plain;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use benchmark::reproduce::{Paper, page, paper};
use clap::{Args, Subcommand};
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use sysid::identify::compare::Identification;

/// Repeats a published experiment in the simulator, or runs public benchmarks
#[derive(Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Paper(PaperArguments),
    Benchmarks(benchmarks::Arguments),
    Monitor(monitor::Arguments),
    Plans(plans::Arguments),
    Supervisor(supervisor::Arguments),
}

/// Table 2 and figures 6 to 8 of Riccardi, Panizza, Lovera (ERF 2014), over many simulated campaigns
///
/// Flies three tests of rising amplitude for each seed: on the nominal plant, on one with servo lag and a coloured moment, and on
/// one with dry friction besides. Every method learns from the first excitation of each; all are judged by the closed loop and by an unused
/// PRBS of the second test. Prints the median VAF with the range of the middle 80 % of the seeds beside the paper's figures.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
struct PaperArguments {
    /// Recordings of a rig, identified in the same way and shown beside
    #[arg(value_name = "RECORDING")]
    recordings: Vec<PathBuf>,

    /// Simulated campaigns per condition
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,

    /// Dwell of the PRBS: 1 = 0.05..0.1 s, 2 = 0.1..0.2 s, 3 = 0.2..0.4 s, 4 = 0.4..0.8 s
    #[arg(long, value_name = "1..4", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=4))]
    campaign: u8,

    /// Folder for the page, its pictures and the figures as JSON
    #[arg(long, value_name = "DIR", default_value = "pitchid-paper")]
    out: PathBuf,

    /// Write the figures as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into DIR:
  paper.md        the tables, with the pictures
  paper.json      every seed's figures
  figure6.svg     closed loop: measured and simulated         figure7.svg   unused PRBS: the same
  figure8.svg     H∞ match and PI-MOESP: responses            choice.svg    order and block size of PI-MOESP
  bode.svg        gains of all methods, with the data's own

Examples:
  pitchid reproduce paper
  pitchid reproduce paper --seeds 100 --out /tmp/paper
  pitchid reproduce paper flight1.csv flight2.csv

Exit status: 0 reproduced; 2 the folder or a recording could not be used.";

/// Reproduces.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.what {
        What::Paper(arguments) => run_paper(arguments),
        What::Benchmarks(arguments) => benchmarks::run(arguments),
        What::Monitor(arguments) => monitor::run(arguments),
        What::Plans(arguments) => plans::run(arguments),
        What::Supervisor(arguments) => supervisor::run(arguments),
    }
}

fn run_paper(arguments: &PaperArguments) -> Result<(), Failure> {
    let folder = arguments.out.as_path();
    let inputs: Vec<&Path> = arguments.recordings.iter().map(PathBuf::as_path).collect();
    output::check(arguments.json.as_deref(), &inputs)?;
    output::folder(folder)?;
    let recordings =
        arguments.recordings.iter().map(|path| read_plain(path)).collect::<Result<Vec<_>, _>>()?;
    let progress = Progress::start("flying and identifying");
    let PaperArguments { campaign, seeds, .. } = *arguments;
    let (paper, given) = paper(folder, campaign, seeds, &recordings, &|step| progress.say(step))?;
    drop(progress);
    output::print(&told(&paper, given.as_ref()))?;
    output::print(&format!("\nPage: {}\n", folder.join("paper.md").display()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = json!({ "schema": "pitchid.paper/1", "simulated": paper, "given": given });
    output::write(path, &output::json(&answer)?)
}

fn told(paper: &Paper, given: Option<&Identification>) -> String {
    let mut told = String::new();
    for study in &paper.studies {
        let supervised = page::supervised(study);
        let _ = writeln!(told, "\n{}; {} campaigns, {supervised}", study.condition.told(), paper.seeds);
        told.push_str(&text::table(&page::HEADER, page::rows(study), 1));
        told.push_str(&text::paragraph(&page::agreement(study)));
        told.push_str(&text::table(&page::ERRORS_HEADER, page::errors(study), 1));
    }
    if let Some(given) = given {
        told.push_str("\nThe given recordings\n");
        told.push_str(&text::methods(given));
    }
    told
}
