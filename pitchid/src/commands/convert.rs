//! `pitchid convert`: a recording or an axis of a flight log as a table.

use crate::axes::{AxisChoice, Readable};
use crate::commands::reading::options_with;
use crate::commands::show::content::of_recording;
use crate::failure::Failure;
use crate::logs::{TimeSpan, open};
use crate::progress::Progress;
use crate::vehicle::Wanted;
use crate::{input, output};
use clap::Args;
use std::path::PathBuf;
use sysid::error::Error;
use sysid::recording::{ColumnMap, InputHold, Recording};

/// Writes a recording, or an axis of a flight log, as CSV, Parquet, for MATLAB (.mat) or numpy (.npy)
///
/// Reads what pitchid diagnose reads: recordings (CSV, Parquet, vectors of MATLAB files up to version 7) and flight logs. Rows are
/// those of one clock with an even step; what had to be done to them is told by pitchid diagnose.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The recording or flight log; - is standard input
    recording: PathBuf,

    /// The table: its name ends with .csv (also for PlotJuggler, time t_s), .parquet, .mat or .npy
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

    #[command(flatten)]
    wanted: Wanted,

    /// Write what stands in the table as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid convert flight.ulg roll.parquet --axis roll --time 120..160
  pitchid convert rig.mat rig.csv --column u_V=volts
  pitchid convert flight.bbl pitch.mat                  in MATLAB: load pitch.mat; plot(t_s, q_rad_s)
  pitchid convert flight.bbl pitch.npy                  in Python: np.load('pitch.npy')['q_rad_s']

Exit status: 0 written; 2 the input could not be used.";

/// Converts.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { recording, table, axis, columns, time, flight, wanted, json } = arguments;
    let write: fn(&Recording, &mut Vec<u8>) -> Result<(), Error> =
        match table.extension().and_then(|end| end.to_str()) {
            Some("csv") => |found, out| found.write_csv(out),
            Some("parquet") => |found, out| found.write_parquet(out),
            Some("mat") => |found, out| found.write_matlab(out),
            Some("npy") => |found, out| found.write_numpy(out),
            _ => {
                let found = format!("{}: none of .csv, .parquet, .mat, .npy", table.display());
                return Err(Failure::new(found, "name the table with one of these ends"));
            }
        };
    let outputs = std::iter::once(table).chain(json).map(PathBuf::as_path);
    output::check(outputs, &[recording.as_path()])?;
    let vehicle = wanted.find()?;
    let mut columns = columns.clone();
    if let Some(vehicle) = &vehicle {
        vehicle.say();
        let beside = vehicle.columns_beside(&columns);
        columns.extend(beside);
    }
    let choice = axis.or(vehicle.and_then(|vehicle| vehicle.axis).filter(|axis| !axis.is_all()));
    let axis = choice.map(AxisChoice::single).transpose()?;
    let options = options_with(InputHold::default(), &columns);
    let mut bytes = Vec::new();
    input::say_what_is_large([recording.as_path()]);
    let progress = Progress::start("reading");
    // there is one for the one file
    let source = open(std::slice::from_ref(recording), &columns)?.swap_remove(0);
    let found = Readable::new(source, *flight, time.as_ref())?.recording(axis, false, &options)?;
    progress.say("writing the table".into());
    write(&found, &mut bytes)?;
    drop(progress);
    output::write_bytes(table, &bytes)?;
    output::print(&format!("table: {}\n", table.display()))?;
    let Some(path) = json else { return Ok(()) };
    let answer = serde_json::json!({
        "schema": "pitchid.table/1",
        "table": table.display().to_string(),
        "recording": of_recording(&found, axis),
    });
    output::write(path, &output::json(&answer)?)
}
