//! Flight logs as recordings: what a file is, which flight of it is meant, and its channels on one clock.

pub mod align;
pub mod excitation;
mod foreign;
pub mod recording;

use crate::failure::Failure;
use crate::input;
use clap::ValueEnum;
use flight_logs::axes::Axis;
use flight_logs::{Format, Log, sniff};
use std::io::{Chain, Cursor, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use sysid::files;
use sysid::recording::{ColumnMap, SectionSpec, as_csv};

/// Bytes of a file that tell what it is.
const HEAD: u64 = 1 << 16;

/// One of the axes, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AxisName {
    /// About the axis that points forward
    Roll,
    /// About the axis that points to the right
    Pitch,
    /// About the axis that points down
    Yaw,
}

impl From<AxisName> for Axis {
    fn from(name: AxisName) -> Self {
        match name {
            AxisName::Roll => Self::Roll,
            AxisName::Pitch => Self::Pitch,
            AxisName::Yaw => Self::Yaw,
        }
    }
}

/// One `--time FROM..TO`: FROM ≤ t < TO, seconds of the log's own clock; either end may be left out.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSpan {
    /// First time, s.
    pub from: f64,
    /// Time before which it ends, s.
    pub to: f64,
}

impl FromStr for TimeSpan {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let span = format!("all={text}").parse::<SectionSpec>();
        let span = span.map_err(|_| "write FROM..TO in seconds, e.g. 31.5..62".to_owned())?;
        if span.from >= span.to {
            return Err("FROM has to be before TO".to_owned());
        }
        Ok(Self { from: span.from, to: span.to })
    }
}

/// One of the flights in a log.
pub struct Flight {
    /// The file, with the flight's number where there are several.
    pub name: String,
    /// The files that make the log.
    pub paths: Vec<PathBuf>,
    /// Counted from 1.
    pub number: usize,
    /// Whether the log holds others.
    pub one_of_several: bool,
    /// What was logged.
    pub log: Log,
}

/// A recording as CSV. It stays in memory, as a pipe can be read only once.
pub struct Table {
    /// What messages call it.
    pub name: String,
    /// The whole text.
    pub text: Vec<u8>,
}

/// What a file turned out to be.
pub enum Source {
    /// A table in the project's format, or what is to be refused as such.
    Recording(Table),
    /// The flights in a log.
    Log(Vec<Flight>),
}

/// Tells recordings from logs, and reads the logs; CSV files of `ulog2csv` are one log.
///
/// A map to `t_s` says that a CSV file is a recording.
pub fn open(paths: &[PathBuf], columns: &[ColumnMap]) -> Result<Vec<Source>, Failure> {
    input::once(paths.iter().map(PathBuf::as_path))?;
    let mut sources = Vec::new();
    let mut tables: Vec<(&Path, Begun)> = Vec::new();
    for path in paths {
        let name = input::name_of(path);
        let mut rest = input::open(path)?;
        let mut head = Vec::new();
        let read = (&mut rest).take(HEAD).read_to_end(&mut head);
        read.map_err(|error| sysid::error::Error::from_io(&name, &error))?;
        let format = format_of(&head, columns);
        let whole = Cursor::new(head).chain(rest);
        match format {
            None => {
                if let Some(refusal) = foreign::refusal(&name, whole.get_ref().0.get_ref()) {
                    return Err(refusal);
                }
                let bytes = files::read_from(&name, whole, files::LARGEST_RECORDING)?;
                let text = as_csv(&name, bytes)?;
                sources.push(Source::Recording(Table { name, text }));
            }
            Some(Format::Ulog2Csv) => tables.push((path, whole)),
            Some(_) => sources.push(Source::Log(flights(vec![(path, whole)])?)),
        }
    }
    if !tables.is_empty() {
        sources.push(Source::Log(flights(tables)?));
    }
    Ok(sources)
}

/// A file of which the first bytes have been read, from its start.
type Begun = Chain<Cursor<Vec<u8>>, Box<dyn Read>>;

