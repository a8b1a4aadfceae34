//! `pitchid record`: writes what a board reports, as it comes.

use super::board_arguments::Line;
use crate::board::{CycleReport, Heard, Log, Stop};
use crate::failure::Failure;
use crate::output;
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Writes a recording live from a board
///
/// Every cycle that arrives becomes a row at once, texts of the board become comments. A line that breaks is opened again.
/// Ends with Ctrl-C, or after --seconds; until then the recording lies in RECORDING.csv.part. Sends nothing: what the board does is up to whoever flies it.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    line: Line,

    /// Where the recording goes
    #[arg(long, value_name = "RECORDING.csv")]
    out: PathBuf,

    /// End after this long
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,

    /// Write what is said at the end as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid record /dev/ttyUSB0 --out flight.csv
  pitchid record tcp:192.168.4.1:5760 --out flight.csv --seconds 200
  pitchid diagnose flight.csv --model simulation.toml

Exit status: 0 recorded; 2 the line could not be opened, the file not be written, or nothing came.";

/// Records.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    output::check(std::iter::once(&arguments.out).chain(&arguments.json).map(PathBuf::as_path), &[])?;
    Log::check(&arguments.out)?;
    let stop = Stop::on_ctrl_c()?;
    let mut station = arguments.line.open()?;
    station.record(Log::create(&arguments.out, "pitchid record")?, false);
    let begin = Instant::now();
    let over = || arguments.seconds.is_some_and(|seconds| begin.elapsed().as_secs_f64() >= seconds);
    let mut last: Option<CycleReport> = None;
    while !stop.wanted() && !over() {
        if let Some(Heard::Cycle(report)) = station.hear(Duration::from_millis(100))? {
            last = Some(report);
        }
    }
    let out = arguments.out.display();
    let Some(log) = station.finish()?.filter(|_| last.is_some()) else {
        return Err(Failure::new(
            format!("{out}: nothing came"),
            "look at the board's power and at the line",
        ));
    };
    output::print(&format!("{out}: {}\n", log.counted()))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    let answer = serde_json::json!({
        "schema": "pitchid.recorded/1",
        "recording": out.to_string(),
        "samples": log.rows,
        "cycles_lost": log.lost,
    });
    output::write(path, &output::json(&answer)?)
}
