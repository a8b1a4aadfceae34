//! Tells what a file is by its bytes.

use crate::bytes::find;
use crate::{Error, dataflash, tlog, ulog};

/// How a flight log was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// PX4, binary (`.ulg`).
    ULog,
    /// ArduPilot, binary (`.bin`).
    DataFlash,
    /// ArduPilot, text (`.log`).
    DataFlashText,
    /// Betaflight and INAV (`.bbl`, `.bfl`).
    Blackbox,
    /// MAVLink packets with times, by a ground station (`.tlog`).
    Tlog,
    /// A topic of a PX4 log, as CSV.
    Ulog2Csv,
}

/// How much of a file may go by before its format shows: logs start in the middle, or after a greeting.
pub(crate) const REACH: usize = 1 << 16;

/// The format of these bytes, if it is one that [`parse`](crate::parse) reads.
#[must_use]
pub fn sniff(bytes: &[u8]) -> Option<Format> {
    let head = bytes.get(..REACH).unwrap_or(bytes);
    if bytes.starts_with(&ulog::MAGIC) {
        return Some(Format::ULog);
    }
    if find(head, crate::blackbox::START).is_some() {
        return Some(Format::Blackbox);
    }
    if bytes.starts_with(&dataflash::HEAD) || find(head, &dataflash::HEAD_OF_FORMAT).is_some() {
        return Some(Format::DataFlash);
    }
    let mut lines = head.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    if lines.any(|line| line.starts_with(b"FMT, 128,") || line.starts_with(b"FMT,128,")) {
        return Some(Format::DataFlashText);
    }
    let first = head.split(|&byte| byte == b'\n').next().unwrap_or_default();
    if first.split(|&byte| byte == b',').any(|cell| cell.trim_ascii() == b"timestamp") {
        return Some(Format::Ulog2Csv);
    }
    tlog::recognised(head).then_some(Format::Tlog)
}

/// Why these bytes cannot be read.
pub(crate) fn unknown(bytes: &[u8]) -> Error {
    if bytes.is_empty() {
        return Error::new("the file is empty", "check that the logger has written it");
    }
    let start: Vec<String> = bytes.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    Error::new(
        format!("no known flight log: it starts with the bytes {}", start.join(" ")),
        "name the log as the autopilot wrote it, unpacked; other loggers' data have to be made a CSV recording",
    )
    .expecting(
        "PX4 ULog, ArduPilot DataFlash, Betaflight or INAV blackbox, MAVLink tlog, or ulog2csv's CSV files",
    )
}
