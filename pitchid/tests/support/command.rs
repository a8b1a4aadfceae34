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

/// Runs what must succeed, and returns what it printed.
#[allow(dead_code)] // not every test file needs it
pub fn answered(folder: &Path, arguments: &[&str]) -> String {
    let (status, out, err) = run(folder, arguments);
    assert_eq!(status, Some(0), "{arguments:?}: {err}");
    out
}

/// Runs what must be refused without an answer, and returns the message.
#[allow(dead_code)] // not every test file needs it
pub fn refused(folder: &Path, arguments: &[&str]) -> String {
    let (status, out, err) = run(folder, arguments);
    assert_eq!((status, out.as_str()), (Some(2), ""), "{arguments:?}");
    err
}
