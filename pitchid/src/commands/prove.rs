//! `pitchid prove`: the proof that anyone can repeat.

use crate::failure::Failure;
use crate::progress::Progress;
use crate::{output, text};
use benchmark::{Proof, Table};
use clap::Args;
use host_sim::Air;
use std::path::{Path, PathBuf};
use sysid::progress::{Counted, Step};

/// Conceals physics in many simulated vehicles, seals the truth, diagnoses, and counts what was found
///
/// Of six cases in turn three conceal an effect of the catalogue, one a pair, one nothing, and one an effect that no catalogue
/// has; plants, sizes, backgrounds and noise are drawn by the seed. The hash of every truth is printed before the first
/// diagnosis, which sees the recording and a nominal model alone; only then are the truths opened, and their hashes checked.
/// Beside it stand two other methods on the same recordings: sparse regression (STLSQ) and a black box.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Number of cases; 24 take about two minutes on two cores
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    cases: u64,

    /// Seed that draws the cases
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Folder for the cases and the results
    #[arg(long, value_name = "DIR", default_value = "pitchid-proof")]
    out: PathBuf,

    /// Kind of background: band_passed, three_poles, heavy_tailed or grows_with_command. The noise model has the first
    #[arg(long, value_name = "WORD", default_value_t)]
    air: Air,

    /// Go on in a folder where a proof was begun; finished cases are not done again
    #[arg(long)]
    resume: bool,

    /// Cases at a time; all cores without it. The results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=256))]
    jobs: Option<u64>,

    /// Write the tables as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Writes into DIR:
  cases/NNNN/    recording.csv, model.toml, truth.json, truth.sha256, answer.json, beside.json
  seals.txt      hashes of all truths; `sha256sum -c seals.txt` checks them
  results.json   every case, judged                table.md      the tables
  report.html    the tables with a picture

Examples:
  pitchid prove
  pitchid prove --cases 600 --out proof
  pitchid prove --cases 600 --out proof --resume

Exit status: 0 the proof was made, however it came out; 2 the arguments or the folder could not be used.";

/// Proves.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { cases, seed, air, ref out, resume, jobs, ref json } = *arguments;
    output::check(json.as_deref(), &[])?;
    let proof = Proof::open(out, seed, cases, air, resume)?;
    let jobs = jobs.map_or(0, |jobs| jobs as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
    let pool = pool.map_err(|e| Failure::new(format!("no threads: {e}"), "ask for fewer --jobs"))?;
    let tables = pool.install(|| prove(&proof, cases))?;
    let Some(path) = json else { return Ok(()) };
    output::write(path, &self::json(cases, seed, air, out, &tables)?)
}

/// The tables as JSON.
fn json(cases: u64, seed: u64, air: Air, folder: &Path, tables: &[Table]) -> Result<String, Failure> {
    output::json(&serde_json::json!({
        "schema": "pitchid.proof/1",
        "cases": cases,
        "seed": seed,
        "air": air.to_string(),
        "folder": folder.display().to_string(),
        "tables": tables,
    }))
}

/// The seals in words.
pub fn told_seals(seals: &str) -> String {
    format!("Sealed, SHA-256 of each truth:\n{seals}\n")
}

/// The tables in words, and where the report lies.
pub fn told(tables: &[Table], report: &Path) -> String {
    let table = |table: &Table| {
        let rows = text::table(&table.header, table.short_rows(), 1);
        format!("{}\n{rows}\n", table.title)
    };
    tables.iter().map(table).collect::<String>() + &format!("Report: {}\n", report.display())
}

fn prove(proof: &Proof, cases: u64) -> Result<Vec<Table>, Failure> {
    let seals = counted(cases, "concealing", |done| proof.seal(done))?;
    output::print(&told_seals(&seals))?;
    counted(cases, "diagnosing", |done| proof.diagnose(done))?;
    let tables = counted(cases, "opening the truths", |done| proof.count(done))?;
    output::print(&told(&tables, &proof.report()))?;
    Ok(tables)
}

/// Does a step of all cases, and says on standard error how far it is.
fn counted<T>(
    cases: u64,
    what: &str,
    step: impl FnOnce(&(dyn Fn() + Sync)) -> Result<T, benchmark::Error>,
) -> Result<T, Failure> {
    let progress = Progress::start(what);
    let say = |step: Step<'_>| progress.say(step);
    let counted = Counted::new(&say, what, cases as usize);
    Ok(step(&|| counted.one())?)
}
