//! A recording as a Parquet table or a MATLAB file.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sysid::recording::{ReadOptions, as_csv, parse};

fuzz_target!(|bytes: &[u8]| {
    let begins = [&b"PAR1"[..], b"MATLAB 5.0"].iter().any(|magic| bytes.starts_with(magic));
    if begins && let Ok(text) = as_csv("a", bytes.to_vec()) {
        let _ = parse("a", &text, &ReadOptions::default());
    }
});
