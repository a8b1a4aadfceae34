//! The real binary in a folder of its own: exit status, messages, answers, files.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use tempfile::TempDir;

const HEADER: &str = "t_s,u_rad,q_rad_s\n";

/// A folder with what a test writes and runs in it.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }
    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }
    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
        command.current_dir(self.0.path()).args(arguments);
        command
    }
    fn run(&self, arguments: &[&str]) -> Output {
        let output = self.command(arguments).output().unwrap();
        assert!(!text(&output.stderr).contains("panicked"), "{}", text(&output.stderr));
        output
    }
    /// Runs what must succeed, and returns what it printed.
    fn answered(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    }
    /// Runs what must be refused without an answer, and returns the message.
    fn refused(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
        text(&output.stderr)
    }
    /// A test with dry friction, strong enough to be found.
    fn with_friction(self) -> Self {
        let effect = "coulomb_friction:Mc=0.1";
        let flown = self.answered(&[
            "simulate",
            "--effect",
            effect,
            "--background",
            "clean",
            "--seed",
            "5",
            "--out",
            "flight.csv",
        ]);
        assert!(flown.contains("flight.csv") && flown.contains("finished"), "{flown}");
        self
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn assert_names(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "no {part:?} in: {message}");
    }
}

/// A well-formed table of `n` rows, of which `change` may spoil some.
fn table(n: usize, change: impl Fn(usize, &mut Vec<String>)) -> String {
    let row = |k: usize| {
        let t = 0.02 * k as f64;
        let u = if (k / 25).is_multiple_of(2) { 0.015 } else { -0.015 };
        let mut cells = vec![format!("{t:.2}"), format!("{u}"), format!("{:.6}", 0.2 * (2.0 * t).sin())];
        change(k, &mut cells);
        cells.join(",") + "\n"
    };
    HEADER.to_owned() + &(0..n).map(row).collect::<String>()
}

#[test]
fn help_version_and_no_arguments() {
    let bench = Bench::new();
    assert!(bench.answered(&["--version"]).starts_with("pitchid "));
    assert_names(
        &bench.answered(&["--help"]),
        &["diagnose", "identify", "reproduce", "simulate", "demo", "prove", "fly", "record", "Exit status"],
    );
    for subcommand in ["diagnose", "identify", "show", "simulate", "demo", "prove"] {
        assert_names(&bench.answered(&[subcommand, "--help"]), &["Examples:", "Exit status"]);
    }
    assert_names(&bench.refused(&[]), &["Usage"]);
    assert_names(&bench.refused(&["diagnose"]), &["RECORDING"]);
    assert_names(&bench.refused(&["diagnose", "a.csv", "--column", "q_rad_s"]), &["--column", "gyro_y"]);
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let bench = Bench::new();
    assert_names(&bench.answered(&["completions", "bash"]), &["diagnose", "--monitor-out", "complete -F"]);
    assert_names(&bench.answered(&["completions", "fish"]), &["diagnose"]);
    assert_names(&bench.answered(&["man"]), &[".TH pitchid", "diagnose"]);
    assert_names(&bench.answered(&["man", "monitor"]), &["monitor", "\\-\\-run\\-length"]);
    assert_names(&bench.refused(&["man", "nothing"]), &["no command nothing", "diagnose"]);
}

