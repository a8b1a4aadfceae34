//! `pitchid show`: what a log holds, before any fit.

pub mod content;
pub mod page;
pub mod words;

use crate::axes::Readable;
use crate::commands::reading::as_options;
use crate::failure::Failure;
use crate::logs::{AxisName, Source, TimeSpan, choose, open};
use crate::progress::Progress;
use crate::{input, output};
use clap::Args;
use content::{Shown, ShownRecording, of_flight, of_recording};
use flight_logs::axes::Axis;
use std::path::{Path, PathBuf};
use sysid::recording::{ColumnMap, ReadOptions};

/// Says what a flight log or a recording holds: whether it can serve, where something moves, what to set if not
///
/// For each axis: the channels that would be input, rate and angle, and why; the spans in which the input moves, with
/// the band that holds 80 % of its power; and where the log cannot serve, the parameters to set before the next flight.
/// Then the topics. Formats are told by content: PX4 ULog, ArduPilot DataFlash, Betaflight and INAV blackbox, MAVLink
/// tlog, CSV files of ulog2csv (given together, they are one log), and recordings.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Flight logs or recordings; - is standard input
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,

    /// Only this axis [default: all]
    #[arg(long, value_name = "AXIS")]
    axis: Option<AxisName>,

    /// Only this flight of a log that holds several, counted from 1 [default: all]
    #[arg(long, value_name = "N")]
    flight: Option<usize>,

    /// Only this part, in seconds of the file's own clock
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true)]
    time: Option<TimeSpan>,

    /// A column of a recording that has another name, or arithmetic over columns, as `pitchid diagnose` takes it:
    /// t_s=millis/1000, 'q_deg_s=-gyro_y'
    #[arg(long = "column", value_name = "NAME=EXPR")]
    columns: Vec<ColumnMap>,

    /// Write what is shown as JSON, with the fields of all topics; without a name, and for -, to standard output, which then
    /// carries nothing else
    #[arg(long, value_name = "OUT.json", num_args = 0..=1, default_missing_value = "-", value_parser = json_file)]
    json: Option<PathBuf>,

    /// Write a page with pictures: one HTML file that needs nothing else
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,

    /// Draw input, rate and angle over time, of the axis that moves most
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid show flight.ulg
  pitchid show blackbox.bbl --flight 2 --axis roll --report flight.html
  pitchid show flight.ulg --axis pitch --plot pitch.svg
  pitchid show rig.csv --column t_s=millis/1000 --column q_deg_s=gyro --column 'u_norm=(pwm-1500)/500'
  pitchid show 00000012.BIN --json | jq '.[0].axes[1].settings'

Exit status: 0 it was read, whatever it holds; 2 the input could not be used.";

/// The name behind `--json`: a log that stands there by mistake must not be overwritten.
fn json_file(name: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    if output::is_stdout(Some(&path)) || path.extension().is_some_and(|end| end == "json") {
        return Ok(path);
    }
    Err("a name that ends with .json, or -, belongs here; put --json behind the logs".to_owned())
}

/// A recording, by axis where it has columns of several.
fn of_table(table: &Readable, axis: Option<Axis>, columns: &[ColumnMap]) -> Result<Vec<Shown>, Failure> {
    let options = ReadOptions { columns: columns.to_vec(), ..ReadOptions::default() };
    let mut axes: Vec<Option<Axis>> = match axis {
        Some(_) => vec![axis],
        None => table.axes(&options).into_iter().map(Some).collect(),
    };
    if axes.is_empty() {
        axes.push(None);
    }
    let several = axes.len() > 1;
    let read = |axis| {
        let recording = table.recording(axis, several, &options)?;
        Ok(Shown::Recording(ShownRecording {
            options: as_options(columns),
            ..of_recording(&recording, axis)
        }))
    };
    axes.into_iter().map(read).collect()
}

/// Shows.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs: Vec<&Path> = arguments.logs.iter().map(PathBuf::as_path).collect();
    let outputs = [&arguments.json, &arguments.report, &arguments.plot];
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &inputs)?;
    input::say_what_is_large(inputs.iter().copied());
    let progress = Progress::start("reading");
    let shown = shown(arguments)?;
    drop(progress);
    output::print(&words::text(&shown))?;
    if let Some(path) = &arguments.json {
        output::write(path, &output::json(&shown)?)?;
    }
    if let Some(path) = &arguments.report {
        output::write(path, &page::page(&shown))?;
        output::print(&format!("\nreport: {}\n", path.display()))?;
    }
    if let Some(path) = &arguments.plot {
        let help = "pitchid show tells what is in the log; choose --axis or --time";
        let picture = page::plot(&shown).ok_or_else(|| Failure::new("there is no motion to draw", help))?;
        output::write(path, &picture)?;
        output::print(&format!("\npicture: {}\n", path.display()))?;
    }
    Ok(())
}

/// What the files hold.
pub fn shown(arguments: &Arguments) -> Result<Vec<Shown>, Failure> {
    let axes: Vec<Axis> = arguments.axis.map_or(Axis::ALL.to_vec(), |axis| vec![axis.into()]);
    let mut shown = Vec::new();
    for source in open(&arguments.logs, &arguments.columns)? {
        match source {
            Source::Recording(_) => {
                let table = Readable::new(source, arguments.flight, arguments.time.as_ref())?;
                shown.extend(of_table(&table, arguments.axis.map(Axis::from), &arguments.columns)?);
            }
            Source::Log(_) if !arguments.columns.is_empty() => {
                let help = "show proposes what of a flight log is input, rate and angle; pitchid diagnose takes other columns of it";
                return Err(Failure::new("--column is of recordings, and this is a flight log", help));
            }
            Source::Log(flights) => {
                let flights = match arguments.flight {
                    Some(_) => vec![choose(flights, arguments.flight)?],
                    None => flights,
                };
                for mut flight in flights {
                    flight.cut(arguments.time.as_ref())?;
                    shown.push(Shown::Flight(of_flight(&flight, &axes)));
                }
            }
        }
    }
    Ok(shown)
}
