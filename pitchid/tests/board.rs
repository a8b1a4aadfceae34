//! `pitchid record` and `pitchid fly`, the real binary against a board on a TCP port whose line breaks.

#[cfg(target_os = "linux")]
#[path = "support/small_disk.rs"]
mod small_disk;
mod support;

use estimator_core::Telemetry;
use firmware::link::frame::{Header, encode, sign};
use firmware::link::signing::Key;
use messages::MessageData;
use messages::board::SETUP_SIGNING_DATA;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use support::{Board, Script};

fn pitchid(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
    command.current_dir(folder).args(arguments);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn answered(folder: &Path, arguments: &[&str]) -> String {
    let Output { status, stdout, stderr } = pitchid(folder, arguments).output().unwrap();
    assert_eq!(status.code(), Some(0), "{arguments:?}: {} {}", text(&stdout), text(&stderr));
    text(&stdout)
}

/// u, q, θ as bits, section and `supervised` of a row.
type Row = ([u32; 3], String, bool);

fn rows(file: &Path) -> Vec<Row> {
    let text = std::fs::read_to_string(file).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let bits = |i: usize| fields[i].parse::<f32>().unwrap().to_bits();
        ([bits(1), bits(2), bits(3)], fields[4].to_owned(), fields[5] == "1")
    };
    lines.map(row).collect()
}

fn row(telemetry: &Telemetry) -> Row {
    let sample = telemetry.sample.unwrap();
    let bits = [telemetry.u_rad, sample.q_rad_s, sample.theta_rad].map(f32::to_bits);
    (bits, telemetry.section.to_string(), telemetry.supervised)
}

/// The rows that a flight must have left: of the test alone.
fn flown(board: &Board) -> Vec<Row> {
    board.sent.lock().unwrap().cycles.iter().filter(|told| told.phase.runs()).map(row).collect()
}

/// Reads lines until one contains `wanted`; the rest stays unread.
fn wait_for(child: &mut Child, wanted: &str) -> BufReader<ChildStdout> {
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while !line.contains(wanted) {
        line.clear();
        assert!(lines.read_line(&mut line).unwrap() > 0, "no {wanted:?} came");
    }
    lines
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
fn a_whole_test_is_flown_over_a_line_that_breaks_and_nothing_that_arrived_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::boot(Script {
        breaks: vec![(900, 0), (2500, 40)],
        noise: vec![0xFD, 7, 1, 2, 3],
        ..Script::default()
    });
    let told = answered(
        folder.path(),
        &[
            "fly",
            &board.port,
            "--campaign",
            "4",
            "--amplitude",
            "0.015",
            "--seed",
            "5",
            "--set",
            "LMS_TAPS=64",
            "--out",
            "flight.csv",
            "--taps",
            "taps.json",
        ],
    );
    let found = rows(&folder.path().join("flight.csv"));
    let expected = flown(&board);
    assert_eq!(found.len(), expected.len(), "{told}");
    assert!(found == expected, "every cycle that arrived is in the recording, to the bit");
    assert!(found.len() > 6000, "{}", found.len());
    for wanted in [
        "line lost",
        "line open",
        "board: started",
        "board: finished with",
        "running",
        "; finished",
        "taps: 64, converged",
    ] {
        assert!(told.contains(wanted), "{wanted:?} in {told}");
    }
    let taps: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("taps.json")).unwrap()).unwrap();
    let values: Vec<f32> =
        taps["taps"].as_array().unwrap().iter().map(|w| w.as_f64().unwrap() as f32).collect();
    assert_eq!(values, board.sent.lock().unwrap().taps[..64]);
    assert_eq!((&taps["schema"], &taps["first_lag"]), (&"pitchid.taps/1".into(), &4.into()));
    let text = std::fs::read_to_string(folder.path().join("flight.csv")).unwrap();
    assert!(text.contains("# EXC_AMPL = 0.015\n") && text.contains("# finished with"), "{}", &text[..600]);
    assert!(text.contains("40 cycles did not arrive"));

    std::fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    let diagnosed = answered(folder.path(), &["diagnose", "flight.csv", "--model", "model.toml"]);
    assert!(diagnosed.contains("VAF"), "{diagnosed}");
    let identified = answered(folder.path(), &["identify", "flight.csv", "--taps", "taps.json"]);
    let line = |name: &str| {
        identified.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_default().to_owned()
    };
    assert!(line("LMS on board ").contains("64 taps"), "{identified}");
    assert!(line("LMS FIR ").contains("64 taps"), "the replay is set as the board was: {identified}");
}

