//! Betaflight and INAV blackbox: the flight data recorder by N. Sherlock, data version 2.
//!
//! Each flight starts with header lines (`H name:value`), then come frames: `I` (whole) and `P` (differences from
//! predictions) for the main loop, `S` (slow), `G` and `H` (GPS and its home), `E` (events). A frame is taken where
//! another follows it; after damage, `P` frames wait for the next `I`. Source: "Blackbox Internals" of the Betaflight
//! documentation, <https://betaflight.com/docs/development/Blackbox-Internals>.

mod encoding;
mod frames;
mod header;

use crate::bytes::find;
use crate::{Error, Log};

/// What every flight starts with.
pub(crate) const START: &[u8] = b"H Product:Blackbox";

/// Reads all flights of a file; those of which nothing can be read are told in the notes of the first that can.
pub(crate) fn parse(bytes: &[u8]) -> Result<Vec<Log>, Error> {
    let mut starts = Vec::new();
    let mut from = 0;
    while let Some(found) = bytes.get(from..).and_then(|rest| find(rest, START)) {
        starts.push(from + found);
        from += found + START.len();
    }
    let ends = starts.iter().skip(1).copied().chain([bytes.len()]);
    let mut logs = Vec::new();
    let mut lost = Vec::new();
    for (start, end) in starts.iter().copied().zip(ends) {
        match frames::flight(bytes, start, end) {
            Ok(log) => logs.push(log),
            Err(error) => lost.push(error),
        }
    }
    match (logs.first_mut(), lost.first()) {
        (Some(first), _) => {
            first
                .notes
                .extend(lost.iter().map(|error| format!("another flight of this file: {}", error.found)));
            Ok(logs)
        }
        (None, Some(error)) => Err(error.clone()),
        (None, None) => Err(crate::sniff::unknown(bytes)),
    }
}
