//! Tables that once stopped the program, and whole ones: kept with what the fuzzing begins from.

use std::path::Path;
use sysid::recording::{ReadOptions, read};

#[test]
fn tables_are_read_or_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/table");
    let mut read_whole = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let whole = path.file_stem().is_some_and(|name| name == "whole");
        match read(&path, &ReadOptions::default()) {
            Ok(recording) => assert!(recording.t.len() > 30 || !whole),
            Err(error) => assert!(!whole, "{error}"),
        }
        read_whole += usize::from(whole);
    }
    assert_eq!(read_whole, 2);
}
