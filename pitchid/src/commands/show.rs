//! `pitchid show`: what a log holds, before any fit.

mod content;
mod page;
mod words;

use crate::axes::Readable;
use crate::failure::Failure;
use crate::logs::{AxisName, Source, TimeSpan, choose, open};
use crate::output;
use clap::Args;
use content::{Shown, of_flight, of_recording};
use flight_logs::axes::Axis;
use std::path::{Path, PathBuf};
use sysid::recording::ReadOptions;

/// Says what a flight log or a recording holds: whether it can serve, where something moves, what to set if not
///
/// For each axis: the channels that would be input, rate and angle, and why; the spans in which the input moves, with
/// the band that holds 80 % of its power; and where the log cannot serve, the parameters to set before the next flight.
/// Then the topics. Formats are told by content: PX4 ULog, ArduPilot DataFlash, Betaflight and INAV blackbox, MAVLink
/// tlog, CSV files of ulog2csv (given together, they are one log), and recordings.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Flight logs or recordings
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

    /// Print JSON instead, with the fields of all topics
    #[arg(long)]
    json: bool,

    /// Write a page with pictures: one HTML file that needs nothing else
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid show flight.ulg
  pitchid show blackbox.bbl --flight 2 --axis roll --report flight.html
  pitchid show 00000012.BIN --json | jq '.[0].axes[1].settings'

Exit status: 0 it was read, whatever it holds; 2 the input could not be used.";

/// A recording, by axis where it has columns of several.
fn of_table(table: &Readable, axis: Option<Axis>) -> Result<Vec<Shown>, Failure> {
    let mut axes: Vec<Option<Axis>> = match axis {
        Some(_) => vec![axis],
        None => table.axes().into_iter().map(Some).collect(),
    };
    if axes.is_empty() {
        axes.push(None);
    }
    let read = |axis| {
        let recording = table.recording(axis, &ReadOptions::default())?;
        Ok(Shown::Recording(of_recording(&recording, axis)))
    };
    axes.into_iter().map(read).collect()
}

/// Shows.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs: Vec<&Path> = arguments.logs.iter().map(PathBuf::as_path).collect();
    output::check(arguments.report.as_deref(), &inputs)?;
    let axes: Vec<Axis> = arguments.axis.map_or(Axis::ALL.to_vec(), |axis| vec![axis.into()]);
    let mut shown = Vec::new();
    for source in open(&arguments.logs, &[])? {
        match source {
            Source::Recording(_) => {
                let table = Readable::new(source, arguments.flight, arguments.time.as_ref())?;
                shown.extend(of_table(&table, arguments.axis.map(Axis::from))?);
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
    let text = if arguments.json { output::json(&shown)? } else { words::text(&shown) };
    let on_stdout = output::is_stdout(arguments.report.as_deref());
    if !on_stdout {
        output::print(&text)?;
    }
    match &arguments.report {
        Some(path) => {
            output::write(path, &page::page(&shown))?;
            if on_stdout || arguments.json {
                Ok(())
            } else {
                output::print(&format!("\nreport: {}\n", path.display()))
            }
        }
        None => Ok(()),
    }
}
