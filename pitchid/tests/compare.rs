//! `pitchid compare` through the real binary.

#[path = "support/command.rs"]
mod command;

use command::run;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

fn compared(folder: &Path, arguments: &[&str]) -> Value {
    let (status, out, err) = run(folder, &[&["compare"], arguments, &["--json", "-"]].concat());
    assert_eq!(status, Some(0), "{err}");
    serde_json::from_str(&out).unwrap()
}

fn change<'a>(answer: &'a Value, axis: &str, quantity: &str) -> &'a Value {
    let axis = answer["axes"].as_array().unwrap().iter().find(|a| a["axis"] == axis).unwrap();
    axis["changes"].as_array().unwrap().iter().find(|c| c["quantity"] == quantity).unwrap()
}

/// Roll and yaw of a craft under a PRBS, `push` more than trim on roll, a number for the noise.
fn table(push: f64, seed: u32) -> String {
    let mut text = "t_s,u_roll_norm,u_yaw_norm,p_rad_s,r_rad_s\n".to_owned();
    let (mut state, mut p, mut r) = (seed, 0.0, 0.0);
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    for k in 0..1500_u32 {
        let level = |a: u32, b: u32| if (k / a + k / b).is_multiple_of(2) { 0.1 } else { -0.1 };
        let (roll, yaw) = (level(17, 41), level(23, 57));
        writeln!(
            text,
            "{:.2},{roll},{yaw},{:.6},{:.6}",
            0.02 * f64::from(k),
            p + 0.01 * noise(),
            r + 0.01 * noise()
        )
        .unwrap();
        p += 0.02 * (10.0 * (roll - push) - 2.0 * p);
        r += 0.02 * (5.0 * yaw - 1.0 * r);
    }
    text
}

#[test]
fn each_axis_is_compared_and_told_in_words() {
    let folder = tempfile::tempdir().unwrap();
    for (name, push, seed) in [("before.csv", 0.0, 1), ("same.csv", 0.0, 2), ("after.csv", 0.03, 3)] {
        std::fs::write(folder.path().join(name), table(push, seed)).unwrap();
    }
    let (status, text, err) = run(folder.path(), &["compare", "before.csv", "after.csv"]);
    assert_eq!(status, Some(0), "{err}");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in ["ROLL: trim of roll moved by 0.0", "of full command to the right", "YAW: ", "unit inertia"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    assert!(!text.contains("trim of yaw moved"), "{text}");
    let answer = compared(folder.path(), &["before.csv", "after.csv", "--axis", "roll", "--friction"]);
    assert_eq!(answer["axes"].as_array().unwrap().len(), 1);
    let trim = change(&answer, "roll", "trim");
    let ends: Vec<f64> =
        trim["difference"]["ci95"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert!(trim["verdict"] == "changed" && ends[0] < 0.03 && 0.03 < ends[1], "{trim}");
    assert_ne!(change(&answer, "roll", "friction")["verdict"], "changed");
    let same = compared(folder.path(), &["before.csv", "same.csv"]);
    for axis in ["roll", "yaw"] {
        for quantity in ["trim", "effectiveness", "damping", "lag_and_delay"] {
            assert_ne!(change(&same, axis, quantity)["verdict"], "changed", "{axis} {quantity}");
        }
    }
    // two halves of one recording
    let halves = ["before.csv", "before.csv", "--time", "0..15", "--time", "15..", "--axis", "yaw"];
    assert_eq!(compared(folder.path(), &halves)["axes"][0]["seconds"][0], 15.0);
    for (arguments, says) in [
        (&["before.csv", "after.csv", "--axis", "pitch"][..], "no input column"),
        (&["before.csv", "no.csv"], "no.csv: no such file"),
        (&["before.csv", "before.csv", "--time", "0..15"], "before and after are the same"),
        (&["before.csv", "after.csv", "--flight", "2"], "--flight is for flight logs"),
        (&["before.csv", "after.csv", "--time", "90..99"], "its clock runs from 0.000"),
    ] {
        let (status, out, err) = run(folder.path(), &[&["compare"], arguments].concat());
        assert_eq!((status, out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(err.contains(says), "{err}");
    }
}

#[test]
fn what_was_changed_on_a_real_craft_is_told() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/vehicles");
    if !folder.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "no recordings at {}", folder.display());
        println!("skipped: no recordings of vehicles beside this checkout");
        return;
    }
    let trim = |after: &str, axis: &str| {
        let answer = compared(&folder, &["small_quad_a.csv", after, "--axis", axis]);
        let trim = change(&answer, axis, "trim").clone();
        println!("a, {after}, {axis}: {}", answer["axes"][0]["summary"]);
        (trim["verdict"] == "changed", trim["after"]["value"].as_f64().unwrap())
    };
    for (after, axis, told, value) in [
        ("small_quad_b.csv", "roll", true, 0.15),
        ("small_quad_b.csv", "pitch", true, -0.12),
        ("small_quad_c.csv", "roll", true, 0.11),
        ("small_quad_c.csv", "pitch", false, 0.0),
    ] {
        let (changed, found) = trim(after, axis);
        assert_eq!(changed, told, "{after} {axis}");
        assert!((found - value).abs() < 0.03, "{after} {axis}: {found}");
    }
}
