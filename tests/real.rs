//! Recordings of real rigs: a verdict each, and none that physics forbids.

use pitchid_tests::real_recordings;
use sysid::diagnosis::diagnose;
use sysid::recording::{InputHold, ReadOptions, read};

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
