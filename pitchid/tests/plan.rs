//! `pitchid plan` through the real binary.

#[path = "support/command.rs"]
mod command;

use command::run;
use serde_json::Value;

#[test]
fn a_plan_from_size_and_mass_is_the_same_twice_keeps_its_limits_and_says_what_to_expect() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |out: &str| {
        let asked =
            ["plan", "--mass", "5", "--arm", "0.415", "--limit", "0.4", "--flights", "12", "--out", out];
        let (status, told, err) = run(folder.path(), &asked);
        assert_eq!(status, Some(0), "{err}");
        told
    };
    let told = plan("a");
    plan("b");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("a/plan.json"), read("b/plan.json"));
    for wanted in
        ["PRBS of ±", "largest angle, rad", "taken by the supervisor", "dM_du", "ms", "page for the bench"]
    {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    let plan: Value = serde_json::from_str(&read("a/plan.json")).unwrap();
    let test = &plan["tests"][0];
    let most = test["excursion"]["angle_rad"]["most"].as_f64().unwrap();
    assert!(most <= 0.4 && test["excursion"]["broken_off"] == 0, "{test}");
    assert!(test["trip_theta_rad"].as_f64().unwrap() < 0.4);
    let accuracy = plan["accuracy"].as_array().unwrap();
    let gain = accuracy.iter().find(|one| one["name"] == "dM_du").unwrap();
    let middle = gain["half_width"]["median"].as_f64().unwrap();
    assert!((0.5..10.0).contains(&middle), "{gain}");
    let parameters = read("a/test-1.param");
    assert!(parameters.contains(&format!("EXC_AMPL {}\n", test["amplitude_rad"])), "{parameters}");
    let page = read("a/page.html");
    for wanted in ["Before the motors run", "<svg", "EXC_DWELL_MIN", "Break it off", "To repeat it"] {
        assert!(page.contains(wanted), "{wanted}");
    }
}

#[test]
fn rivals_of_a_diagnosis_are_told_apart_by_the_plan() {
    let folder = tempfile::tempdir().unwrap();
    let model = "[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\n\
                 [[effect]]\nid = \"servo_lag\"\nT = 0.06\n";
    std::fs::write(folder.path().join("extended.toml"), model).unwrap();
    let answer = r#"{"effects": [{"id": "servo_lag", "parameters": [{"name": "T", "value": 0.06}],
        "alternatives": [{"id": "gyro_lag", "probability": 0.3}]}]}"#;
    std::fs::write(folder.path().join("answer.json"), answer).unwrap();
    let asked =
        ["plan", "--model", "extended.toml", "--diagnosis", "answer.json", "--flights", "10", "--json", "-"];
    let (status, told, err) = run(folder.path(), &asked);
    assert_eq!(status, Some(0), "{err}");
    let plan: Value = serde_json::from_str(&told).unwrap();
    let chance = &plan["chance"];
    assert_eq!(chance["rivals"], serde_json::json!(["servo_lag", "gyro_lag"]));
    let [flown, right, wrong] = ["flown", "right", "wrong"].map(|key| chance[key].as_u64().unwrap());
    assert!(right * 10 >= flown * 8 && wrong * 10 <= flown, "{chance}");
}

#[test]
fn what_cannot_be_planned_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |more: &[&str]| {
        let (status, _, err) = run(folder.path(), &[&["plan"], more].concat());
        assert_eq!(status, Some(2), "{err}");
        err
    };
    assert!(refused(&["--mass", "5"]).contains("--arm"));
    assert!(refused(&["--mass", "5000", "--arm", "0.4"]).contains("a craft of this kind has 0.05 to 100 kg"));
    assert!(refused(&["--mass", "5", "--arm", "0.4", "--limit", "3"]).contains("--limit 3"));
    std::fs::write(folder.path().join("m.toml"), "[plant]\ninertia_kg_m2 = 1.0\n").unwrap();
    assert!(refused(&["--model", "m.toml"]).contains("dM_dq_N_m_s"));
    // a small craft answers four times as fast as the board's controller expects
    let err = refused(&["--mass", "0.3", "--arm", "0.08", "--flights", "10"]);
    assert!(err.contains("no excitation comes into question"), "{err}");
}
