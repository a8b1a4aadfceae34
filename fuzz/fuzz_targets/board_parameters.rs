//! A file of the board's parameters.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(all) = experiment::parameters::parse(text) {
        assert!(!all.is_empty() && all.iter().all(|(name, value)| name.len() <= 16 && value.is_finite()));
    }
});
