//! A model file of any axis; what is read can be written, and reads back.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sysid::catalogue::model_file::parse_model;

fuzz_target!(|text: &str| {
    for axis in [None, Some("roll")] {
        match parse_model("m.toml", text, axis) {
            Ok(model) => {
                let written = model.to_toml().expect("what was read can be written");
                assert_eq!(parse_model("m.toml", &written, None).expect("and read back"), model);
            }
            Err(error) => assert!(!error.advice.is_empty() && error.to_string().lines().count() < 30),
        }
    }
});