#[test]
fn a_monitor_made_of_one_flight_is_given_to_the_board_and_speaks_in_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let short = ["--set", "TEST_SECTION=12", "--set", "TEST_LOOP=0.02", "--out"];
    let fly = |board: &Board, more: &[&str]| {
        answered(folder.path(), &[&["fly", board.port.as_str()], &short[..], more].concat())
    };
    fly(&Board::boot(Script::default()), &["first.csv"]);
    answered(folder.path(), &["identify", "first.csv", "--monitor-out", "craft.toml"]);
    let told = fly(&Board::boot(Script::default()), &["second.csv", "--monitor", "craft.toml"]);
    assert!(told.contains("board: monitor: as identified"), "{told}");
    let recording = std::fs::read_to_string(folder.path().join("second.csv")).unwrap();
    assert!(recording.contains("# monitor: as identified"));
    let replayed = answered(folder.path(), &["monitor", "second.csv", "--monitor", "craft.toml"]);
    assert!(replayed.contains("as identified") && !replayed.contains("changed"), "{replayed}");

    let board = Board::boot(Script::default());
    let spoilt = std::fs::read_to_string(folder.path().join("craft.toml")).unwrap();
    std::fs::write(folder.path().join("fast.toml"), spoilt.replace("step_s = 0.02", "step_s = 0.004"))
        .unwrap();
    let all = ["fly", &board.port, "--out", "f.csv", "--monitor", "fast.toml"];
    let refused = pitchid(folder.path(), &all).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("0.0040 s"), "{}", text(&refused.stderr));
}

const MODEL: &str = "[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\n\
                     mount_k_N_m = 3.8689\nmount_c_N_m_s = 0.02639\nmount_J_kg_m2 = 5e-4\n";