/// The format of a flight log that begins like this; `None` of anything else.
fn format_of(head: &[u8], columns: &[ColumnMap]) -> Option<Format> {
    let format = sniff(head)?;
    let first = head.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let timed = first.split(|&byte| byte == b',').any(|cell| cell.trim_ascii() == b"t_s");
    let mapped = columns.iter().any(|map| map.target == "t_s");
    (format != Format::Ulog2Csv || !(timed || mapped)).then_some(format)
}

fn flights(files: Vec<(&Path, Begun)>) -> Result<Vec<Flight>, Failure> {
    let paths: Vec<PathBuf> = files.iter().map(|(path, _)| path.to_path_buf()).collect();
    let names: Vec<String> = paths.iter().map(|path| input::name_of(path)).collect();
    let logs =
        flight_logs::read_from(files.into_iter().map(|(path, file)| (input::name_of(path), file)).collect())?;
    let (name, several) = (names.join(" and "), logs.len() > 1);
    let flights = logs.into_iter().zip(1..).map(|(log, number)| Flight {
        name: if several { format!("{name}, flight {number}") } else { name.clone() },
        paths: paths.clone(),
        number,
        one_of_several: several,
        log,
    });
    Ok(flights.collect())
}

/// The one flight that is meant; `number` counts from 1.
pub fn choose(mut flights: Vec<Flight>, number: Option<usize>) -> Result<Flight, Failure> {
    let listed: Vec<String> = flights.iter().map(described).collect();
    let file = flights.first().map(Flight::files).unwrap_or_default();
    let choice = match number {
        None if flights.len() == 1 => 0,
        None => {
            let found = format!("{file}: {} flights in it: {}", flights.len(), listed.join(", "));
            return Err(Failure::new(found, "choose one with --flight N"));
        }
        Some(number) if (1..=flights.len()).contains(&number) => number - 1,
        Some(number) => {
            let found = format!("{file}: no flight {number}; there are {}", listed.join(", "));
            return Err(Failure::new(found, "choose one of these with --flight N"));
        }
    };
    Ok(flights.swap_remove(choice))
}

/// A path as an argument of a shell.
pub fn quoted(path: &Path) -> String {
    let name = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+,:@%=\\".contains(c);
    if name.chars().all(plain) { name } else { format!("'{}'", name.replace('\'', "'\\''")) }
}

impl Flight {
    /// Its files as arguments of a command.
    pub fn files(&self) -> String {
        self.paths.iter().map(|path| quoted(path)).collect::<Vec<String>>().join(" ")
    }

    /// Leaves of the log what lies in `span`.
    pub fn cut(&mut self, span: Option<&TimeSpan>) -> Result<(), Failure> {
        let (Some(TimeSpan { from, to }), Some([first, last])) = (span, self.log.span_s()) else {
            return Ok(());
        };
        self.log.keep(*from, *to);
        if self.log.topics.is_empty() {
            let found = format!("{}: nothing is logged in --time {from}..{to}", self.name);
            return Err(Failure::new(found, format!("its clock runs from {first:.3} to {last:.3} s")));
        }
        Ok(())
    }
}

/// Refuses, for a recording, options that are for flight logs alone: name, and whether it was given.
pub fn refuse_options<const N: usize>(name: &str, options: [(&str, bool); N]) -> Result<(), Failure> {
    let Some((option, _)) = options.into_iter().find(|(_, given)| *given) else { return Ok(()) };
    let found = format!("{name}: {option} is for flight logs, this is none");
    let help = "choose parts of a recording with --section NAME=FROM..TO, its columns with --column";
    Err(Failure::new(found, help))
}

fn described(flight: &Flight) -> String {
    let length = flight.log.span_s().map_or(0.0, |[from, to]| to - from);
    format!("{} ({length:.1} s)", flight.number)
}

/// The format as people call it.
pub fn format_name(format: Format) -> &'static str {
    match format {
        Format::ULog => "PX4 ULog",
        Format::DataFlash => "ArduPilot DataFlash",
        Format::DataFlashText => "ArduPilot DataFlash, text",
        Format::Blackbox => "blackbox",
        Format::Tlog => "MAVLink tlog",
        Format::Ulog2Csv => "PX4 ULog, CSV files of ulog2csv",
        _ => "flight log",
    }
}
