//! What is asked of a flight log, whatever its format.

use flight_logs::axes::{Axis, propose};
use flight_logs::{Format, parse, sniff};

/// Reads `bytes` where they are a log of `format`, and asks which channels serve each axis.
pub fn read(format: Format, name: &str, bytes: &[u8]) {
    if sniff(bytes) != Some(format) {
        return;
    }
    match parse(name, bytes) {
        Ok(logs) => {
            for topic in logs.iter().flat_map(|log| &log.topics) {
                assert!(!topic.time_s.is_empty() && topic.time_s.iter().all(|time_s| time_s.is_finite()));
                assert!(topic.fields.iter().all(|field| field.values.len() == topic.time_s.len()));
            }
            for log in &logs {
                for axis in Axis::ALL {
                    let _ = propose(log, axis).serves();
                }
            }
        }
        Err(error) => assert!(!error.found.is_empty() && !error.advice.is_empty()),
    }
}
