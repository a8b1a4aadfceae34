//! Flight logs through the real binary: what is shown of them, which are refused and with which advice, which are
//! diagnosed.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// File, how it was written, and by which firmware.
const LOGS: [(&str, &str, &str); 15] = [
    ("ardupilot/copter_3.1_mechanical_fail.log", "ArduPilot DataFlash, text", "ArduCopter V3.1"),
    ("ardupilot/copter_3.6_quad_short.bin", "ArduPilot DataFlash", "firmware unknown"),
    ("ardupilot/copter_4.6.2_head_80k.bin", "ArduPilot DataFlash", "ArduCopter V4.6.2"),
    ("ardupilot/sitl_copter_4.7_quad.BIN", "ArduPilot DataFlash", "ArduCopter V4.7.0"),
    ("betaflight/LOG00037.BFL", "blackbox", "Betaflight 4.2.0"),
    ("betaflight/bf4.2.11_bench_500Hz.bbl", "blackbox", "Betaflight 4.2.11"),
    ("betaflight/bf4.2.9_roma_f5_3flights.bbl", "blackbox", "Betaflight 4.2.9"),
    ("betaflight/btfl_002.bbl", "blackbox", "Betaflight 4.2.8"),
    ("mavlink/copter_2016_flight.tlog", "MAVLink tlog", "firmware unknown"),
    ("px4/quad_2016_auavx21_flight.ulg", "PX4 ULog", "PX4 (fd483321a5)"),
    ("px4/quad_2017_fmuv4pro_appended.ulg", "PX4 ULog", "PX4 v1.6.0"),
    ("px4/quad_v1.15.1_fmuv6c_brownout.ulg", "PX4 ULog", "PX4 v1.15.1"),
    ("px4/s250_flight3_log1.ulg", "PX4 ULog", "PX4 (15673da50c)"),
    ("px4/sitl_quad_2024_events.ulg", "PX4 ULog", "PX4 v1.15.0"),
    ("px4/vtol_v1.11.2_cubeorange_servo_bench.ulg", "PX4 ULog", "PX4 v1.11.2"),
];

/// The logs beside this checkout; `None`, with a word, where there are none.
fn logs() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/logs");
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(std::env::var_os("CI").is_none(), "no logs at {}", folder.display());
    println!("skipped: no flight logs beside this checkout");
    None
}

/// Status, standard output, standard error.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(!err.contains("panicked"), "{err}");
    (output.status.code(), out, err)
}