#[test]
fn malformed_tables_are_refused_with_their_place() {
    let bench = Bench::new();
    let cells = |rows: std::ops::Range<usize>, column: usize, value: &str| {
        let value = value.to_owned();
        table(200, move |k, cells| {
            if rows.contains(&k) {
                cells[column].clone_from(&value);
            }
        })
    };
    let cell = |row: usize, column: usize, value: &str| cells(row..row + 3, column, value);
    let short_rows =
        |k: usize, cells: &mut Vec<String>| cells.truncate(if (3..6).contains(&k) { 2 } else { 3 });
    let cases: [(&str, String, &[&str]); 7] = [
        ("text.csv", cell(7, 2, "abc"), &["line 9", "q_rad_s", "abc"]),
        ("text.csv", cell(11, 1, "abc"), &["line 13", "u_rad"]),
        ("backwards.csv", cell(50, 0, "0.10"), &["line 52", "t_s"]),
        ("short_rows.csv", table(200, short_rows), &["line 5", "line 7"]),
        ("no_input.csv", table(200, |_, _| ()).replace("u_rad", "stick"), &["u_rad"]),
        ("short.csv", table(4, |_, _| ()), &["4 samples"]),
        ("empty.csv", String::new(), &[]),
    ];
    for (name, content, parts) in cases {
        bench.write(name, &content);
        for subcommand in ["diagnose", "identify"] {
            let message = bench.refused(&[subcommand, name]);
            assert_names(&message, &[name, "help"]);
            assert_names(&message, parts);
        }
    }
    bench.write("one.csv", &cells(7..8, 2, "abc"));
    assert_names(
        &bench.answered(&["show", "one.csv"]),
        &["1 line of 200 garbled", "line 9", "abc", "as a gap"],
    );
}

#[test]
fn files_that_are_no_recordings_are_refused() {
    let bench = Bench::new();
    std::fs::write(bench.path("binary.csv"), [0_u8, 159, 146, 150, 0, 1, 2]).unwrap();
    bench.write("model.toml", "[plant]\ninertia_kg_m2 = 0.17\ndM_dqq = 1.0\n");
    bench.write("good.csv", &table(200, |_, _| ()));
    assert_names(&bench.refused(&["diagnose", "nowhere.csv"]), &["nowhere.csv", "no such file"]);
    assert_names(&bench.refused(&["diagnose", "."]), &["directory"]);
    assert_names(&bench.refused(&["identify", "binary.csv"]), &["binary.csv"]);
    let message = bench.refused(&["diagnose", "good.csv", "--model", "model.toml"]);
    assert_names(&message, &["model.toml", "line 3", "dM_dqq"]);
}

#[test]
fn outputs_that_cannot_be_are_refused_before_the_work() {
    let bench = Bench::new();
    let content = table(200, |_, _| ());
    bench.write("good.csv", &content);
    assert_names(&bench.refused(&["diagnose", "good.csv", "--json", "good.csv"]), &["overwrite an input"]);
    assert_names(&bench.refused(&["diagnose", "good.csv", "--report", "no/such/r.html"]), &["no folder"]);
    assert_names(&bench.refused(&["simulate", "--out", "."]), &["directory"]);
    assert_names(&bench.refused(&["demo", "--out", "good.csv"]), &["good.csv"]);
    assert_eq!(bench.read("good.csv"), content, "no input is ever changed");
}

#[test]
fn a_simulation_repeats_and_refuses_what_it_does_not_know() {
    let bench = Bench::new();
    let fly = |seed: &str, out: &str| {
        let effect = "servo_lag:T=0.08";
        bench.answered(&[
            "simulate",
            "--seed",
            seed,
            "--effect",
            effect,
            "--out",
            out,
            "--truth",
            "truth.json",
        ]);
        bench.read(out)
    };
    let (first, again, other) = (fly("3", "a.csv"), fly("3", "b.csv"), fly("4", "c.csv"));
    assert_eq!(first, again);
    assert_ne!(first, other);
    assert!(!first.contains("servo_lag"), "the recording holds nothing of the truth");
    assert_eq!(bench.json("truth.json")["effects"][0]["id"], "servo_lag");
    assert!(bench.answered(&["simulate", "--seed", "3", "--out", "-"]).contains("t_s,u_rad"));
    let message = bench.refused(&["simulate", "--effect", "poltergeist", "--out", "d.csv"]);
    assert_names(&message, &["poltergeist", "coulomb_friction", "servo_lag"]);
    assert_names(
        &bench.refused(&["simulate", "--effect", "servo_lag:tau=1", "--out", "d.csv"]),
        &["tau", "T"],
    );
    assert!(!bench.path("d.csv").exists());
}

