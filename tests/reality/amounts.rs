//! Several recordings, long ones, fast ones: more data never make the answer worse.

use host_sim::sensors::Noise;
use host_sim::{Background, Bench, Plant, Table, dirt};
use sysid::diagnosis::answer::{Answer, Verdict};
use sysid::recording::Recording;

use crate::{ask, bench, effect, estimate, ids, is_right, logged, model_of, read};

fn with_friction(seed: u64, background: Background) -> Table {
    let friction = effect("coulomb_friction", &[("Mc", 0.1)]);
    logged(&Bench { background, duration_s: 60.0, ..bench(seed, vec![friction]) })
}

fn asked(recordings: &[Recording]) -> Answer {
    ask(recordings, Some(&model_of(&Plant::nominal(), Vec::new()))).answer
}

fn is_friction(answer: &Answer) -> bool {
    answer.verdict == Verdict::Named && ids(answer) == ["coulomb_friction"]
}

#[test]
fn probabilities_of_several_recordings_are_those_of_models() {
    let lag = effect("servo_lag", &[("T", 0.05)]);
    let friction = effect("coulomb_friction", &[("Mc", 0.08)]);
    let both = |seed| {
        let effects = vec![lag.clone(), friction.clone()];
        read(&logged(&Bench { duration_s: 40.0, ..bench(seed, effects) }))
    };
    let answer = asked(&[both(1), both(2), both(3)]);
    for effect in &answer.effects {
        assert!(effect.probability >= 0.05 && effect.probability <= 1.0, "{}", effect.id);
        assert!((effect.probability - 0.85).abs() > 1e-9, "{}", effect.id);
        let rivals = effect.alternatives.iter().map(|rival| rival.probability);
        assert!(rivals.clone().all(|p| p <= effect.probability), "{}", effect.id);
        assert!(rivals.sum::<f64>() + effect.probability <= 1.0 + 1e-9, "{}", effect.id);
    }
    assert!(ids(&answer).contains(&"coulomb_friction"));
}

#[test]
fn the_ceiling_is_the_same_whatever_the_model() {
    let recordings = [read(&with_friction(4, Background::Lab))];
    let wrong = Plant { dm_du: 15.0, dm_dq: -0.5, ..Plant::nominal() };
    let ceilings = [None, Some(wrong)].map(|plant| {
        let model = plant.map(|plant| model_of(&plant, Vec::new()));
        ask(&recordings, model.as_ref()).answer.fit.ceiling_vaf_percent
    });
    println!("{ceilings:?}");
    assert_eq!(ceilings[0], ceilings[1]);
}

#[test]
fn tests_before_different_backgrounds_are_named_together_as_each_alone() {
    let backgrounds = [Background::Clean, Background::Lab, Background::Paper];
    let recordings: Vec<Recording> =
        (5..).zip(backgrounds).map(|(seed, background)| read(&with_friction(seed, background))).collect();
    for recording in &recordings {
        assert!(is_friction(&asked(std::slice::from_ref(recording))));
    }
    let together = asked(&recordings);
    assert!(is_friction(&together));
    let told = estimate(&together, "coulomb_friction", "Mc");
    assert!(told.ci95[0] <= 0.1 && 0.1 <= told.ci95[1], "{told:?}");
}

#[test]
fn gusts_in_a_part_of_the_test_do_not_unsettle_the_name() {
    let friction = effect("coulomb_friction", &[("Mc", 0.1)]);
    let gusty =
        Bench { background: Background::Clean, gusts: vec![([30.0, 60.0], 4.0)], ..bench(9, vec![friction]) };
    assert!(is_friction(&asked(&[read(&logged(&gusty))])));
}

#[test]
fn a_log_that_is_faster_than_the_motion_is_thinned_said_so_and_answers_alike() {
    let friction = effect("coulomb_friction", &[("Mc", 0.1)]);
    let fast = logged(&Bench { sample_s: 0.002, duration_s: 60.0, ..bench(10, vec![friction]) });
    let answer = asked(&[read(&fast)]);
    assert!(is_friction(&answer));
    assert!(answer.notes.iter().any(|note| note.contains("averaged")));
    // the logger's means of ten rows bear the stamp of the first: they are 9 ms late for it
    let slow = asked(&[read(&dirt::averaged(fast, 10))]);
    assert_eq!(
        (slow.verdict, ids(&slow).as_slice()),
        (Verdict::Named, &["coulomb_friction", "extra_delay"][..])
    );
    let late = estimate(&slow, "extra_delay", "Delta");
    assert!(late.ci95[0] <= -0.009 && -0.009 <= late.ci95[1], "{late:?}");
    let [of_fast, of_slow] = [&answer, &slow].map(|answer| estimate(answer, "coulomb_friction", "Mc"));
    assert!(of_slow.ci95[0] <= of_fast.value && of_fast.value <= of_slow.ci95[1]);
}

/// Means of a switching input go up and down in ramps whose corners lie between the rows.
#[test]
fn a_test_logged_faster_than_it_moves_leaves_nothing_at_its_switches() {
    let plant = Plant::nominal().rigid();
    for (seed, sample_s) in [(31, 0.004), (32, 0.002), (33, 0.001)] {
        let quiet = Noise { q_rad_s: 0.004, theta_rad: 0.001, ..Noise::default() };
        let still =
            Bench { plant, sample_s, background: Background::Clean, noise: quiet, ..bench(seed, vec![]) };
        let recording = read(&logged(&still));
        let mut model = model_of(&plant, Vec::new());
        let answer = ask(std::slice::from_ref(&recording), Some(&model)).answer;
        assert_eq!(answer.verdict, Verdict::NoMismatch, "{sample_s}");
        model.plant.delay_s = None;
        let answer = ask(&[recording], Some(&model)).answer;
        assert_eq!(answer.verdict, Verdict::NoMismatch, "{sample_s}");
        let delay = answer.fit.extended.parameters.iter().find(|p| p.name == "delay").expect("it is free");
        assert!(is_right(delay, plant.delay_s, 0.02), "{sample_s}: {delay:?}");
    }
}

#[test]
fn one_file_with_gaps_answers_as_its_parts_do() {
    const GAP_S: f64 = 5.0;
    let tables: Vec<Table> = (11..14).map(|seed| with_friction(seed, Background::Lab)).collect();
    let parts: Vec<Recording> = tables.iter().map(read).collect();
    let mut whole = dirt::end_to_end(&tables);
    let rows = whole.t_s.len() / tables.len();
    whole.t_s.iter_mut().enumerate().for_each(|(k, t)| *t += GAP_S * (k / rows) as f64);
    let (whole, parts) = (asked(&[read(&whole)]), asked(&parts));
    assert!(is_friction(&whole) && is_friction(&parts));
    let [of_whole, of_parts] = [&whole, &parts].map(|answer| estimate(answer, "coulomb_friction", "Mc"));
    assert!(of_parts.ci95[0] <= of_whole.value && of_whole.value <= of_parts.ci95[1]);
}
