//! A PX4 log.
#![no_main]

mod log;

use flight_logs::Format;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| log::read(Format::ULog, "log.ulg", bytes));
