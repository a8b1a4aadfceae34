//! Flight logs of autopilots, read into named channels with their times.
//!
//! What is read is told by content, never by the file's name: PX4 ULog ([`Format::ULog`]), ArduPilot DataFlash
//! ([`Format::DataFlash`], [`Format::DataFlashText`]), Betaflight and INAV blackbox ([`Format::Blackbox`]), MAVLink
//! telemetry ([`Format::Tlog`]) and the CSV files that `ulog2csv` writes ([`Format::Ulog2Csv`]).
//!
//! Numbers stay as logged, in the logger's units, but for the scale that the log itself gives them; what [`axes`] makes
//! of them is in SI units. Damaged bytes are skipped and counted in [`Log::notes`]; text stays out of the channels.
//!
//! The readers are our own but for MAVLink: `px4-ulog` 0.6.1 indexes unchecked in short messages and ends at the first
//! damaged byte, `blackbox-log` 0.4.3 refuses Betaflight outside 4.2 to 4.5 and INAV outside 5 to 8.

pub mod axes;
mod blackbox;
mod bytes;
mod damage;
mod dataflash;
mod error;
mod sniff;
mod tlog;
mod ulog;
mod ulog2csv;

use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use error::{Error, Place};
pub use sniff::{Format, sniff};

/// One flight log, or one of the several flights in a blackbox file.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// How it was written.
    pub format: Format,
    /// The craft or the board, as the log names it.
    pub vehicle: Option<String>,
    /// The flight stack and its version.
    pub firmware: Option<String>,
    /// Everything that has rows, in order of name and instance.
    pub topics: Vec<Topic>,
    /// Name and value at the start of the log, in order of the log; changes in flight are among the messages.
    pub parameters: Vec<(String, f64)>,
    /// What the log says of itself, in order of the log.
    pub info: Vec<(String, String)>,
    /// Time (s) and text: what the autopilot said, parameters that changed, stretches that were not logged.
    pub messages: Vec<(f64, String)>,
    /// What is damaged or was assumed, for people.
    pub notes: Vec<String>,
}

/// One kind of message from one source: its rows share their times.
#[derive(Clone, Debug, PartialEq)]
pub struct Topic {
    /// The logger's name: `vehicle_attitude`, `RATE`, `main`, `ATTITUDE`.
    pub name: String,
    /// Which of several sources of the same name, counted as the log does.
    pub instance: u8,
    /// Time of each row on the log's own clock, s: finite, but not checked for order.
    pub time_s: Vec<f64>,
    /// Numeric fields, each as long as `time_s`.
    pub fields: Vec<Field>,
}

/// One number of each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The logger's name; elements of arrays are `name[0]`, `name[1]`, ..., parts of nested types `outer.name`.
    pub name: String,
    /// The unit, where the log or its reader's contract tells.
    pub unit: Option<String>,
    /// As logged. NaN and infinities stand where the autopilot logged them, meaning "not set": leave those rows out.
    pub values: Vec<f64>,
}

impl Log {
    fn new(format: Format) -> Self {
        Self {
            format,
            vehicle: None,
            firmware: None,
            topics: Vec::new(),
            parameters: Vec::new(),
            info: Vec::new(),
            messages: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// The topic of this name and instance.
    #[must_use]
    pub fn topic(&self, name: &str, instance: u8) -> Option<&Topic> {
        self.topics.iter().find(|topic| topic.name == name && topic.instance == instance)
    }

    /// The value of a parameter at the start of the log.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(known, _)| known == name).map(|&(_, value)| value)
    }

    /// What the log says of itself under `key`.
    #[must_use]
    pub fn info(&self, key: &str) -> Option<&str> {
        self.info.iter().find(|(known, _)| known == key).map(|(_, text)| text.as_str())
    }

    /// First and last time (s) of all rows; `None` where there are none. Topics of a few rows may have been stamped by another
    /// clock, or before the rest, and count where there is no other.
    #[must_use]
    pub fn span_s(&self) -> Option<[f64; 2]> {
        const FEW: usize = 10;
        let any = self.topics.iter().any(|topic| topic.time_s.len() >= FEW);
        let topics = self.topics.iter().filter(|topic| !any || topic.time_s.len() >= FEW);
        let times = topics.flat_map(|topic| &topic.time_s);
        let [from, to] =
            times.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &t| [low.min(t), high.max(t)]);
        (from <= to).then_some([from, to])
    }

    /// Leaves of the rows those with `from` ≤ time < `to` (s), and of the topics those that then have rows.
    pub fn keep(&mut self, from: f64, to: f64) {
        for topic in &mut self.topics {
            let kept: Vec<bool> = topic.time_s.iter().map(|t| (from..to).contains(t)).collect();
            let retain = |values: &mut Vec<f64>| {
                let mut kept = kept.iter();
                values.retain(|_| kept.next().is_some_and(|&keep| keep));
            };
            topic.fields.iter_mut().for_each(|field| retain(&mut field.values));
            retain(&mut topic.time_s);
        }
        self.topics.retain(|topic| !topic.time_s.is_empty());
    }

    /// Keeps the first value of a parameter; a later, different one becomes a message.
    fn set_parameter(&mut self, time_s: f64, name: &str, value: f64, known: &mut Known) {
        match known.get_mut(name) {
            None => {
                known.insert(name.to_owned(), value);
                self.parameters.push((name.to_owned(), value));
            }
            Some(last) if last.to_bits() != value.to_bits() => {
                self.messages.push((time_s, format!("parameter {name} changed from {last} to {value}")));
                *last = value;
            }
            Some(_) => {}
        }
    }

