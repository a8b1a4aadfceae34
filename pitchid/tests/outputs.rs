//! What happens to outputs when a disk is full, a folder takes no files, a pipe closes, a name is taken, or the program is killed.
#![cfg(unix)]

#[path = "support/command.rs"]
mod command;
#[cfg(target_os = "linux")]
#[path = "support/small_disk.rs"]
mod small_disk;

use command::{answered, refused};
#[cfg(target_os = "linux")]
use small_disk::on_a_small_disk;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

fn pitchid(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
    command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_and_a_place_that_takes_no_files_are_told_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    let full = refused(folder, &["simulate", "--out", "/dev/full"]);
    assert!(full.contains("/dev/full: cannot be written") && full.contains("make room"), "{full}");
    // found before the work: the recording is not even looked for
    for option in ["--json", "--report", "--plot", "--out-model"] {
        let told = refused(folder, &["diagnose", "no_such.csv", option, "/proc/answer"]);
        assert!(told.contains("/proc/answer: cannot be written"), "{option}: {told}");
        assert!(told.contains("a folder that you may write to"), "{option}: {told}");
    }
    assert!(
        !fs::read_dir(folder).unwrap().any(|entry| entry
            .unwrap()
            .path()
            .to_string_lossy()
            .contains(".pitchid-"))
    );
}

#[test]
fn an_output_that_is_an_input_by_another_name_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    let before = fs::read(folder.join("flight.csv")).unwrap();
    fs::hard_link(folder.join("flight.csv"), folder.join("hard.csv")).unwrap();
    std::os::unix::fs::symlink("flight.csv", folder.join("soft.csv")).unwrap();
    for name in ["flight.csv", "hard.csv", "soft.csv", "./flight.csv"] {
        let told = refused(folder, &["convert", "flight.csv", name]);
        assert!(told.contains("would overwrite an input"), "{name}: {told}");
    }
    answered(folder, &["show", "flight.csv", "--json", "one.json"]);
    fs::hard_link(folder.join("one.json"), folder.join("other.json")).unwrap();
    let told = refused(folder, &["show", "flight.csv", "--json", "one.json", "--report", "other.json"]);
    assert!(told.contains("would overwrite another output"), "{told}");
    assert_eq!(fs::read(folder.join("flight.csv")).unwrap(), before);
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    answered(folder.path(), &["simulate", "--seed", "3", "--out", "flight.csv"]);
    let mut child =
        pitchid(folder.path(), &["simulate", "--out", "-"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(!first.is_empty());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// Kills a command that writes `outputs` again and again, after times drawn by a seed; every output is then what it was, or what
/// the command writes when it is let.
fn killed(folder: &Path, arguments: &[&str], outputs: &[&str], times: u64, longest_ms: u64) {
    let old = b"what stood there before";
    assert!(pitchid(folder, arguments).status().unwrap().success());
    let whole: Vec<Vec<u8>> = outputs.iter().map(|name| fs::read(folder.join(name)).unwrap()).collect();
    let mut state = 11_u64;
    for _ in 0..times {
        outputs.iter().for_each(|name| fs::write(folder.join(name), old).unwrap());
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut child = pitchid(folder, arguments).spawn().unwrap();
        std::thread::sleep(Duration::from_millis((state >> 33) % longest_ms));
        child.kill().unwrap();
        child.wait().unwrap();
        for (name, whole) in outputs.iter().zip(&whole) {
            let found = fs::read(folder.join(name)).unwrap();
            assert!(
                found == old || found == *whole,
                "{name} is neither what it was nor whole: {} bytes",
                found.len()
            );
        }
    }
}

#[test]
fn what_was_on_the_disk_stays_whole_when_the_program_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    killed(
        folder,
        &["simulate", "--seed", "3", "--out", "flight.csv", "--truth", "truth.json"],
        &["flight.csv", "truth.json"],
        40,
        400,
    );
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    killed(folder, &["show", "flight.csv", "--json", "show.json"], &["show.json"], 20, 100);
    killed(folder, &["convert", "flight.csv", "table.parquet"], &["table.parquet"], 20, 200);
    let diagnosis =
        ["diagnose", "flight.csv", "--json", "d.json", "--report", "d.html", "--out-model", "d.toml"];
    killed(folder, &diagnosis, &["d.json", "d.html", "d.toml"], 10, 4000);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_keeps_what_it_held() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    for command in [
        "simulate --seed 4 --out disk/out.csv",
        "convert flight.csv disk/out.csv",
        "diagnose flight.csv --report disk/out.csv",
        "prove --cases 1 --out disk/proof",
    ] {
        // room for what is there, and for no answer
        let script = format!(
            "echo before > disk/out.csv; \"$1\" {command} > told; code=$?; cp disk/out.csv after; ls -A disk > left; exit $code"
        );
        let Some((code, told)) = on_a_small_disk(folder, 24, &script) else { return };
        assert_eq!(code, 2, "{command}: {told}");
        assert!(told.contains("cannot be written") && told.contains("make room there"), "{command}: {told}");
        assert_eq!(fs::read_to_string(folder.join("after")).unwrap(), "before\n", "{command}");
        let left = fs::read_to_string(folder.join("left")).unwrap();
        assert!(
            left.split_whitespace().all(|name| ["out.csv", "proof"].contains(&name)),
            "{command} left {left}"
        );
    }
}

#[test]
fn a_proof_that_is_killed_goes_on_to_the_same_results() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let prove = |out: &str, further: &[&str]| {
        let mut arguments = vec!["prove", "--cases", "3", "--seed", "5", "--jobs", "1", "--out", out];
        arguments.extend(further);
        pitchid(folder, &arguments)
    };
    assert!(prove("whole", &[]).status().unwrap().success());
    for (seed, times) in [(1_u64, 2), (2, 3)] {
        let out = format!("killed-{seed}");
        let mut state = seed;
        for time in 0..times {
            let further: &[&str] = if time == 0 { &[] } else { &["--resume"] };
            let mut child = prove(&out, further).spawn().unwrap();
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            std::thread::sleep(Duration::from_millis((state >> 33) % 6000));
            child.kill().unwrap();
            child.wait().unwrap();
            assert!(!folder.join(&out).join("table.md").exists(), "no table before all cases are counted");
        }
        assert!(prove(&out, &["--resume"]).status().unwrap().success());
        for name in ["seals.txt", "results.json", "table.md", "cases/0002/answer.json"] {
            let [whole, resumed] =
                ["whole", &out].map(|proof| fs::read(folder.join(proof).join(name)).unwrap());
            assert!(whole == resumed, "{name} after {times} kills");
        }
    }
}