#[test]
fn a_diagnosis_answers_in_every_form() {
    let bench = Bench::new().with_friction();
    let files = ["--json", "a.json", "--report", "a.html", "--out-model", "a.toml"];
    let printed = bench.answered(&[&["diagnose", "flight.csv"], &files[..]].concat());
    assert_names(
        &printed,
        &["VAF", "1 s ahead", "free run", "dM_dq", "rad/s²", "95 %", "coulomb_friction", "a.html"],
    );

    let answer = bench.json("a.json");
    let keys = [
        "schema",
        "verdict",
        "summary",
        "effects",
        "remainder",
        "location",
        "fit",
        "next_experiment",
        "notes",
    ];
    for key in keys {
        assert!(answer.get(key).is_some(), "{key}");
    }
    assert_eq!(answer["schema"], "pitchid.diagnosis/1");
    let effect = &answer["effects"][0];
    assert_eq!(effect["id"], "coulomb_friction");
    for key in ["locus", "equation", "parameters", "probability", "share", "alternatives", "evidence"] {
        assert!(effect.get(key).is_some(), "{key}");
    }
    for key in ["log_evidence", "p_value", "vaf_gain_points", "held_out_log_likelihood"] {
        assert!(effect["evidence"].get(key).is_some(), "{key}");
    }
    let parameter = &effect["parameters"][0];
    let [low, high] = [0, 1].map(|end| parameter["ci95"][end].as_f64().unwrap());
    assert!(low < high && parameter["unit"] == "rad/s²", "{parameter}");
    for section in ["I", "II", "III", "IV"] {
        let held = &answer["fit"]["held_out"][section];
        for (model, key) in [("baseline", "free_run"), ("extended", "0.1"), ("extended", "1.0")] {
            assert!(!held[model][key].is_null(), "{section} {model} {key}");
        }
    }
    assert_eq!(answer["fit"]["chosen_in"]["coulomb_friction"], serde_json::json!([4, 4]));

    let page = bench.read("a.html");
    for external in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(external), "{external}");
    }
    assert!(page.contains("<svg") && page.contains("coulomb_friction") && page.len() < 1_000_000);

    bench.answered(&["simulate", "--model", "a.toml", "--out", "again.csv"]);
    assert!(bench.read("again.csv").contains("t_s,u_rad"));
}

#[test]
fn an_extended_model_keeps_what_has_no_name() {
    let bench = Bench::new();
    let effect = ["--effect", "angle_damping", "--background", "clean", "--seed", "5"];
    bench.answered(&[&["simulate", "--out", "flight.csv"], &effect[..]].concat());
    let diagnosed = |arguments: &[&str]| {
        let files = ["--json", "a.json", "--out-model", "out.toml"];
        bench.answered(&[&["diagnose"], arguments, &files].concat());
        bench.json("a.json")
    };
    let vaf = |answer: &Value, model: &str, section: &str| {
        answer["fit"][model]["vaf_percent"][section].as_f64().unwrap()
    };
    let first = diagnosed(&["flight.csv"]);
    assert_eq!((&first["verdict"], &first["effects"][0]["id"]), (&"unlisted".into(), &"unlisted".into()));
    assert!(first["effects"][0]["evidence"]["p_value"].as_f64().unwrap() < 1e-12);
    let extended = bench.read("out.toml");
    assert_names(
        &extended,
        &["# without a name: ", "id = \"unlisted\"", "shape = ", "c1_N_m", "scale_q_rad_s"],
    );
    bench.write("extended.toml", &extended);

    let second = diagnosed(&["flight.csv", "--model", "extended.toml"]);
    for section in ["I", "II", "III", "IV"] {
        let (before, after) = (vaf(&first, "extended", section), vaf(&second, "baseline", section));
        assert!((before - after).abs() < 0.1, "{section}: {before} {after}");
    }
    assert!(vaf(&first, "extended", "I") > vaf(&first, "baseline", "I") + 2.0);
    assert_eq!(second["verdict"], "no_mismatch", "{second}");
    assert!(bench.read("out.toml").contains("id = \"unlisted\""), "an effect of the baseline is kept");

    bench.answered(&["simulate", "--model", "extended.toml", "--background", "clean", "--out", "again.csv"]);
    assert_eq!(diagnosed(&["again.csv", "--model", "extended.toml"])["verdict"], "no_mismatch");

    let shape = extended.lines().find(|line| line.starts_with("shape = ")).unwrap();
    bench.write("wrong.toml", &extended.replace(shape, "shape = \"of_x\""));
    let message = bench.refused(&["diagnose", "flight.csv", "--model", "wrong.toml"]);
    assert_names(&message, &["wrong.toml", "line", "of_x", "of_q_and_theta"]);
    let lag = "\n[[effect]]\nid = \"servo_lag\"\nT = 0.05\n".repeat(2);
    bench.write("twice.toml", &(extended + &lag));
    let message = bench.refused(&["diagnose", "flight.csv", "--model", "twice.toml"]);
    assert_names(&message, &["twice.toml, line", "servo_lag a second time", "each effect once"]);
    bench.write("many.toml", &with_14_states());
    let message = bench.refused(&["diagnose", "flight.csv", "--model", "many.toml"]);
    assert_names(&message, &["14 states", "at most 12", "leave out"]);
}

