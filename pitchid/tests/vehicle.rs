//! The vehicle's file, the doctor, and exports, through the real binary.

#[path = "support/command.rs"]
mod command;

use command::{answered, refused, run};
use serde_json::Value;
use std::path::Path;

/// A test whose rate is logged in degrees per second under another name, with a loop that it calls `hold`.
fn logged(folder: &Path) {
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    let text = std::fs::read_to_string(folder.join("flight.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let columns = [place("t_s"), place("u_rad"), place("q_rad_s"), place("section")];
    let mut logged = "t_s,u_rad,gyro,section\n".to_owned();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let [t, u, q, section] = columns.map(|column| cells[column]);
        let degrees = q.parse::<f64>().unwrap().to_degrees();
        logged += &format!("{t},{u},{degrees},{}\n", if section == "IV" { "hold" } else { section });
    }
    std::fs::write(folder.join("logged.csv"), logged).unwrap();
}

#[test]
fn what_names_the_columns_is_handed_to_the_next_command() {
    let folder = tempfile::tempdir().unwrap();
    logged(folder.path());
    let option = "--column 'q_rad_s=gyro*0.01745";
    for command in ["show", "doctor"] {
        assert!(
            refused_or_wrong(folder.path(), command).contains("gyro"),
            "{command}: nothing says what it is"
        );
        let told = answered(folder.path(), &[command, "logged.csv", "--column", "q_rad_s=gyro*pi/180"]);
        let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(told.contains(&format!("pitchid diagnose logged.csv {option}")), "{command}: {told}");
    }
}

/// What `command` says of the file without more.
fn refused_or_wrong(folder: &Path, command: &str) -> String {
    let (_, out, err) = run(folder, &[command, "logged.csv"]);
    out + &err
}

#[test]
fn a_vehicle_is_described_once_for_all_its_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let (root, inner) = (folder.path(), folder.path().join("monday"));
    std::fs::create_dir(&inner).unwrap();
    logged(&inner);
    assert!(refused(&inner, &["identify", "logged.csv"]).contains("gyro"), "nothing says what it is");
    let file = "inertia_kg_m2 = 0.17\n[columns]\nq_rad_s = \"gyro*pi/180\"\n[sections]\nIV = \"hold\"\n[limits]\ninput = 0.001\n";
    std::fs::write(root.join("pitchid.toml"), file).unwrap();
    let (status, out, err) = run(&inner, &["identify", "logged.csv", "--json", "-", "--report", "r.html"]);
    assert_eq!(status, Some(0), "{err}");
    assert!(err.contains("from ../pitchid.toml: inertia 0.17 kg m², 1 column, 1 section, 1 limit"), "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["held_out"].as_array().unwrap().iter().filter(|label| *label == "IV").count(), 1);
    let gain = answer["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "dM_du").unwrap();
    assert_eq!(gain["unit"], "N m/rad", "the inertia is known");
    let notes = answer["notes"].to_string();
    assert!(notes.contains("the vehicle's limit of ±0.001 rad at"), "{notes}");
    assert!(
        std::fs::read_to_string(inner.join("r.html")).unwrap().contains("../pitchid.toml"),
        "to repeat it"
    );
    // what stands on the command line goes first
    let (_, _, err) = run(&inner, &["identify", "logged.csv", "--column", "q_rad_s=nowhere"]);
    assert!(err.contains("nowhere"), "{err}");
    assert!(refused(&inner, &["identify", "logged.csv", "--no-vehicle-file"]).contains("gyro"));
    assert_eq!(run(&inner, &["identify", "logged.csv", "--quiet"]).2, "", "quiet is quiet");
    std::fs::write(root.join("pitchid.toml"), "axis = \"pitch\"\nmass = 3\n").unwrap();
    let refusal = refused(&inner, &["identify", "logged.csv"]);
    assert!(refusal.contains("../pitchid.toml, line 2") && refusal.contains("mass"), "{refusal}");
}

/// The steps of the doctor, of one file.
fn examined(folder: &Path, file: &str) -> (Vec<Value>, Value) {
    let answer: Value = serde_json::from_str(&answered(folder, &["doctor", file, "--json", "-"])).unwrap();
    let of = &answer["examined"][0];
    (of["steps"].as_array().unwrap().clone(), of["next"].clone())
}

#[test]
fn the_doctor_says_what_is_wrong_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    let (steps, next) = examined(folder, "flight.csv");
    assert!(steps.iter().all(|step| step["state"] != "wrong"), "{steps:?}");
    assert_eq!(next, "pitchid diagnose flight.csv");
    let csv = std::fs::read(folder.join("flight.csv")).unwrap();
    std::fs::create_dir(folder.join("logs")).unwrap();
    let still: String =
        (0..500).map(|k| format!("{:.2},0,{}\n", 0.02 * f64::from(k), f64::from(k % 7))).collect();
    let files: [(&str, &[u8], &str); 9] = [
        ("empty.csv", b"", "empty"),
        ("paper.pdf", b"%PDF-1.7\n%\xe2\xe3\n", "a PDF document"),
        ("model.toml", b"[plant]\ninertia_kg_m2 = 0.2\n", "a model file"),
        ("cut.csv", &csv[..40], ""),
        ("cut.ulg", b"ULog\x01\x12\x35\x01", "ends after 8 bytes"),
        ("header.ulg", b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0", "no message can be read"),
        ("zeros.bin", &[0; 5000], "binary"),
        ("text.csv", b"a,b\n1,x\n", ""),
        ("still.csv", &[b"t_s,u_rad,q_rad_s\n", still.as_bytes()].concat(), "moves nowhere"),
    ];
    for (name, bytes, says) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
        let (steps, next) = examined(folder, name);
        let last = steps.last().unwrap();
        assert_eq!(last["state"], "wrong", "{name}: {steps:?}");
        assert!(last["words"].as_str().unwrap().contains(says), "{name}: {last}");
        assert!(!last["remedy"].as_str().unwrap().is_empty(), "{name}: {last}");
        assert!(next.is_null(), "{name}");
    }
    for (name, says) in [("logs", "folder"), ("nowhere.csv", "no such file")] {
        assert!(examined(folder, name).0[0]["words"].as_str().unwrap().contains(says), "{name}");
    }
    let told = answered(folder, &["doctor", "flight.csv", "paper.pdf"]);
    assert!(told.contains("  next   pitchid diagnose flight.csv") && told.contains("WRONG"), "{told}");
    std::fs::write(folder.join("pitchid.toml"), "model = \"model.toml\"\n").unwrap();
    let told = answered(folder, &["doctor"]);
    for part in [
        env!("CARGO_PKG_VERSION"),
        "pitchid.toml: model model.toml",
        "a model that can be read",
        "can be written",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    // what the doctor tells of files that are no recordings, every command tells
    assert!(refused(folder, &["diagnose", "paper.pdf", "--no-vehicle-file"]).contains("a PDF document"));
}

#[test]
fn tables_and_models_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    answered(folder, &["simulate", "--seed", "3", "--out", "flight.csv"]);
    for name in ["flight.mat", "flight.npy"] {
        answered(folder, &["convert", "flight.csv", name]);
    }
    let parameters = |name: &str| -> Value {
        let answer = answered(folder, &["identify", name, "--split", "100", "--json", "-"]);
        serde_json::from_str::<Value>(&answer).unwrap()["parameters"].clone()
    };
    assert_eq!(
        parameters("flight.mat"),
        parameters("flight.csv"),
        "what was written for MATLAB is the recording"
    );
    assert!(std::fs::read(folder.join("flight.npy")).unwrap().starts_with(b"\x93NUMPY\x01\x00"));
    assert!(refused(folder, &["convert", "flight.csv", "flight.xls"]).contains(".npy"));
    answered(folder, &["identify", "flight.csv", "--export", "model.m", "--out-model", "model.toml"]);
    answered(folder, &["identify", "flight.csv", "--export", "model.py"]);
    let model = std::fs::read_to_string(folder.join("model.toml")).unwrap();
    let delay = model.lines().find_map(|line| line.strip_prefix("delay_s = ")).unwrap();
    for (name, line) in
        [("model.m", format!("delay_s = {delay};")), ("model.py", format!("delay_s = {delay}\n"))]
    {
        let script = std::fs::read_to_string(folder.join(name)).unwrap();
        assert!(script.contains(&line), "{name}: {script}");
    }
    assert!(refused(folder, &["identify", "flight.csv", "--export", "model.txt"]).contains(".py"));
}

#[test]
fn every_answer_can_be_had_as_json_and_every_picture_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let of = |arguments: &[&str]| -> Value {
        serde_json::from_str(&answered(folder, &[arguments, &["--json", "-"]].concat())).unwrap()
    };
    assert_eq!(of(&["simulate", "--seed", "3", "--out", "flight.csv"])["outcome"], "finished");
    answered(folder, &["simulate", "--seed", "4", "--out", "other.csv"]);
    let table = of(&["convert", "flight.csv", "flight.parquet"]);
    assert_eq!(
        (&table["schema"], &table["recording"]["name"]),
        (&"pitchid.table/1".into(), &"flight.csv".into())
    );
    assert_eq!(of(&["identify", "flight.csv"])["schema"], "pitchid.identification/1");
    let proof = of(&["prove", "--cases", "2"]);
    assert_eq!((&proof["schema"], &proof["cases"]), (&"pitchid.proof/1".into(), &2.into()));
    assert!(!proof["tables"].as_array().unwrap().is_empty());
    assert_eq!(of(&["reproduce", "paper", "--seeds", "1"])["simulated"]["seeds"], 1);
    let demo = of(&["demo", "--seed", "8"]);
    assert!(demo["truth"]["effects"][0]["id"].is_string() && demo["diagnosis"]["verdict"].is_string());
    for command in [
        &["show", "flight.csv"][..],
        &["identify", "flight.csv"],
        &["diagnose", "flight.csv"],
        &["compare", "flight.csv", "other.csv"],
    ] {
        let svg = answered(folder, &[command, &["--plot", "-"]].concat());
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{command:?}: {svg:.60}");
    }
    assert!(
        refused(folder, &["identify", "flight.csv", "--plot", "-", "--json", "-"]).contains("one answer")
    );
}
