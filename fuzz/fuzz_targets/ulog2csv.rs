//! A topic of a PX4 log as CSV.
#![no_main]

mod log;

use flight_logs::Format;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| log::read(Format::Ulog2Csv, "log_sensor_combined_0.csv", bytes));