fn answered(folder: &Path, arguments: &[&str]) -> String {
    let (status, out, err) = run(folder, arguments);
    assert_eq!(status, Some(0), "{arguments:?}: {err}");
    out
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let (status, out, err) = run(folder, arguments);
    assert_eq!((status, out.as_str()), (Some(2), ""), "{arguments:?}");
    // the message may be wrapped where it is drawn
    err.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_log_is_shown() {
    let Some(folder) = logs() else { return };
    for (name, format, firmware) in LOGS {
        let text = answered(&folder, &["show", name]);
        let head: String =
            text.split("\n\n").next().unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(head.contains(format) && head.contains(firmware), "{name}: {head}");
        for part in ["ROLL: can", "PITCH: can", "YAW: can", "Topics"] {
            assert!(text.contains(part), "{name}: no {part} in {text}");
        }
    }
    let tables = ["sensor_combined", "actuator_controls"].map(|t| format!("px4/zmr250_2016_flips_{t}_0.csv"));
    let text = answered(&folder, &["show", &tables[0], &tables[1], "--axis", "pitch"]);
    assert!(text.contains("actuator_controls_0.control[1]") && text.contains("ulog2csv"), "{text}");
    assert!(!text.contains("ROLL"), "{text}");
}

#[test]
fn what_is_shown_can_be_read_by_a_machine() {
    let Some(folder) = logs() else { return };
    let arguments = ["show", "betaflight/bf4.2.9_roma_f5_3flights.bbl", "--json", "--axis", "roll"];
    let all: Value = serde_json::from_str(&answered(&folder, &arguments)).unwrap();
    assert_eq!(all.as_array().unwrap().len(), 3);
    let second = answered(&folder, &[&arguments[..], &["--flight", "2"]].concat());
    let second: Value = serde_json::from_str(&second).unwrap();
    assert_eq!(second[0], all[1]);
    let axis = &second[0]["axes"][0];
    assert_eq!((&axis["axis"], &axis["can_serve"]), (&"roll".into(), &true.into()));
    assert_eq!(axis["channels"][1]["source"], "main.gyroADC[0]");
    let span = &axis["excitation"][0];
    assert!(span["band_rad_s"][0].as_f64().unwrap() < span["band_rad_s"][1].as_f64().unwrap(), "{span}");
    let refusal = refused(&folder, &["show", arguments[1], "--flight", "4"]);
    assert!(refusal.contains("no flight 4"), "{refusal}");
}

#[test]
fn recordings_are_shown_too() {
    let folder = tempfile::tempdir().unwrap();
    let rows = (0..500).map(|k| {
        let t = 0.02 * f64::from(k);
        format!("{t:.2},{},{},{}\n", 0.1 * (3.0 * t).sin(), (3.0 * t).cos(), if k < 250 { "I" } else { "IV" })
    });
    let table = "t_s,u_norm,q_rad_s,section\n".to_owned() + &rows.collect::<String>();
    std::fs::write(folder.path().join("flight.csv"), &table).unwrap();
    let text = answered(folder.path(), &["show", "flight.csv"]);
    for part in ["500 rows at 50.0 Hz", "u_norm, q_rad_s", "moves: 0.0 to 9.0 s", "IV"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let part = answered(folder.path(), &["show", "flight.csv", "--time", "2..4"]);
    assert!(part.contains("100 rows") && part.contains("next: pitchid diagnose flight.csv"), "{part}");
    let refusal = refused(folder.path(), &["diagnose", "flight.csv", "--axis", "roll"]);
    assert!(refusal.contains("u_roll_norm"), "{refusal}");
    let table = table.replacen("u_norm,q_rad_s", "u_yaw_norm,r_rad_s", 1);
    std::fs::write(folder.path().join("yaw.csv"), table).unwrap();
    let text = answered(folder.path(), &["show", "yaw.csv"]);
    assert!(
        text.contains("recording, yaw") && text.contains("next: pitchid diagnose yaw.csv --axis yaw"),
        "{text}"
    );
    std::fs::write(folder.path().join("broken.ulg"), b"ULog\x01\x12\x35\x01").unwrap();
    assert!(refused(folder.path(), &["show", "broken.ulg"]).contains("broken.ulg"));
    assert!(refused(folder.path(), &["show", "no.ulg"]).contains("no such file"));
}

#[test]
fn what_cannot_serve_is_refused_with_the_parameter_to_set() {
    let Some(folder) = logs() else { return };
    for (name, parts) in [
        ("ardupilot/copter_3.1_mechanical_fail.log", ["no angular rate of pitch", "LOG_BITMASK = 263999"]),
        ("ardupilot/copter_3.6_quad_short.bin", ["at 9.9 Hz", "LOG_BITMASK = 438271"]),
        ("ardupilot/copter_4.6.2_head_80k.bin", ["at 9.7 Hz", "LOG_BITMASK = "]),
        ("ardupilot/sitl_copter_4.7_quad.BIN", ["at 10.0 Hz", "LOG_BITMASK = "]),
        ("mavlink/copter_2016_flight.tlog", ["no input of pitch", "log that the autopilot keeps"]),
        ("px4/quad_2017_fmuv4pro_appended.ulg", ["at 9.8 Hz", "SDLOG_PROFILE = 9"]),
        ("px4/quad_v1.9_fmuv3_motor_failure.ulg", ["at 9.6 Hz", "SDLOG_PROFILE = 9"]),
        ("px4/s250_flight3_log1.ulg", ["no input of pitch", "SDLOG_PROFILE = 9"]),
        ("px4/sitl_quad_2024_events.ulg", ["at rest", "pitchid show"]),
        ("px4/vtol_v1.11.2_cubeorange_servo_bench.ulg", ["at rest", "pitchid show"]),
    ] {
        for command in ["diagnose", "identify"] {
            let refusal = refused(&folder, &[command, name]);
            for part in parts {
                assert!(refusal.contains(part), "{name}: no {part} in {refusal}");
            }
        }
    }
    let bench = "betaflight/bf4.2.11_bench_500Hz.bbl";
    assert!(refused(&folder, &["diagnose", bench]).contains("--flight N"));
    assert!(refused(&folder, &["diagnose", bench, "--flight", "1"]).contains("too short"));
    let late = refused(&folder, &["diagnose", "betaflight/LOG00037.BFL", "--time", "5..9"]);
    assert!(late.contains("from 452.2"), "{late}");
    let unknown = refused(&folder, &["diagnose", "betaflight/LOG00037.BFL", "--column", "q_rad_s=main.gyro"]);
    assert!(unknown.contains("main.gyroADC[0]") || unknown.contains("and"), "{unknown}");
}

#[test]
fn real_flights_are_diagnosed_humbly() {
    let Some(folder) = logs() else { return };
    for (name, time) in [
        ("px4/quad_v1.15.1_fmuv6c_brownout.ulg", "170..185"),
        ("betaflight/LOG00037.BFL", "452..470"),
        ("betaflight/btfl_002.bbl", "30..50"),
    ] {
        let text = answered(&folder, &["diagnose", name, "--time", time, "--json", "-"]);
        let answer: Value = serde_json::from_str(&text).unwrap();
        println!("{name}: {} - {}", answer["verdict"], answer["summary"]);
        assert_ne!(
            answer["verdict"], "named",
            "{name}: nothing is known to be missing: {}",
            answer["summary"]
        );
        let notes = answer["notes"].to_string();
        assert!(notes.contains("unit inertia") && notes.contains("the loop is closed"), "{name}: {notes}");
    }
}

#[test]
fn a_log_of_the_controller_alone_is_told_so() {
    let Some(folder) = logs() else { return };
    let bench = "betaflight/bf4.2.11_bench_500Hz.bbl";
    let text = answered(&folder, &["diagnose", bench, "--flight", "2", "--axis", "roll", "--json", "-"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(answer["verdict"], "not_excited");
    assert!(answer["summary"].as_str().unwrap().contains("controller's answer"), "{}", answer["summary"]);
}

#[test]
fn a_flight_compared_with_itself_has_not_lost_its_rotors() {
    let Some(folder) = logs() else { return };
    let log = "betaflight/btfl_002.bbl";
    let text =
        answered(&folder, &["compare", log, log, "--time", "60..105", "--time", "105..150", "--json", "-"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    for axis in answer["axes"].as_array().unwrap() {
        for change in axis["changes"].as_array().unwrap() {
            let of_the_craft = change["quantity"] != "background";
            assert!(!of_the_craft || change["verdict"] != "changed", "{}: {change}", axis["axis"]);
        }
    }
}

#[test]
fn channels_are_worked_out_of_several() {
    let Some(folder) = logs() else { return };
    let betaflight = |columns: &[&str]| {
        let mut arguments =
            vec!["identify", "betaflight/LOG00037.BFL", "--axis", "roll", "--time", "452..470"];
        columns.iter().for_each(|column| arguments.extend(["--column", column]));
        arguments.extend(["--json", "-"]);
        run(&folder, &arguments)
    };
    let gain = |columns: &[&str]| {
        let (status, out, err) = betaflight(columns);
        assert_eq!(status, Some(0), "{err}");
        let answer: Value = serde_json::from_str(&out).unwrap();
        let parameters = answer["parameters"].as_array().unwrap().clone();
        let gain = parameters.iter().find(|p| p["name"] == "dM_du").unwrap_or_else(|| panic!("{out}"));
        gain["value"].as_f64().unwrap()
    };
    let plain = gain(&[]);
    let asked = "u_norm=(main.axisP[0]+main.axisI[0]+main.axisD[0]+main.axisF[0])/1000";
    let same = gain(&["q_rad_s=-main.gyroADC[0]*2/-2", asked]);
    let halved = gain(&["u_norm=input+`input`"]);
    assert!(
        (same / plain - 1.0).abs() < 0.02 && (halved / plain - 0.5).abs() < 0.02,
        "{plain} {same} {halved}"
    );
    let (status, _, err) = betaflight(&["u_norm=main.motor[0]-main.motr[1]"]);
    let err = err.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(status == Some(2) && err.contains("no channel main.motr[1]"), "{err}");
    assert!(err.contains("there are main.motor[1], "), "{err}");
}
