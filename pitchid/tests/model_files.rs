//! Model files that cannot be, and models that no simulation can follow, through the real binary.

#[path = "support/command.rs"]
mod command;

use command::{answered, refused};
use std::fs;
use std::path::Path;

const PLANT: &str =
    "[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\n";

/// A model with these lines behind its plant of five lines.
fn with(lines: &str) -> String {
    format!("{PLANT}{lines}")
}

/// A model with an effect, whose parameters begin in line 8.
fn effect(id: &str, parameters: &str) -> String {
    with(&format!("[[effect]]\nid = \"{id}\"\n{parameters}\n"))
}

/// The plant with one line another.
fn plant(from: &str, to: &str) -> String {
    assert!(PLANT.contains(from));
    PLANT.replace(from, to)
}

/// What a file says, and the line, the key, what was found and what is legal, as they are to be told.
fn wrong_files() -> Vec<(String, [&'static str; 4])> {
    let friction = |value: &str| effect("coulomb_friction", &format!("Mc = {value}"));
    let lag = |value: &str| effect("servo_lag", &format!("T = {value}"));
    let twice = "[[effect]]\nid = \"trim_offset\"\nM0 = 0.1\n[[effect]]\nid = \"trim_offset\"\nM0 = 0.2\n";
    vec![
        (
            plant("0.1705", "-0.1705"),
            ["2", "inertia_kg_m2", "found -0.1705", "a number above 0 and up to 1e12, in kg m²"],
        ),
        (plant("0.1705", "0"), ["2", "inertia_kg_m2", "found 0", "a number above 0"]),
        (plant("0.1705", "\"0.17 kg\""), ["2", "inertia_kg_m2", "found \"0.17 kg\"", "a number above 0"]),
        (plant("inertia_kg_m2 = 0.1705\n", ""), ["1", "inertia_kg_m2", "missing", "a number above 0"]),
        (plant("0.06", "-0.06"), ["3", "delay_s", "found -0.06", "a number from 0 to 10, in s"]),
        (plant("0.06", "1e300"), ["3", "delay_s", "found 1e300", "a number from 0 to 10, in s"]),
        (
            plant("-0.27", "nan"),
            ["4", "dM_dq_N_m_s", "found nan", "a number from -1e12 to 1e12, in N m s/rad"],
        ),
        (plant("23.0", "inf"), ["5", "dM_du_N_m", "found inf", "a number from -1e12 to 1e12"]),
        (plant("23.0", "[23.0]"), ["5", "dM_du_N_m", "found [23.0]", "a number from -1e12 to 1e12"]),
        (plant("dM_du_N_m", "dM_du"), ["5", "dM_du", "unknown key", "one of dM_du_N_m"]),
        (
            with("mount_k_N_m = 3.8\n"),
            ["6", "mount_k_N_m", "a mount with only mount_k_N_m", "all three or none"],
        ),
        (
            with("mount_k_N_m = 0.0\nmount_c_N_m_s = 0.1\nmount_J_kg_m2 = 1e-4\n"),
            ["6", "mount_k_N_m", "found 0.0", "a number above 0"],
        ),
        (with("[rol]\ninertia_kg_m2 = 1.0\n"), ["6", "rol", "unknown key", "one of roll"]),
        (friction("-0.1"), ["8", "Mc", "found -0.1", "a number from 0 to 1e12, in N m"]),
        (friction("1e300"), ["8", "Mc", "found 1e300", "a number from 0 to 1e12, in N m"]),
        (friction("nan"), ["8", "Mc", "found nan", "a number from 0 to 1e12, in N m"]),
        (friction("true"), ["8", "Mc", "found true", "a number from 0 to 1e12, in N m"]),
        (friction("0.1\nmc = 0.1"), ["9", "mc", "unknown parameter", "coulomb_friction with Mc"]),
        (
            effect("coulomb_friction", ""),
            ["7", "Mc", "coulomb_friction without Mc", "a number from 0 to 1e12, in N m"],
        ),
        (lag("0"), ["8", "T", "found 0", "a number from 1e-5 to 1e6, in s"]),
        (lag("-0.1"), ["8", "T", "found -0.1", "a number from 1e-5 to 1e6, in s"]),
        (lag("inf"), ["8", "T", "found inf", "a number from 1e-5 to 1e6, in s"]),
        (
            effect("servo_second_order", "f_hz = 4.0\nzeta = 1.0"),
            ["9", "zeta", "found 1.0", "a number from 0 to 0.999"],
        ),
        (
            effect("inertia_step", "delta = -1.0\nt_star = 5.0"),
            ["8", "delta", "found -1.0", "a number from -0.99 to 1000"],
        ),
        (effect("voltage_droop", "n = -1"), ["8", "n", "found -1", "a number from 0 to 100"]),
        (effect("friction", "Mc = 0.1"), ["7", "id", "unknown effect \"friction\"", "one of servo_lag"]),
        (with("[[effect]]\nMc = 0.1\n"), ["6", "id", "an effect without id", "add a line id"]),
        (
            with("[effect]\nid = \"trim_offset\"\nM0 = 0.1\n"),
            ["6", "effect", "found a section", "sections [[effect]]"],
        ),
        (with(twice), ["10", "id", "trim_offset a second time; the first is on line 6", "each effect once"]),
        (
            effect("unlisted", "shape = \"of_nothing\""),
            ["8", "shape", "unknown shape \"of_nothing\"", "one of of_q"],
        ),
        (
            with("[interval.dM_du_N_m]\nci95 = [25.0, 21.0]\n"),
            ["7", "ci95", "found [25.0, 21.0]", "[low, high], low first"],
        ),
        (
            with("[interval.Mc]\nci95 = [0.0, 0.2]\n"),
            ["6", "Mc", "an interval of something that is not in this file", "inertia_kg_m2"],
        ),
    ]
}

#[test]
fn wrong_model_files_are_refused_with_line_key_and_what_is_legal() {
    let folder = tempfile::tempdir().unwrap();
    let commands: [&[&str]; 2] =
        [&["simulate", "--model", "wrong.toml", "--out", "never.csv"], &["plan", "--model", "wrong.toml"]];
    for (k, (text, [line, key, found, legal])) in wrong_files().iter().enumerate() {
        fs::write(folder.path().join("wrong.toml"), text).unwrap();
        let message = refused(folder.path(), commands[k % commands.len()]);
        for part in [&format!("wrong.toml, line {line}, key {key}: {found}"), *legal] {
            assert!(message.contains(part), "{part} is not in {message}\n{text}");
        }
        assert!(!folder.path().join("never.csv").exists());
    }
}

#[test]
fn all_that_is_wrong_is_told_at_once_and_a_diagnosis_says_the_same() {
    let folder = tempfile::tempdir().unwrap();
    answered(folder.path(), &["simulate", "--seed", "3", "--out", "flight.csv"]);
    let text = effect("coulomb_friction", "Mc = -0.1").replace("0.1705", "1e300");
    fs::write(folder.path().join("wrong.toml"), text).unwrap();
    for command in ["diagnose", "identify"] {
        let message = refused(folder.path(), &[command, "flight.csv", "--model", "wrong.toml"]);
        assert!(message.contains("line 2, key inertia_kg_m2: found 1e300"), "{message}");
        assert!(message.contains("line 8, key Mc: found -0.1; expected a number from 0 to"), "{message}");
    }
}

/// What is said when `command` simulates a model that blows up; and that no sensor is blamed.
fn blown_up(folder: &Path, model: &str, command: &[&str]) -> String {
    fs::write(folder.join("wild.toml"), model).unwrap();
    let message = refused(folder, &[command, &["--model", "wild.toml"]].concat());
    assert!(message.contains("blows up") || message.contains("blew up"), "{message}");
    assert!(message.contains("step"), "{message}");
    for blamed in ["sensor", "gyro", "not finite", "the units of the columns"] {
        assert!(!message.contains(blamed), "{message}");
    }
    message
}

#[test]
fn a_simulation_that_blows_up_names_the_parameter_and_the_step() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    answered(folder, &["simulate", "--seed", "4", "--out", "later.csv"]);
    let drag = effect("quadratic_drag", "D = 1e9");
    let mode = effect("structural_mode", "omega = 20.0\nzeta = 0.01\ngain = 1e6");
    for (model, culprit) in [
        (&drag, "without quadratic_drag (D = 1000000000) it does not"),
        (&mode, "without structural_mode (gain = 1000000, omega = 20, zeta = 0.01) it does not"),
        (&plant("-0.27", "160.0"), "with another dM_dq_N_m_s than 160 it does not"),
        (&plant("23.0", "1e9"), "with another dM_du_N_m than 1000000000 it does not"),
    ] {
        let message = blown_up(folder, model, &["simulate", "--out", "never.csv"]);
        assert!(message.contains(culprit), "{message}");
        assert!(!folder.join("never.csv").exists());
    }
    assert!(blown_up(folder, &drag, &["plan", "--flights", "10"]).contains("quadratic_drag"));
    for (model, culprit) in [
        (&drag, "before its first step; with another quadratic_drag (D = 1e9) it does not"),
        (&mode, "with another structural_mode (omega = 20, zeta = 0.01, gain = 1e6) it does not"),
    ] {
        for command in [
            &["diagnose", "flight.csv"][..],
            &["identify", "flight.csv"],
            &["compare", "flight.csv", "later.csv"],
        ] {
            let message = blown_up(folder, model, command);
            assert!(message.contains(culprit), "{command:?}: {message}");
        }
    }
}
