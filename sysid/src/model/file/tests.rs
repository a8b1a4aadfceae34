//! Model files, right and wrong.

use super::*;
use crate::legal::Legal;

fn table() -> [KnownEffect; 2] {
    let named = |id, parameters| KnownEffect { id, shape: None, parameters };
    let lag = vec![("g", Legal::new(0.0, 1.0, "1")), ("T_lambda", Legal::new(1e-5, 1e6, "s"))];
    [named("gravity_stiffness", vec![("G", Legal::any("N m"))]), named("inflow_lag", lag)]
}
const FULL: &str = "# in use\n[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\n\
    dM_du_N_m = 23\nmount_k_N_m = 3.87\nmount_c_N_m_s = 0.0264\nmount_J_kg_m2 = 5.0e-4\n\n\
    [[effect]]\nid = \"gravity_stiffness\"\nG = 0.4\n\n[[effect]]\nid = \"inflow_lag\"\ng = 0.3\nT_lambda = 1\n\n\
    [interval.dM_dq_N_m_s]\nci95 = [-0.29, -0.25]\n[interval.G]\nci95 = [0.3, 0.5]\n\
    [interval.\"inflow_lag.g\"]\nci95 = [0, 1]\n";

fn refused(text: &str) -> Error {
    parse("m.toml", text, None, &table()).expect_err("this model must be refused")
}

#[test]
fn reads_every_part() {
    let model = parse("m.toml", FULL, None, &table()).unwrap();
    assert_eq!((model.plant.dm_dq, model.plant.dm_du), (Some(-0.27), Some(23.0)));
    assert_eq!(model.plant.mount_j, Some(5.0e-4));
    assert_eq!(model.effects[1].parameters["T_lambda"], 1.0);
    assert_eq!(model.intervals["G"].ci95, [0.3, 0.5]);
    let least = parse("m.toml", "[plant]\ninertia_kg_m2 = 1.0", None, &table()).unwrap();
    assert_eq!((least.plant.delay_s, least.plant.mount_k), (None, None));
}

#[test]
fn what_is_written_reads_back() {
    let model = parse("m.toml", FULL, None, &table()).unwrap();
    let text = model.to_toml().unwrap();
    assert_eq!(parse("m.toml", &text, None, &table()).unwrap(), model, "{text}");
    let unknown = ModelFile::unknown();
    let text = unknown.to_toml().unwrap();
    assert!(text.contains("inertia_kg_m2 = 1.0 # not known"), "{text}");
    assert_eq!(parse("m.toml", &text, None, &table()).unwrap(), unknown);
    let mut broken = model;
    broken.plant.dm_dq = Some(f64::NAN);
    assert!(broken.to_toml().is_err());
}

#[test]
fn malformed_models_name_line_key_and_advice() {
    let full = |from: &str, to: &str| FULL.replacen(from, to, 1);
    let cases: [(String, usize, &str); 27] = [
        (full("delay_s", "delay"), 4, "key delay: unknown key\n  expected: one of delay_s"),
        (
            full("inertia_kg_m2 = 0.1705", "inertia_kg_m2 = \"a\""),
            3,
            "found \"a\"\n  expected: a number above 0",
        ),
        (full("inertia_kg_m2 = 0.1705", "inertia_kg_m2 = true"), 3, "found true"),
        (full("inertia_kg_m2 = 0.1705", "inertia_kg_m2 = 0.1705 kg"), 3, "advice"),
        (full("inertia_kg_m2 = 0.1705\n", ""), 2, "key inertia_kg_m2: missing\n  expected: a number above 0"),
        (full("0.1705", "-0.1705"), 3, "inertia_kg_m2: found -0.1705\n  expected: a number above 0"),
        (full("0.1705", "nan"), 3, "found nan"),
        (full("0.1705", "1e300"), 3, "found 1e300\n  expected: a number above 0 and up to 1e12, in kg m²"),
        (full("delay_s = 0.06", "delay_s = -0.06"), 4, "a number from 0 to 10, in s"),
        (full("delay_s = 0.06", "delay_s = 99999999999999999999"), 4, "a number from 0 to 10, in s"),
        (full("-0.27", "inf"), 5, "dM_dq_N_m_s: found inf"),
        (full("3.87", "0"), 7, "mount_k_N_m: found 0"),
        (full("mount_c_N_m_s = 0.0264\n", ""), 7, "only mount_k_N_m, mount_J_kg_m2"),
        (
            full("gravity_stiffness", "gravity"),
            12,
            "unknown effect \"gravity\"\n  expected: one of gravity_stiffness, inflow_lag",
        ),
        (full("id = \"gravity_stiffness\"\n", ""), 11, "an effect without id"),
        (full("G = 0.4", "K = 0.4"), 13, "K: unknown parameter\n  expected: gravity_stiffness with G"),
        (
            full("G = 0.4", "G = \"x\""),
            13,
            "key G: found \"x\"\n  expected: a number from -1e12 to 1e12, in N m",
        ),
        (full("T_lambda = 1\n", ""), 16, "inflow_lag without T_lambda"),
        (
            full("T_lambda = 1\n", "T_lambda = 0\n"),
            18,
            "key T_lambda: found 0\n  expected: a number from 1e-5 to 1e6, in s",
        ),
        (
            full("inflow_lag\"\ng = 0.3\nT_lambda = 1", "gravity_stiffness\"\nG = 1"),
            16,
            "gravity_stiffness a second time; the first is on line 11",
        ),
        (full("interval.G", "interval.H"), 22, "not in this file"),
        (full("[0.3, 0.5]", "[0.5, 0.3]"), 23, "low first"),
        (full("ci95 = [0.3, 0.5]", "ci95 = 0.3"), 23, "found 0.3\n  expected: [low, high]"),
        (full("ci95 = [0.3, 0.5]", ""), 22, "an interval without ci95"),
        (full("[[effect]]", "[[effects]]"), 11, "key effects: unknown key\n  expected: one of effect"),
        (full("[plant]", "[[plant]]"), 2, "found sections\n  expected: a section [plant]"),
        (full("delay_s = 0.06", "delay_s = 0.06\ndelay_s = 0.07"), 5, "duplicate key"),
    ];
    for (text, line, part) in cases {
        let error = refused(&text);
        let message = error.to_string();
        assert_eq!(error.line, Some(line), "{message}\n{text}");
        assert!(message.starts_with(&format!("m.toml, line {line}")), "{message}");
        assert!(message.contains(part) && message.contains("advice: "), "{part} is not in\n{message}");
    }
}

#[test]
fn all_that_is_wrong_is_told_in_the_order_of_the_lines() {
    let text = FULL
        .replacen("0.1705", "-1", 1)
        .replacen("T_lambda = 1", "T_lambda = 0", 1)
        .replacen("delay_s", "delay", 1);
    let message = refused(&text).to_string();
    let lines: Vec<&str> = message.lines().filter(|line| line.contains("line ")).collect();
    assert_eq!(lines.len(), 3, "{message}");
    assert!(lines[0].starts_with("m.toml, line 3, key inertia_kg_m2: found -1"), "{message}");
    assert!(lines[1].contains("line 4, key delay: unknown key"), "{message}");
    assert!(lines[2].contains("line 18, key T_lambda: found 0"), "{message}");
}
