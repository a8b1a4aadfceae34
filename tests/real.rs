//! Recordings of real rigs: a verdict each, and none that physics forbids.

use pitchid_tests::{real_recordings, real_vehicles};
use std::path::Path;
use sysid::diagnosis::diagnose;
use sysid::identify::compare::identify;
use sysid::recording::{InputHold, ReadOptions, Recording, read};

#[test]
fn every_real_recording_gets_a_verdict_without_nonsense() {
    let Some(files) = real_recordings() else {
        println!("skipped: no recordings of real rigs beside this checkout");
        return;
    };
    for file in files {
        // The oscillator's input was measured, not commanded.
        let measured = file.to_string_lossy().contains("oscillator");
        let input_hold = if measured { InputHold::Interpolated } else { InputHold::Held };
        let recording =
            read(&file, &ReadOptions { input_hold, ..ReadOptions::default() }).expect("the file reads");
        let answer = diagnose(&[recording], None, &|_| ()).expect("there is an answer").answer;
        println!("{}: {:?} {}", file.display(), answer.verdict, answer.summary);
        for effect in &answer.effects {
            for p in &effect.parameters {
                assert!(p.value.is_finite() && p.ci95[0] <= p.value && p.value <= p.ci95[1], "{p:?}");
                let dissipative = ["Mc", "D", "T", "b", "k3", "ks", "zeta"].contains(&p.name.as_str());
                assert!(!dissipative || p.value >= 0.0, "{} of {} is negative", p.name, effect.id);
            }
        }
        for (section, vaf) in &answer.fit.extended.vaf_percent {
            // The ceiling is that of a linear model: one with friction or a stop may pass it.
            let ceiling = answer.fit.ceiling_vaf_percent[section];
            assert!([*vaf, ceiling].iter().all(|v| (0.0..=100.0).contains(v)), "{section}: {vaf}, {ceiling}");
        }
    }
}

/// One axis of a flight of the small quadrotor, its columns given as if it were pitch.
fn flown(folder: &Path, flight: &str, axis: [&str; 2]) -> Recording {
    let columns = [format!("u_norm=u_{}_norm", axis[0]), format!("q_rad_s={}_rad_s", axis[1])];
    let columns = columns.iter().map(|map| map.parse().expect("a column")).collect();
    let options = ReadOptions { columns, ..ReadOptions::default() };
    read(&folder.join(format!("small_quad_{flight}.csv")), &options).expect("the file reads")
}

#[test]
fn a_vehicle_out_of_trim_is_told_first_and_the_same_vehicle_is_not() {
    let Some(folder) = real_vehicles() else {
        println!("skipped: no flights of real vehicles beside this checkout");
        return;
    };
    for (axis, flights) in [
        (["roll", "p"], [("a", None), ("b", Some(0.15)), ("c", Some(0.11))]),
        (["pitch", "q"], [("a", None), ("b", Some(-0.12)), ("c", None)]),
    ] {
        let model = identify(&[flown(&folder, "a", axis)], None, &|_| ()).expect("a model").model;
        for (flight, command) in flights {
            let answer =
                diagnose(&[flown(&folder, flight, axis)], Some(&model), &|_| ()).expect("an answer").answer;
            println!("{flight} {}: {:?} {}", axis[0], answer.verdict, answer.summary);
            let balance = answer.balance.as_ref();
            assert_eq!(
                balance.is_some_and(|b| b.out_of_trim),
                command.is_some(),
                "{flight} {axis:?}: {balance:?}"
            );
            let Some(command) = command else { continue };
            let held = answer.questions.iter().find(|q| q.question == "Is it in trim?").expect("it is asked");
            let value: f64 = held
                .answer
                .split("takes ")
                .nth(1)
                .and_then(|w| w.split(' ').next())
                .unwrap()
                .parse()
                .unwrap();
            assert!((value / command - 1.0_f64).abs() < 0.1, "{flight} {axis:?}: {value}");
            assert!(answer.summary.contains("Out of the model's trim"), "{}", answer.summary);
        }
    }
}
