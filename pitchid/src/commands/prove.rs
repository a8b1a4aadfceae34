//! `pitchid prove`: the proof that anyone can repeat.

use crate::failure::Failure;
use crate::{output, text};
use clap::Args;
use folder::{ANSWER, BESIDE, Folder, MODEL, RECORDING, SEAL, read_json};
use indicatif::{ProgressBar, ProgressStyle};
use judge::{Outcome, judge};
use rayon::prelude::*;
use std::path::PathBuf;
use sysid::catalogue::model_file::read_model;
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::recording::{ReadOptions, read};
use truth::{Beside, Said, Sparse};

mod black_box;
mod conceal;
mod confusion;
mod folder;
mod judge;
mod page;
mod sparse;
mod tally;
mod truth;

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
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u64).range(1..=9999))]
    cases: u64,

    /// Seed that draws the cases
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Folder for the cases and the results
    #[arg(long, value_name = "DIR", default_value = "pitchid-proof")]
    out: PathBuf,

    /// Go on in a folder where a proof was begun; finished cases are not done again
    #[arg(long)]
    resume: bool,

    /// Cases at a time; all cores without it. The results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=256))]
    jobs: Option<u64>,
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
    let folder = Folder::open(&arguments.out, arguments.seed, arguments.resume)?;
    let jobs = arguments.jobs.map_or(0, |jobs| jobs as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
    let pool = pool.map_err(|e| Failure::new(format!("no threads: {e}"), "ask for fewer --jobs"))?;
    pool.install(|| prove(arguments, &folder))
}

fn prove(arguments: &Arguments, folder: &Folder) -> Result<(), Failure> {
    let Arguments { cases, seed, .. } = *arguments;
    each(cases, "concealing", |case| {
        if folder.has(case, SEAL) { Ok(()) } else { conceal::conceal(folder, seed, case) }
    })?;
    let seals: String = (0..cases).map(|case| folder.seal_line(case)).collect::<Result<_, _>>()?;
    output::write(&folder.file("seals.txt"), &seals)?;
    output::print(&format!("Sealed, SHA-256 of each truth:\n{seals}\n"))?;

    each(cases, "diagnosing", |case| if folder.has(case, BESIDE) { Ok(()) } else { answer(folder, case) })?;

    let outcomes = each(cases, "opening the truths", |case| open(folder, case))?;
    let tables = tally::tables(&outcomes);
    output::write(&folder.file("results.json"), &output::json(&outcomes)?)?;
    let markdown: String = tables.iter().map(tally::Table::markdown).collect();
    let command = page::command(outcomes.len(), seed);
    let lead = page::lead(&outcomes);
    output::write(&folder.file("table.md"), &format!("{lead} `{command}`\n\n{markdown}"))?;
    output::write(&folder.file("report.html"), &page::html(&outcomes, &tables, seed)?)?;
    for table in &tables {
        let rows = text::table(&table.header, table.short_rows(), 1);
        output::print(&format!("{}\n{rows}\n", table.title))?;
    }
    output::print(&format!("Report: {}\n", folder.file("report.html").display()))
}

/// Does something for every case, several at a time, and says on standard error how far it is. The first case that
/// fails, by number, is the failure of all.
fn each<T: Send>(
    cases: u64,
    what: &'static str,
    one: impl Fn(u64) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let bar = ProgressBar::new(cases).with_message(what);
    if let Ok(style) = ProgressStyle::with_template("{msg:20} {wide_bar} {pos}/{len} {elapsed}, {eta} left") {
        bar.set_style(style);
    }
    let done: Vec<Result<T, Failure>> =
        (0..cases).into_par_iter().map(|case| one(case).inspect(|_| bar.inc(1))).collect();
    bar.finish_and_clear();
    done.into_iter().collect()
}

/// Diagnoses one case, from its recording and its model, and lets the other methods try.
fn answer(folder: &Folder, case: u64) -> Result<(), Failure> {
    let recording = [read(&folder.of(case, RECORDING), &ReadOptions::default())?];
    let model = read_model(&folder.of(case, MODEL))?;
    let found = diagnose(&recording, Some(&model), &|_| ());
    let json = match &found {
        Ok(found) => output::json(&found.answer)?,
        // a refusal is an answer too, and counts as missed
        Err(error) => output::json(&serde_json::json!({ "refused": error.to_string() }))?,
    };
    output::write(&folder.of(case, ANSWER), &json)?;
    let nothing = Sparse { terms: Vec::new(), ids: Vec::new(), vaf_percent: Default::default() };
    let parameters = found.as_ref().map_or(0, added_parameters).max(2);
    let beside = Beside {
        sparse: sparse::regress(&recording[0], &model).unwrap_or(nothing),
        black_box_vaf_percent: found
            .as_ref()
            .map(|found| black_box::correct(&recording[0], &found.traces, parameters))
            .unwrap_or_default(),
        black_box_parameters: parameters,
    };
    output::write(&folder.of(case, BESIDE), &output::json(&beside)?)
}

/// Number of parameters that the diagnosis added.
fn added_parameters(found: &Diagnosis) -> usize {
    found.answer.effects.iter().map(|effect| effect.parameters.len()).sum()
}

/// Opens the truth of a case and holds the answer against it.
fn open(folder: &Folder, case: u64) -> Result<Outcome, Failure> {
    let truth = folder.open_truth(case)?;
    let answer: serde_json::Value = read_json(&folder.of(case, ANSWER))?;
    let beside: Beside = read_json(&folder.of(case, BESIDE))?;
    let said: Option<Said> =
        if answer.get("refused").is_some() { None } else { Some(read_json(&folder.of(case, ANSWER))?) };
    Ok(judge(&truth, said.as_ref(), &beside))
}
