//! What comes from pipes and devices, and what goes to standard output: the real binary.

#[path = "support/command.rs"]
mod command;

use assert_cmd::Command;
use command::{answered, refused};
use serde_json::Value;
use std::path::Path;

fn pitchid(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
    command.current_dir(folder).args(arguments);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A short test with a concealed effect.
fn flown(folder: &Path) -> Vec<u8> {
    answered(folder, &["simulate", "--campaign", "4", "--seed", "3", "--out", "flight.csv"]);
    std::fs::read(folder.join("flight.csv")).unwrap()
}

/// What a command answers that reads this from standard input.
fn piped(folder: &Path, arguments: &[&str], bytes: &[u8]) -> String {
    let output = pitchid(folder, arguments).write_stdin(bytes).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn standard_input_is_read_as_the_file_would_be() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, bytes) = (folder.path(), flown(folder.path()));
    answered(folder, &["convert", "flight.csv", "flight.parquet"]);
    let parquet = std::fs::read(folder.join("flight.parquet")).unwrap();
    let named = |answer: &str| answer.replace("flight.csv", "standard input");
    let of_file = named(&answered(folder, &["identify", "flight.csv", "--json", "-"]));
    assert_eq!(piped(folder, &["identify", "-", "--json", "-"], &bytes), of_file);
    assert_eq!(piped(folder, &["identify", "-", "--json", "-"], &parquet), of_file, "told by content");
    let shown = piped(folder, &["show", "-"], &bytes);
    assert!(
        shown.starts_with("standard input: recording") && shown.contains("next: pitchid diagnose -"),
        "{shown}"
    );
    piped(folder, &["convert", "-", "again.csv"], &bytes);
    answered(folder, &["convert", "flight.csv", "once.csv"]);
    assert_eq!(
        std::fs::read(folder.join("again.csv")).unwrap(),
        std::fs::read(folder.join("once.csv")).unwrap()
    );
    let compared = piped(folder, &["compare", "-", "once.csv", "--json", "-"], &bytes);
    let compared: Value = serde_json::from_str(&compared).unwrap();
    assert_eq!(compared["before"], "standard input");
    for twice in [&["compare", "-", "-"][..], &["diagnose", "-", "-"], &["show", "-", "flight.csv", "-"]] {
        assert!(refused(folder, twice).contains("only once"), "{twice:?}");
    }
    let output = pitchid(folder, &["show", "-"]).write_stdin("t_s,u_rad,q_rad_s\n0,0,x\n").output().unwrap();
    assert!(text(&output.stderr).contains("standard input, line 2"), "{}", text(&output.stderr));
}

#[cfg(target_os = "linux")]
#[test]
fn a_device_without_an_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    flown(folder);
    assert!(refused(folder, &["identify", "/dev/zero"]).contains("more than 1024 MiB"));
    for options in [&["--model", "/dev/zero"][..], &["--taps", "/dev/zero"]] {
        let refusal = refused(folder, &[&["identify", "flight.csv"], options].concat());
        assert!(refusal.contains("more than"), "{options:?}: {refusal}");
    }
    assert!(
        refused(folder, &["monitor", "flight.csv", "--monitor", "/dev/zero"]).contains("more than 16 MiB")
    );
}

#[test]
fn quiet_leaves_what_was_asked_for_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    flown(folder);
    assert_eq!(answered(folder, &["show", "flight.csv", "--quiet"]), "");
    assert_eq!(answered(folder, &["-q", "identify", "flight.csv", "--out-model", "fitted.toml"]), "");
    assert!(folder.join("fitted.toml").is_file());
    let shown = answered(folder, &["show", "flight.csv", "--quiet", "--json"]);
    assert_eq!(serde_json::from_str::<Value>(&shown).unwrap()[0]["name"], "flight.csv");
    answered(folder, &["show", "flight.csv", "-q", "--json", "shown.json"]);
    assert_eq!(std::fs::read_to_string(folder.join("shown.json")).unwrap(), shown);
    assert!(refused(folder, &["show", "nowhere.csv", "--quiet"]).contains("no such file"));
    // a log in the place of the answer's name stays whole
    let before = std::fs::read(folder.join("flight.csv")).unwrap();
    let output = pitchid(folder, &["show", "--json", "flight.csv", "flight.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(std::fs::read(folder.join("flight.csv")).unwrap(), before);
}