/// A model whose effects, each there once, have more states than a model may.
fn with_14_states() -> String {
    let listed = [
        ("servo_lag", "T = 0.05"),
        ("servo_second_order", "f_hz = 5.0\nzeta = 0.7"),
        ("inflow_lag", "g = 0.3\nT_lambda = 0.2"),
        ("structural_mode", "omega = 20.0\nzeta = 0.02\ngain = 0.3"),
        ("slung_load", "f_hz = 1.0\nshare = 0.2\nzeta = 0.1"),
    ];
    let sizes = "c1_N_m = 0.01\nc2_N_m = 0.01\nc3_N_m = 0.01\nscale_q_rad_s = 0.3\nscale_theta_rad = 0.1\n\
                 scale_u = 0.015\nduration_s = 90.0";
    let unlisted = ["memory_of_u", "memory_of_motion"]
        .map(|shape| format!("[[effect]]\nid = \"unlisted\"\nshape = \"{shape}\"\n{sizes}\n"));
    let plant = "[plant]\ninertia_kg_m2 = 0.1705\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\ndelay_s = 0.06\n";
    let listed = listed.map(|(id, values)| format!("[[effect]]\nid = \"{id}\"\n{values}\n"));
    plant.to_owned() + &listed.concat() + &unlisted.concat()
}

#[test]
fn json_on_standard_output_is_nothing_but_json_and_it_and_the_report_are_the_same_on_any_number_of_threads() {
    let bench = Bench::new().with_friction();
    let with_threads = |n: &str| {
        let mut command =
            bench.command(&["diagnose", "flight.csv", "--json", "-", "--report", "report.html"]);
        let output = command.env("RAYON_NUM_THREADS", n).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
        [text(&output.stdout), bench.read("report.html")]
    };
    let one = with_threads("1");
    let answer: Value = serde_json::from_str(&one[0]).unwrap();
    assert_eq!(answer["schema"], "pitchid.diagnosis/1");
    assert!(one == with_threads("2"));
}

#[test]
fn an_identification_compares_methods() {
    let bench = Bench::new().with_friction();
    let printed = bench.answered(&["identify", "flight.csv", "--out-model", "m.toml", "--json", "i.json"]);
    assert_names(&printed, &["unused PRBS", "closed loop", "grey-box", "LMS", "dM_du", "95 % interval"]);
    let found = bench.json("i.json");
    assert!(found["methods"].as_array().unwrap().len() >= 2);
    assert!(bench.read("m.toml").contains("dM_dq_N_m_s"));
    let json: Value =
        serde_json::from_str(&bench.answered(&["identify", "flight.csv", "--json", "-"])).unwrap();
    assert_eq!(json, found);
}

