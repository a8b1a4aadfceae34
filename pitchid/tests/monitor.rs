//! `pitchid identify --monitor-out` and `pitchid monitor` through the real binary.

#[path = "support/command.rs"]
mod command;

use command::run;
use serde_json::Value;

#[test]
fn a_craft_that_is_the_same_is_silent_and_one_whose_gyro_has_an_offset_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let fly = |seed: &str, out: &str, more: &[&str]| {
        let plain = ["simulate", "--seed", seed, "--background", "clean", "--out", out];
        assert_eq!(run(folder, &[&plain, more].concat()).0, Some(0));
    };
    fly("1", "bench.csv", &[]);
    fly("2", "same.csv", &[]);
    fly("3", "offset.csv", &["--effect", "gyro_bias:b=0.05"]);
    let (status, out, err) = run(folder, &["identify", "bench.csv", "--monitor-out", "craft.toml"]);
    assert_eq!(status, Some(0), "{err}");
    assert!(out.contains("monitor:"), "{out}");

    let monitored = |recording: &str| -> Value {
        let (status, out, err) =
            run(folder, &["monitor", recording, "--monitor", "craft.toml", "--json", "-"]);
        assert_eq!(status, Some(0), "{err}");
        serde_json::from_str(&out).unwrap()
    };
    let events = |answer: &Value| answer["stretches"][0]["events"].as_array().unwrap().clone();
    let same = monitored("same.csv");
    assert!(events(&same).iter().all(|event| event["changes"].as_array().unwrap().is_empty()), "{same}");
    assert_eq!(events(&same).last().unwrap()["verdict"], "as identified");
    let offset = monitored("offset.csv");
    let events = events(&offset);
    let told = &events.last().unwrap()["changes"][0];
    assert_eq!(told["cause"], "gyro bias", "{offset}");
    let [low, high] = [0, 1].map(|i| told["ci95"][i].as_f64().unwrap());
    assert!(low < 0.05 && 0.05 < high && high - low < 0.03, "{told}");

    let (status, out, err) =
        run(folder, &["monitor", "offset.csv", "--monitor", "craft.toml", "--plot", "evidence.svg"]);
    assert_eq!(status, Some(0), "{err}");
    assert!(out.contains("changed: gyro bias +0.05"), "{out}");
    let picture = std::fs::read_to_string(folder.join("evidence.svg")).unwrap();
    assert!(picture.contains("<svg") && picture.contains("gyro bias"));
}

#[test]
fn what_is_no_monitor_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("craft.toml"), "[plant]\ninertia_kg_m2 = 1.0\n").unwrap();
    std::fs::write(folder.path().join("flight.csv"), "t_s,u_rad,q_rad_s\n").unwrap();
    let (status, _, err) = run(folder.path(), &["monitor", "flight.csv", "--monitor", "craft.toml"]);
    assert_eq!(status, Some(2));
    assert!(err.contains("craft.toml") && err.contains("--monitor-out"), "{err}");
}
