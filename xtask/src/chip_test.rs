//! Everything that needs the emulated chip, in one run.

use std::env;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::budget::{self, Ledger};
use crate::image::{self, root};
use crate::{Outcome, no_panic};

/// Builds, counts, flies, proves; the last line says how much passed.
pub fn run() -> Outcome {
    if Command::new("qemu-system-arm").arg("--version").output().is_err() {
        return Err("no emulator; install qemu-system-arm".into());
    }
    let control = image::build(Some(no_panic::CONTROL))?;
    let images = image::build(None)?;
    println!("budgets:");
    let mut ledger = Ledger::open()?;
    let statics = budget::sizes(&images.flight, &mut ledger)?;
    budget::count(&images.selftest, &mut ledger)?;
    let flown = fly([&images.flight, &control.flight], statics, &mut ledger)?;
    ledger.close()?;
    no_panic::check()?;
    // the budgets, the proof and its control
    println!("chip-test: {} passed", flown + 3);
    Ok(())
}

fn cargo(arguments: &[&str]) -> Command {
    let mut cargo = Command::new(env::var("CARGO").unwrap_or_else(|_| "cargo".into()));
    cargo.current_dir(root()).args(arguments);
    cargo
}

/// Builds the command that flies the image from the ground.
fn command() -> Outcome<PathBuf> {
    let status = cargo(&["build", "--quiet", "--workspace", "--release", "--bin", "pitchid"]).status();
    if !status.is_ok_and(|status| status.success()) {
        return Err("pitchid does not build".into());
    }
    Ok(image::target().join("release/pitchid"))
}

/// Runs the tests that fly the image; returns how many passed.
fn fly([flight, control]: [&Path; 2], statics: u64, ledger: &mut Ledger) -> Outcome<usize> {
    let command = command()?;
    // as the README's command builds them, so that nothing is built twice
    let mut cargo = cargo(&["test", "--workspace", "--release"]);
    cargo.args(["--test", "chip", "--", "--nocapture", "--test-threads=2"]);
    cargo.env("PITCHID_FLIGHT_IMAGE", flight).env("PITCHID_FAULTS_IMAGE", control);
    cargo.env("PITCHID_COMMAND", command).stdout(Stdio::piped());
    let mut child = cargo.spawn().map_err(|error| format!("cargo cannot be run ({error})"))?;
    let mut passed = 0;
    for line in
        child.stdout.take().into_iter().flat_map(|pipe| BufReader::new(pipe).lines().map_while(Result::ok))
    {
        println!("{line}");
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            [.., "budget", "stack_bytes", value] => {
                let stack = value.parse().unwrap_or(u64::MAX);
                ledger.enter("stack_bytes", stack);
                ledger.enter("ram_bytes", statics.saturating_add(stack));
            }
            ["test", "result:", "ok.", count, "passed;", ..] => passed += count.parse().unwrap_or(0),
            _ => {}
        }
    }
    let status = child.wait().map_err(|error| format!("cargo test: {error}"))?;
    if status.success() && passed > 0 { Ok(passed) } else { Err("a test on the emulated chip failed".into()) }
}