#[test]
fn the_paper_is_reproduced_with_its_page_and_pictures() {
    let bench = Bench::new();
    let printed = bench.answered(&["reproduce", "paper", "--seeds", "1", "--out", "paper"]);
    assert_names(&printed, &["nominal", "realistic", "PI-MOESP", "H∞ match", "ceiling", "64.4", "paper.md"]);
    let figures = bench.json("paper/paper.json");
    let studies = figures["studies"].as_array().unwrap();
    for study in studies {
        let seed = &study["seeds"][0];
        assert!(seed["methods"].as_array().unwrap().len() >= 9, "{seed}");
        assert!(seed["agreement_percent"].as_f64().unwrap() > 90.0);
    }
    let error = studies[0]["seeds"][0]["parameter_errors"][0]["dm_du_percent"].as_f64().unwrap();
    assert!(error.abs() < 2.0, "the nominal plant is found: {error} %");
    let page = bench.read("paper/paper.md");
    for picture in ["figure6.svg", "figure7.svg", "figure8.svg", "bode.svg", "choice.svg"] {
        assert!(page.contains(picture) && bench.read(&format!("paper/{picture}")).starts_with("<svg xmlns="));
    }
    assert_names(&bench.refused(&["reproduce"]), &["paper"]);
    assert_names(&bench.refused(&["reproduce", "paper", "nowhere.csv"]), &["nowhere.csv", "no such file"]);
}