    /// Drops what has no rows, sorts, and notes clocks that run backwards.
    fn finish(mut self) -> Self {
        self.topics.retain(|topic| !topic.time_s.is_empty());
        self.topics.sort_by(|a, b| (&a.name, a.instance).cmp(&(&b.name, b.instance)));
        for topic in &self.topics {
            let back = topic.time_s.windows(2).filter(|pair| pair[1] < pair[0]).count();
            if back > 0 {
                self.notes.push(format!("{}: time runs backwards at {back} of its rows", topic.title()));
            }
        }
        self
    }
}

/// The last value of each parameter.
type Known = std::collections::HashMap<String, f64>;

impl Topic {
    fn new(name: impl Into<String>, instance: u8) -> Self {
        Self { name: name.into(), instance, time_s: Vec::new(), fields: Vec::new() }
    }

    /// The values of a field.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// Name, and instance where it is not the first: `sensor_gyro`, `sensor_gyro.1`.
    #[must_use]
    pub fn title(&self) -> String {
        if self.instance == 0 { self.name.clone() } else { format!("{}.{}", self.name, self.instance) }
    }

    /// Rows per second: one over the median of the positive time steps (of long logs, of evenly chosen ones); `None` below three
    /// rows.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        rate_hz(&self.time_s)
    }
}

/// Steps at most that tell the rate of a topic.
const MOST_STEPS: usize = 1 << 16;

/// One over the median of the positive steps between `times` (s), of long logs of evenly chosen ones; `None` where there are not
/// two.
fn rate_hz(times: &[f64]) -> Option<f64> {
    let pairs = times.windows(2).step_by(1 + times.len() / MOST_STEPS);
    let mut steps: Vec<f64> = pairs.map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.len() < 2 {
        return None;
    }
    let middle = steps.len() / 2;
    Some(1.0 / *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

impl Field {
    fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: None, values: Vec::new() }
    }
}

/// Reads flight logs: each file for itself, but CSV files of `ulog2csv` together as one log.
///
/// In memory are 8 bytes for each number and, but for ULog, the file; no size that a file claims is believed.
///
/// # Errors
/// A file that cannot be read, is empty, is larger than [`LARGEST`], is none of the known formats, or holds nothing that can
/// be read.
pub fn read(paths: &[&Path]) -> Result<Vec<Log>, Error> {
    let sources = paths.iter().map(|path| {
        let name = path.display().to_string();
        let file = match path.is_dir() {
            true => Err(std::io::ErrorKind::IsADirectory.into()),
            false => File::open(path),
        };
        Ok((name.clone(), file.map_err(|error| Error::from_io(&name, &error))?))
    });
    read_from(sources.collect::<Result<Vec<_>, Error>>()?)
}

/// The same of open files, pipes or devices, each with the name that stands for it in messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(sources: Vec<(String, impl Read)>) -> Result<Vec<Log>, Error> {
    let mut logs = Vec::new();
    let mut tables = Vec::new();
    for (name, source) in sources {
        let unreadable = |error: std::io::Error| Error::from_io(&name, &error);
        let mut source = Bounded { source, left: LARGEST };
        let mut bytes = Vec::new();
        (&mut source).take(sniff::REACH as u64).read_to_end(&mut bytes).map_err(unreadable)?;
        let format = sniff(&bytes);
        if format == Some(Format::ULog) {
            let log = ulog::read(&mut bytes.as_slice().chain(source));
            logs.push(log.map_err(|error| error.in_file(&name))?);
            continue;
        }
        if format.is_none() {
            return Err(sniff::unknown(&bytes).in_file(&name));
        }
        source.read_to_end(&mut bytes).map_err(unreadable)?;
        match format {
            Some(Format::Ulog2Csv) => tables.push((name, bytes)),
            _ => logs.extend(parse(&name, &bytes)?),
        }
    }
    if !tables.is_empty() {
        logs.push(ulog2csv::parse(&tables)?);
    }
    Ok(logs)
}

/// Largest log that is read, bytes: four times the largest that autopilots are known to write. A device may have no end.
pub const LARGEST: u64 = 1 << 31;

/// A source that fails once more than it may has come from it.
struct Bounded<R> {
    source: R,
    left: u64,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.source.read(buffer)?;
        self.left = self.left.checked_sub(count as u64).ok_or(std::io::ErrorKind::FileTooLarge)?;
        Ok(count)
    }
}

/// Reads one flight log from its bytes; `name` stands for the file in messages, and names the topic of a CSV file.
///
/// # Errors
/// As [`read`].
pub fn parse(name: &str, bytes: &[u8]) -> Result<Vec<Log>, Error> {
    let read = match sniff(bytes) {
        Some(Format::ULog) => ulog::read(&mut &bytes[..]).map(|log| vec![log]),
        Some(Format::DataFlash) => dataflash::parse(bytes).map(|log| vec![log]),
        Some(Format::DataFlashText) => dataflash::parse_text(bytes).map(|log| vec![log]),
        Some(Format::Blackbox) => blackbox::parse(bytes),
        Some(Format::Tlog) => tlog::parse(bytes).map(|log| vec![log]),
        Some(Format::Ulog2Csv) => {
            return ulog2csv::parse(&[(name.to_owned(), bytes.to_vec())]).map(|log| vec![log]);
        }
        None => Err(sniff::unknown(bytes)),
    };
    read.map_err(|error| error.in_file(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_without_an_end_is_refused() {
        let mut bounded = Bounded { source: std::io::repeat(0), left: 1 << 20 };
        let error = bounded.read_to_end(&mut Vec::new()).unwrap_err();
        let error = Error::from_io("log.bin", &error).to_string();
        assert!(error.contains("log.bin: more than 2048 MiB"), "{error}");
        let mut whole = Bounded { source: &[1, 2, 3][..], left: 3 };
        assert_eq!(whole.read_to_end(&mut Vec::new()).unwrap(), 3);
    }
}
