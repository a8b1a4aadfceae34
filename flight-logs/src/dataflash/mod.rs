//! ArduPilot DataFlash, binary and text.
//!
//! Binary: every message starts with a3 95 and its type; `FMT` messages (type 128) give each type its length, name,
//! format characters and columns; `FMTU`, `UNIT` and `MULT` name the units and the column that tells instances apart.
//! Source: ArduPilot, libraries/AP_Logger/LogStructure.h. Text: a message per line, values after commas, scaled.

mod collect;
mod formats;

use crate::bytes::text;
use crate::damage::Damage;
use crate::{Error, Format, Log, Place};
use collect::Collector;
use formats::Definition;

/// First bytes of every message.
pub(crate) const HEAD: [u8; 2] = [0xa3, 0x95];
/// First bytes of a message that defines another: type 128.
pub(crate) const HEAD_OF_FORMAT: [u8; 3] = [0xa3, 0x95, FMT];
const FMT: u8 = 128;
/// Of a message that defines another: head, type, then type u8, length u8, name 4, format 16, columns 64 characters.
const FMT_LENGTH: usize = 89;

/// Reads a binary log.
pub(crate) fn parse(bytes: &[u8]) -> Result<Log, Error> {
    let mut collector = Collector::new(Format::DataFlash);
    let mut damage = Damage::default();
    let mut at = 0;
    while at < bytes.len() {
        let length = length_at(bytes, at, &collector);
        match length.and_then(|length| bytes.get(at + 3..at + length)) {
            Some(body) => {
                let kind = bytes[at + 2];
                if kind == FMT {
                    define(body, &mut collector);
                }
                collector.binary(kind, body);
                at += body.len() + 3;
            }
            None => {
                let next = (at + 1..bytes.len()).find(|&from| length_at(bytes, from, &collector).is_some());
                let next = next.unwrap_or(bytes.len());
                damage.skip(at, next - at);
                at = next;
            }
        }
    }
    let mut log = collector.finish().ok_or_else(|| {
        Error::new("no message can be read", "check that the file is whole: it may be cut off at its start")
            .at(Place::Offset(0))
            .expecting("FMT messages (a3 95 80), and messages of the types they define")
    })?;
    log.notes.extend(damage.note());
    Ok(log)
}

/// The length of the message at `at`, if one of a known type starts there.
fn length_at(bytes: &[u8], at: usize, collector: &Collector) -> Option<usize> {
    let [first, second, kind] = crate::bytes::array(bytes, at)?;
    if [first, second] != HEAD {
        return None;
    }
    match kind {
        FMT => Some(FMT_LENGTH),
        _ => collector.definition(kind).map(|definition| definition.length),
    }
}

fn define(body: &[u8], collector: &mut Collector) {
    let part = |from: usize, to: usize| text(body.get(from..to).unwrap_or_default());
    let (Some(&kind), Some(&length)) = (body.first(), body.get(1)) else { return };
    let definition = Definition::new(&part(2, 6), usize::from(length), &part(6, 22), &part(22, 86));
    collector.define(kind, definition);
}

/// Reads a text log.
pub(crate) fn parse_text(bytes: &[u8]) -> Result<Log, Error> {
    let mut collector = Collector::new(Format::DataFlashText);
    let mut bad = Vec::new();
    let mut started = false;
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        let Some((name, rest)) = line.split_once(',') else {
            // What comes before the first definition is a greeting.
            if started && !line.is_empty() {
                bad.push(number + 1);
            }
            continue;
        };
        let (name, rest) = (name.trim(), rest.trim());
        if name == "FMT" {
            let parts: Vec<&str> = rest.splitn(5, ',').map(str::trim).collect();
            let [kind, length, name, format, columns] = parts[..] else {
                bad.push(number + 1);
                continue;
            };
            if let (Ok(kind), Ok(length)) = (kind.parse::<u8>(), length.parse::<usize>()) {
                collector.define(kind, Definition::in_text(name, length, format, columns));
                started = true;
            }
        }
        if started && !collector.line(name, rest) {
            bad.push(number + 1);
        }
    }
    let mut log = collector.finish().ok_or_else(|| {
        Error::new("no line can be read", "check that the file is whole")
            .expecting("FMT lines, and the messages they define")
    })?;
    if let Some(first) = bad.first() {
        log.notes.push(format!("{} bad lines, the first is line {first}: skipped", bad.len()));
    }
    Ok(log)
}