#[test]
fn everything_that_comes_is_recorded_until_ctrl_c_over_a_broken_line_and_a_reset() {
    let folder = tempfile::tempdir().unwrap();
    let script = Script {
        breaks: vec![(300, 25), (700, 0)],
        starts: Some(50),
        resets: Some(1000),
        ..Script::default()
    };
    let board = Board::boot(script);
    let mut child = pitchid(folder.path(), &["record", &board.port, "--out", "r.csv"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut rest = wait_for(&mut child, "line lost");
    while board.sent.lock().unwrap().cycles.len() < 1200 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let mut told = String::new();
    rest.read_to_string(&mut told).unwrap();
    assert!(told.contains("samples, 25 cycles did not arrive"), "{told}");
    let found = rows(&folder.path().join("r.csv"));
    let expected: Vec<Row> = board.sent.lock().unwrap().cycles.iter().map(row).collect();
    assert!(found.len() >= 1190 && found == expected[..found.len()], "{} of {}", found.len(), expected.len());
    let text = std::fs::read_to_string(folder.path().join("r.csv")).unwrap();
    assert!(text.contains("# the board's clock began anew") && text.contains("# started"));
    let times: Vec<f64> = text.lines().filter_map(|line| line.split(',').next()?.parse().ok()).collect();
    assert!(times.is_sorted_by(|a, b| a < b), "time runs on");
}

/// Rows until the file ends, perhaps in the middle of one.
fn rows_of_a_part(file: &Path) -> Vec<Row> {
    let text = std::fs::read_to_string(file).unwrap();
    let whole = &text[..=text.rfind('\n').unwrap()];
    std::fs::write(file.with_extension("whole"), whole).unwrap();
    rows(&file.with_extension("whole"))
}

#[test]
fn a_program_that_is_killed_leaves_what_came_beside_the_recording_before() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (command, cycles) in [("fly", 700), ("record", 400), ("record", 1000), ("fly", 3000)] {
        let board = Board::boot(Script { starts: (command == "record").then_some(20), ..Script::default() });
        std::fs::write(folder.join("r.csv"), "before").unwrap();
        let mut child = pitchid(folder, &[command, &board.port, "--out", "r.csv"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while board.sent.lock().unwrap().cycles.len() < cycles {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(std::fs::read_to_string(folder.join("r.csv")).unwrap(), "before");
        let found = rows_of_a_part(&folder.join("r.csv.part"));
        let sent: Vec<Row> = match command {
            "fly" => flown(&board),
            _ => board.sent.lock().unwrap().cycles.iter().map(row).collect(),
        };
        assert!(found.len() + 100 > cycles / 2, "{command}: {} of {cycles}", found.len());
        assert!(found == sent[..found.len()], "{command}: what came is there, to the bit");
        answered(folder, &["show", "r.csv.part"]);
        // and it is not written over
        let again = pitchid(folder, &[command, &board.port, "--out", "r.csv"]).output().unwrap();
        assert_eq!(again.status.code(), Some(2));
        assert!(text(&again.stderr).contains("rename or delete it"), "{}", text(&again.stderr));
        std::fs::remove_file(folder.join("r.csv.part")).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_ends_the_recording_with_what_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let board = Board::boot(Script { starts: Some(20), ..Script::default() });
    let script = format!(
        "echo before > disk/r.csv; \"$1\" record {} --out disk/r.csv > told; code=$?; cp disk/* .; exit $code",
        board.port
    );
    let Some((code, told)) = small_disk::on_a_small_disk(folder, 64, &script) else { return };
    assert_eq!(code, 2, "{told}");
    assert!(told.contains("r.csv.part: cannot be written") && told.contains("make room there"), "{told}");
    assert_eq!(std::fs::read_to_string(folder.join("r.csv")).unwrap(), "before\n");
    let found = rows_of_a_part(&folder.join("r.csv.part"));
    let sent: Vec<Row> = board.sent.lock().unwrap().cycles.iter().map(row).collect();
    assert!(found.len() > 300 && found == sent[..found.len()], "{} rows", found.len());
    answered(folder, &["show", "r.csv.part"]);
}

#[test]
fn ctrl_c_breaks_the_test_off_and_what_was_flown_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::boot(Script::default());
    let arguments = ["fly", &board.port, "--out", "f.csv", "--taps", "t.json"];
    let mut child = pitchid(folder.path(), &arguments).stdout(Stdio::piped()).spawn().unwrap();
    let mut rest = wait_for(&mut child, "I   running");
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let mut told = String::new();
    rest.read_to_string(&mut told).unwrap();
    assert!(told.contains("breaking off") && told.contains("aborted: operator's command"), "{told}");
    assert!(told.contains("; broken off"), "{told}");
    let found = rows(&folder.path().join("f.csv"));
    assert!(!found.is_empty() && found == flown(&board));
    assert!(folder.path().join("t.json").exists());
}

#[test]
fn a_reset_in_the_middle_is_told_and_what_was_flown_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::boot(Script { resets: Some(3000), ..Script::default() });
    let told = answered(folder.path(), &["fly", &board.port, "--out", "f.csv"]);
    assert!(told.contains("the board was reset"), "{told}");
    assert!(rows(&folder.path().join("f.csv")) == flown(&board));
}

#[test]
fn what_the_board_refuses_is_told_and_nothing_is_flown() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::boot(Script::default());
    let refused = |arguments: &[&str]| {
        let all = [&["fly", board.port.as_str(), "--out", "f.csv"], arguments].concat();
        let output = pitchid(folder.path(), &all).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
        text(&output.stderr)
    };
    assert!(refused(&["--amplitude", "0.5"]).contains("EXC_AMPL is 0.5 rad; set it within 0 to 0.03 rad"));
}

#[test]
fn a_port_that_is_not_there_and_a_word_that_is_none_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for port in ["tcp:127.0.0.1:1", "/dev/no-such-device"] {
        let output = pitchid(folder.path(), &["record", port, "--out", "r.csv"]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(port), "{}", text(&output.stderr));
    }
    assert!(!folder.path().join("r.csv").exists());
    let output = pitchid(folder.path(), &["fly", "tcp:nowhere", "--out", "r.csv"]).output().unwrap();
    assert!(text(&output.stderr).contains("tcp:HOST:PORT"));
}

#[test]
fn a_board_with_a_key_takes_what_is_signed_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let key = Key([0x5a; 32]);
    let setup = SETUP_SIGNING_DATA {
        target_system: 1,
        secret_key: key.0,
        initial_timestamp: 9,
        ..SETUP_SIGNING_DATA::default()
    };
    let mut first = encode(Header { sequence: 0, system: 255, component: 190 }, &setup);
    sign(&mut first, SETUP_SIGNING_DATA::EXTRA_CRC, &key, 1, 10);
    let board = Board::boot(Script { first: first.to_vec(), ..Script::default() });
    std::fs::write(folder.path().join("key"), "5a".repeat(32)).unwrap();
    let short = [
        "--set",
        "TEST_SECTION=1",
        "--set",
        "TEST_LOOP=1",
        "--set",
        "TEST_LEAD=1",
        "--set",
        "TEST_PAUSE=0.1",
    ];
    let told = answered(
        folder.path(),
        &[&["fly", board.port.as_str(), "--key", "key", "--out", "f.csv"], &short[..]].concat(),
    );
    assert!(told.contains("finished with"), "{told}");
}

#[test]
fn a_file_of_parameters_sets_the_board_and_the_command_line_goes_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let file =
        "# NAME VALUE\nEXC_AMPL 0.011\nTEST_SECTION 2\nTEST_LOOP 0.02\nLIM_THETA 0.12\nREL_THETA 0.1\n";
    std::fs::write(folder.path().join("test.param"), file).unwrap();
    let board = Board::boot(Script::default());
    let more = ["--parameters", "test.param", "--set", "TEST_SECTION=1", "--out", "f.csv"];
    answered(folder.path(), &[&["fly", board.port.as_str()], &more[..]].concat());
    let recording = std::fs::read_to_string(folder.path().join("f.csv")).unwrap();
    for note in ["# EXC_AMPL = 0.011", "# TEST_SECTION = 1\n", "# LIM_THETA = 0.12", "# REL_THETA = 0.1"] {
        assert!(recording.contains(note), "{note}");
    }
}
