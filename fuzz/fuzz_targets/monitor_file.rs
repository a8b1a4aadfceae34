//! A monitor's file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sysid::monitor::parse_monitor;

fuzz_target!(|text: &str| {
    if let Ok((model, step)) = parse_monitor(text) {
        assert!(model.check().is_ok() && step > 0.0);
    }
});
