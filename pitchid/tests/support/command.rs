//! The real binary.

use assert_cmd::Command;
use std::path::Path;

/// Runs `pitchid` in `folder`: status, standard output, standard error without its line breaks.
pub fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(!err.contains("panicked"), "{err}");
    (output.status.code(), out, err.split_whitespace().collect::<Vec<_>>().join(" "))
}
