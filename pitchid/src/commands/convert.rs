//! `pitchid convert`: a recording or an axis of a flight log as a table.

use crate::axes::{AxisChoice, Readable};
use crate::commands::reading::options_with;
use crate::failure::Failure;
use crate::logs::{TimeSpan, open};
use crate::output;
use clap::Args;
use std::path::PathBuf;
use sysid::recording::{ColumnMap, InputHold};

/// Writes a recording, or an axis of a flight log, as CSV or Parquet in the project's columns
///
/// Reads what pitchid diagnose reads: recordings (CSV, Parquet, vectors of MATLAB files up to version 7) and flight logs. Rows are
/// those of one clock with an even step; what had to be done to them is told by pitchid diagnose.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The recording or flight log
    recording: PathBuf,

    /// The table: its name ends with .csv or .parquet
    table: PathBuf,

    /// The axis of a flight log, or of a recording with columns of several [default: pitch]
    #[arg(long, value_name = "AXIS")]
    axis: Option<AxisChoice>,

    /// A column of another name, or arithmetic over columns (see pitchid diagnose --help)
    #[arg(long = "column", value_name = "NAME=EXPR")]
    columns: Vec<ColumnMap>,

    /// The part to use, in seconds of the file's own clock
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true)]
    time: Option<TimeSpan>,

    /// Which flight of a log that holds several, counted from 1
    #[arg(long, value_name = "N")]
    flight: Option<usize>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid convert flight.ulg roll.parquet --axis roll --time 120..160
  pitchid convert rig.mat rig.csv --column u_V=volts

Exit status: 0 written; 2 the input could not be used.";

/// Converts.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { recording, table, axis, columns, time, flight } = arguments;
    let as_parquet = match table.extension().and_then(|end| end.to_str()) {
        Some("csv") => false,
        Some("parquet") => true,
        _ => {
            let found = format!("{}: neither .csv nor .parquet", table.display());
            return Err(Failure::new(found, "name the table with one of these ends"));
        }
    };
    output::check(Some(table.as_path()), &[recording.as_path()])?;
    let axis = axis.map(AxisChoice::single).transpose()?;
    let options = options_with(InputHold::default(), columns);
    let mut bytes = Vec::new();
    for source in open(std::slice::from_ref(recording), columns)? {
        let readable = Readable::new(source, *flight, time.as_ref())?;
        let found = readable.recording(axis, &options)?;
        if as_parquet { found.write_parquet(&mut bytes)? } else { found.write_csv(&mut bytes)? }
    }
    output::write_bytes(table, &bytes)?;
    output::print(&format!("table: {}\n", table.display()))
}