#[test]
fn the_demonstration_conceals_finds_and_reveals() {
    let bench = Bench::new();
    let printed = bench.answered(&["demo"]);
    assert_names(
        &printed,
        &["unused PRBS", "closed loop", "The truth, opened only now", "The diagnosis", "Report:"],
    );
    let truth = bench.json("pitchid-demo/truth.json");
    let concealed = truth["effects"][0]["id"].as_str().unwrap();
    let (before, after) = printed.split_once("The truth, opened only now").unwrap();
    assert!(after.contains(concealed), "{after}");
    assert!(after.contains("inside") || after.contains("outside"), "values are held against intervals");
    assert!(!bench.read("pitchid-demo/recording.csv").contains(concealed));
    assert!(before.contains("VAF"));
    assert!(bench.path("pitchid-demo/report.html").exists());
    assert!(bench.read("pitchid-demo/demo.svg").starts_with("<svg xmlns="));

    // what the demonstration said is what the command says on its files
    let [recording, model] = ["recording.csv", "model.toml"].map(|name| format!("pitchid-demo/{name}"));
    let again = bench.answered(&["diagnose", &recording, "--model", &model, "--json", "-"]);
    assert_eq!(again, bench.read("pitchid-demo/diagnosis.json"));
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let bench = Bench::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_pitchid"))
        .args(["simulate", "--out", "-"])
        .current_dir(bench.0.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

/// Recordings of real rigs: whatever they hold, there is an answer. Skipped where the folder is absent.
#[test]
fn real_recordings_are_answered() {
    let recording =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/real/variable_pitch_bed_1.csv");
    if !recording.exists() {
        eprintln!("skipped: no recordings of real rigs at {}", recording.display());
        return;
    }
    let bench = Bench::new();
    let files = ["--report", "r.html", "--json", "r.json", "--pictures", "of/it"];
    let printed = bench.answered(&[&["diagnose", recording.to_str().unwrap()][..], &files].concat());
    assert_names(&printed, &["VAF", "1 s ahead", "section-1.svg"]);
    assert!(bench.read("of/it/section-1.svg").starts_with("<svg xmlns="));
    assert!(!bench.json("r.json")["fit"]["held_out"]["IV"].is_null());
    assert!(bench.read("r.html").len() < 1_000_000);
}

#[test]
fn a_proof_seals_resumes_and_does_not_hang_on_the_number_of_jobs() {
    let bench = Bench::new();
    let printed = bench.answered(&["prove", "--cases", "2", "--jobs", "2", "--out", "whole"]);
    bench.answered(&["prove", "--cases", "1", "--jobs", "1", "--out", "parts"]);
    assert_names(&bench.refused(&["prove", "--cases", "2", "--out", "parts"]), &["--resume"]);
    let first = std::fs::metadata(bench.path("parts/cases/0000/answer.json")).unwrap().modified().unwrap();
    bench.answered(&["prove", "--cases", "2", "--jobs", "1", "--out", "parts", "--resume"]);
    let again = std::fs::metadata(bench.path("parts/cases/0000/answer.json")).unwrap().modified().unwrap();
    assert_eq!(first, again, "a finished case is not done again");
    let case = ["recording.csv", "model.toml", "truth.json", "answer.json", "beside.json"];
    let cases = ["0000", "0001"].into_iter().flat_map(|n| case.map(|file| format!("cases/{n}/{file}")));
    let results = ["seals.txt", "results.json", "table.md", "report.html"].map(str::to_owned);
    for file in cases.chain(results) {
        let [whole, parts] = ["whole", "parts"].map(|folder| bench.read(&format!("{folder}/{file}")));
        assert_eq!(whole, parts, "{file}");
    }
    // the seal stands on standard output before anything of the truth does
    let seal = bench.read("whole/cases/0000/truth.sha256");
    assert!(printed.find(seal.trim()).unwrap() < printed.find("One effect of the catalogue").unwrap());
    let concealed = bench.json("whole/cases/0000/truth.json")["ids"][0].as_str().unwrap().to_owned();
    assert!(!bench.read("whole/cases/0000/recording.csv").contains(&concealed));

    let truth = bench.read("whole/cases/0000/truth.json");
    bench.write("whole/cases/0000/truth.json", &truth.replace(&concealed, "gyro_bias"));
    let output = bench.run(&["prove", "--cases", "2", "--out", "whole", "--resume"]);
    assert_eq!(output.status.code(), Some(2));
    assert_names(&text(&output.stderr), &["truth.json", "not the file that was sealed"]);
}

/// The reference vehicle's nominal model, which a user of it has.
const MODEL: &str = "[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\n\
    mount_k_N_m = 3.8689\nmount_c_N_m_s = 0.02639\nmount_J_kg_m2 = 5.0e-04\n";

/// A table with one column times `factor`.
fn scaled(table: &str, column: &str, factor: f64) -> String {
    let header = table.lines().find(|line| line.starts_with("t_s")).unwrap();
    let index = header.split(',').position(|name| name == column).unwrap();
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(value) = cells[0].parse::<f64>().and_then(|_| cells[index].parse::<f64>()) {
            cells[index] = format!("{}", factor * value);
        }
        cells.join(",") + "\n"
    };
    table.lines().map(row).collect()
}

#[test]
fn a_reversed_rate_and_degrees_for_radians_are_told_before_any_physics() {
    let bench = Bench::new().with_friction();
    bench.write("model.toml", MODEL);
    for (factor, cause, words, option) in [
        (-1.0, "rate_sign", "reversed", "q_rad_s=q_rad_s*-1"),
        (57.29578, "rate_unit", "degrees", "q_rad_s=q_rad_s*0.01745329"),
    ] {
        bench.write("spoilt.csv", &scaled(&bench.read("flight.csv"), "q_rad_s", factor));
        let command = ["diagnose", "spoilt.csv", "--model", "model.toml", "--json", "a.json"];
        let printed = bench.answered(&command);
        assert_names(&printed, &["Checks of the data", words, "--column", "ruled out"]);
        let answer = bench.json("a.json");
        assert_eq!(answer["verdict"], "check_data");
        assert!(answer["effects"].as_array().unwrap().is_empty());
        let option_named = format!("--column '{option}'");
        assert_names(answer["summary"].as_str().unwrap(), &["q_rad_s", "No physics is named", &option_named]);
        let causes = answer["data_checks"].as_array().unwrap();
        let found: Vec<&Value> = causes.iter().filter(|c| c["state"] == "found").collect();
        assert!(found.iter().any(|c| c["cause"] == cause), "{found:?}");

        let advised = bench.answered(&[&command[..], &["--column", option]].concat());
        assert_names(&advised, &["coulomb_friction", "ruled out: clock"]);
        assert_eq!(bench.json("a.json")["verdict"], "named");
    }
}
