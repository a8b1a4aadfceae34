//! `pitchid reproduce plans`: planned against flown.

use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use benchmark::reproduce::plans::{HEADER, plans, rows};
use clap::Args;
use std::path::PathBuf;

/// Planned against flown, in the simulator: whether tests go as pitchid plan foretold
///
/// Draws crafts of one size and mass, flies each by the plan that these give, identifies it, plans again from the model with its
/// intervals, and flies that. Counts how often the largest angle, the share that the supervisor took and every accuracy lay in
/// the bands of the plan. A craft takes about a quarter of a minute of two cores.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Crafts
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    crafts: u64,

    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    seed: u64,

    /// Folder for the table and the figures as JSON
    #[arg(long, value_name = "DIR", default_value = "pitchid-plans")]
    out: PathBuf,

    /// Write the counts as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into the folder of --out:
  plans.md    the table
  plans.json  the same for programs

Examples:
  pitchid reproduce plans --crafts 10

Exit status: 0 reproduced; 2 the folder could not be used.";

/// Plans and flies.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check(arguments.json.as_deref(), &[])?;
    let folder = arguments.out.as_path();
    output::folder(folder)?;
    let progress = Progress::start("planning");
    let counted = plans(folder, arguments.crafts, arguments.seed, &|what| progress.say(what))?;
    drop(progress);
    output::print(&text::table(&HEADER, rows(&counted), 1))?;
    output::print(&format!("\nPage: {}\n", folder.join("plans.md").display()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    output::write(path, &output::json(&serde_json::json!({ "schema": "pitchid.plans/1", "plans": counted }))?)
}
