//! Experiments as they are made: releases, steps, tails at rest, few samples per period, inputs that follow the motion.

use host_sim::plant::State as Airframe;
use host_sim::sensors::Noise;
use host_sim::{Background, Bench, Input, Plant, dirt};
use sysid::diagnosis::answer::Verdict;
use sysid::diagnosis::data_checks::State;
use sysid::recording::{InputHold, ReadOptions};

use crate::{
    ask, ask_nominal, bench, check, effect, entry, estimate, ids, is_right, logged, model_of, read,
    read_with, words,
};

#[test]
fn what_is_held_out_has_something_to_show_where_the_tail_is_dead() {
    let friction = effect("coulomb_friction", &[("Mc", 0.1)]);
    let tail = Bench { works_s: [0.0, 60.0], duration_s: 90.0, ..bench(1, vec![friction]) };
    let answer = ask_nominal(&logged(&tail));
    assert_eq!((answer.verdict, ids(&answer)), (Verdict::Named, vec!["coulomb_friction"]));
    for (label, held) in &answer.fit.held_out {
        println!("{label}: {:.1} {:.1}", held.baseline.free_run, held.extended.free_run);
        assert!(held.extended.free_run > 40.0, "{label}");
    }
}

/// A geared drive: its friction, two thirds of the force, stops it within two samples at every turn.
fn drive(friction: &[(&str, f64)]) -> Bench {
    let plant = Plant { inertia_kg_m2: 1.0, dm_dq: -4.0, dm_du: 3.0, delay_s: 0.004, mount: None };
    Bench {
        plant,
        effects: vec![effect("stribeck_friction", friction)],
        input: Input::Tones { effective: 6.0, band_hz: [0.2, 3.0], count: 20 },
        unit: "V",
        duration_s: 60.0,
        background: Background::None,
        noise: Noise { theta_rad: 3e-4, ..Noise::none() },
        ..Bench::new(5)
    }
}

#[test]
fn a_drive_that_sticks_at_every_turn_has_its_friction_to_a_tenth_with_and_without_a_model() {
    let drive = drive(&[("Ms", 21.0), ("Mc", 14.0), ("qs", 0.2)]);
    let recording = read(&dirt::without(logged(&drive), "q_rad_s"));
    let near = entry("stribeck_friction", &[("Mc", 13.0), ("Ms", 19.0), ("qs", 0.3)]);
    let mut plant = drive.plant;
    plant.dm_du *= 0.9;
    for model in [None, Some(model_of(&plant, vec![near]))] {
        let answer = ask(std::slice::from_ref(&recording), model.as_ref()).answer;
        println!("{}", answer.summary);
        let told = answer.in_model.iter().map(|known| (&known.id, &known.parameters));
        let told = told.chain(answer.effects.iter().map(|e| (&e.id, &e.parameters)));
        let (_, found) = told.into_iter().find(|(id, _)| *id == "stribeck_friction").expect("it is told");
        for (name, truth) in [("Mc", 14.0), ("Ms", 21.0), ("qs", 0.2)] {
            let p = found.iter().find(|p| p.name == name).expect("it has it");
            assert!(is_right(p, truth, 0.1), "{p:?}");
        }
    }
}

/// What is said of feedback where a binary input drives a rigid airframe in gusts so many times the usual ones.
fn feedback_under(input: Input, gusts: f64) -> State {
    let plant = Plant::nominal().rigid();
    let gusts = vec![([0.0, 80.0], gusts)];
    let table = logged(&Bench { plant, input, gusts, ..bench(2, Vec::new()) });
    let answer = ask(&[read(&table)], Some(&model_of(&plant, Vec::new()))).answer;
    println!("{:?}", check(&answer, "feedback"));
    check(&answer, "feedback").state
}

#[test]
fn feedback_through_the_dwell_is_found_where_air_moves_the_craft_and_not_ruled_out_in_calm() {
    let input = Input::PrbsByRate { amplitude: 0.015, dwell_s: [0.2, 0.4], lengthened: 0.6 };
    assert_eq!(feedback_under(input, 10.0), State::Found);
    assert_eq!(feedback_under(input, 1.0), State::CannotTell);
}

#[test]
fn feedback_is_ruled_out_where_the_dwells_are_drawn() {
    let input = Input::Prbs { amplitude: 0.015, dwell_s: [0.2, 0.4] };
    assert_eq!(feedback_under(input, 1.0), State::RuledOut);
    assert_eq!(feedback_under(input, 10.0), State::RuledOut);
}

/// The stiffness of a Duffing oscillator is k3 = 37 N m/rad³, however coarsely it is sampled.
fn k3_is_right(samples_per_period: f64, interpolated: bool) {
    let oscillator = Bench::duffing(samples_per_period, interpolated, 3).expect("it exists");
    let model = model_of(&oscillator.plant, vec![entry("gravity_stiffness", &[("G", 6.0)])]);
    let input_hold = if interpolated { InputHold::Interpolated } else { InputHold::Held };
    let options = ReadOptions { input_hold, ..ReadOptions::default() };
    let answer = ask(&[read_with(&logged(&oscillator), &options)], Some(&model)).answer;
    assert_eq!((answer.verdict, ids(&answer)), (Verdict::Named, vec!["cubic_stiffness"]));
    let k3 = estimate(&answer, "cubic_stiffness", "k3");
    assert!(is_right(k3, 37.0, 0.02), "{k3:?}");
}

macro_rules! cubic_stiffness {
    ($($test:ident $samples:literal $interpolated:literal)*) => {$(
        #[test]
        fn $test() {
            k3_is_right($samples, $interpolated);
        }
    )*};
}

cubic_stiffness! {
    a_cubic_stiffness_is_right_at_six_samples_per_period 6.0 false
    a_cubic_stiffness_is_right_at_six_samples_per_period_interpolated 6.0 true
    a_cubic_stiffness_is_right_at_nine_samples_per_period 9.0 false
    a_cubic_stiffness_is_right_at_nine_samples_per_period_interpolated 9.0 true
    a_cubic_stiffness_is_right_at_twenty_samples_per_period 20.0 false
}

/// A light oscillator of 68 Hz of which nothing is known and only the angle is measured, nine samples a period: its resonance is
/// far from anything that a craft does, and a fit that starts there has far to go.
#[test]
fn an_oscillator_that_nobody_described_is_found() {
    let plant = Plant { inertia_kg_m2: 1.0, dm_dq: -42.0, dm_du: 1.86e5, delay_s: 0.0, mount: None };
    let (stiffness, k3) = (1.843e5, 7.3e5);
    let oscillator = Bench {
        plant,
        effects: vec![
            effect("linear_stiffness", &[("k", stiffness)]),
            effect("cubic_stiffness", &[("k3", k3)]),
        ],
        input: Input::Tones { effective: 0.022, band_hz: [0.15, 200.0], count: 200 },
        unit: "V",
        interpolated: true,
        works_s: [0.0, 10.0],
        duration_s: 6.7,
        sample_s: 1.0 / 610.35,
        background: Background::None,
        noise: Noise { theta_rad: 2e-4, ..Noise::none() },
        ..Bench::new(4)
    };
    let options = ReadOptions { input_hold: InputHold::Interpolated, ..ReadOptions::default() };
    let recording = read_with(&dirt::without(logged(&oscillator), "q_rad_s"), &options);
    let answer = ask(&[recording], None).answer;
    let mut found = ids(&answer);
    found.sort_unstable();
    assert_eq!(found, ["cubic_stiffness", "linear_stiffness"], "{:?}", answer.verdict);
    let (k, k3_told) =
        (estimate(&answer, "linear_stiffness", "k"), estimate(&answer, "cubic_stiffness", "k3"));
    assert!((k3_told.value / k3 - 1.0).abs() < 0.01, "{k3_told:?}");
    assert!((k.value / stiffness - 1.0).abs() < 0.002, "{k:?}");
}

/// A rigid airframe on a spring.
fn sprung(seed: u64) -> Bench {
    let plant = Plant { delay_s: 0.0, ..Plant::nominal().rigid() };
    let spring = effect("gravity_stiffness", &[("G", 1.0)]);
    Bench { plant, background: Background::Clean, duration_s: 20.0, ..bench(seed, vec![spring]) }
}

#[test]
fn a_step_before_the_first_row_informs_by_its_transient() {
    let step = Bench { input: Input::Step { height: 0.01 }, ..sprung(4) };
    let table = dirt::cut(logged(&step), [0.1, 20.0]);
    let model = model_of(&step.plant, vec![entry("gravity_stiffness", &[("G", 1.2)])]);
    let answer = ask(&[read(&table)], Some(&model)).answer;
    assert_eq!(answer.verdict, Verdict::NoMismatch);
    assert!(is_right(estimate(&answer, "gravity_stiffness", "G"), 1.0, 0.1));
    assert!(words(&answer).contains("before the first row"), "the past of the input is not told");
}

#[test]
fn a_ring_down_from_a_release_informs() {
    let start = Airframe { theta: 0.3, theta_p: 0.3, ..Airframe::default() };
    let release = Bench { input: Input::Rest, start, ..sprung(5) };
    let model = model_of(&release.plant, vec![entry("gravity_stiffness", &[("G", 1.2)])]);
    let answer = ask(&[read(&logged(&release))], Some(&model)).answer;
    assert_eq!(answer.verdict, Verdict::NoMismatch);
    assert!(is_right(estimate(&answer, "gravity_stiffness", "G"), 1.0, 0.1));
}

/// Of a pendulum let go only the angle is logged, nothing is commanded, and there is no model.
#[test]
fn a_swing_that_dies_out_tells_gravity_and_damping_without_an_input_or_a_model() {
    let start = Airframe { theta: 0.6, theta_p: 0.6, ..Airframe::default() };
    let plant = Plant { dm_dq: -0.08, ..Plant::nominal().rigid() };
    let effects = vec![effect("gravity_stiffness", &[("G", 15.0)])];
    let swing =
        Bench { plant, effects, input: Input::Rest, start, duration_s: 10.0, sample_s: 0.01, ..sprung(6) };
    let angle = dirt::without(dirt::without(logged(&swing), "q_rad_s"), "u_rad");
    // the encoder's zero is where the pendulum hangs, or where it was switched on
    for theta in ["theta_rad=theta_rad", "theta_rad=theta_rad+0.7"] {
        let columns = ["u_norm=0", theta].map(|map| map.parse().unwrap()).into();
        let answer =
            ask(&[read_with(&angle, &ReadOptions { columns, ..ReadOptions::default() })], None).answer;
        assert_eq!(answer.verdict, Verdict::Named);
        assert!(
            ids(&answer).iter().all(|id| ["gravity_stiffness", "rest_angle"].contains(id)),
            "{:?}",
            ids(&answer)
        );
        let inertia = swing.plant.inertia_kg_m2;
        assert!(is_right(estimate(&answer, "gravity_stiffness", "G"), 15.0 / inertia, 0.02));
        let told = &answer.fit.extended.parameters;
        let damping = told.iter().find(|e| e.name == "dM_dq").unwrap();
        assert!(is_right(damping, -0.08 / inertia, 0.2), "{damping:?}");
        assert!(!told.iter().any(|e| ["dM_du", "delay"].contains(&e.name.as_str())), "nothing was commanded");
    }
}

/// One step is all that the input does: its spread says nothing of its size, and gain and a constant moment are one number, but the
/// swing after it tells the weight.
#[test]
fn the_swing_after_a_single_step_tells_gravity_without_a_model() {
    let plant = Plant { dm_dq: -0.05, ..Plant::nominal().rigid() };
    let effects = vec![effect("gravity_stiffness", &[("G", 6.5)])];
    let step = Input::Step { height: -0.08 };
    let swing = Bench { plant, effects, input: step, works_s: [0.2, 6.0], duration_s: 6.0, ..sprung(7) };
    let answer = ask(&[read(&logged(&swing))], None).answer;
    assert_eq!((answer.verdict, ids(&answer)), (Verdict::Named, vec!["gravity_stiffness"]));
    assert!(is_right(estimate(&answer, "gravity_stiffness", "G"), 6.5 / swing.plant.inertia_kg_m2, 0.05));
}

/// A rig whose angle keeps to one side, in 20 s at 10 Hz of which only the angle is logged: gravity is not seen without the moment
/// that it hangs against, nor that without gravity.
#[test]
fn a_pendulum_that_hangs_aside_is_found_in_a_short_and_coarse_test() {
    let (stiffness, aside) = (1.2, 0.35_f64);
    let effects = vec![
        effect("gravity_stiffness", &[("G", stiffness)]),
        effect("trim_offset", &[("M0", stiffness * aside.sin())]),
    ];
    for seed in 1..4 {
        let pendulum = Bench {
            plant: Plant::nominal().rigid(),
            effects: effects.clone(),
            start: Airframe { theta: aside, theta_p: aside, ..Airframe::default() },
            input: Input::Prbs { amplitude: 0.015, dwell_s: [0.1, 0.3] },
            works_s: [0.0, 20.0],
            duration_s: 20.0,
            sample_s: 0.1,
            background: Background::Lab,
            ..Bench::new(seed)
        };
        let answer = ask(&[read(&dirt::without(logged(&pendulum), "q_rad_s"))], None).answer;
        assert!(
            matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous),
            "{seed}: {:?}",
            answer.verdict
        );
        assert!(words(&answer).contains("gravity_stiffness"), "{seed}: {}", words(&answer));
        let held = answer.fit.held_out.values();
        let free_run = held.map(|h| h.extended.free_run).sum::<f64>() / answer.fit.held_out.len() as f64;
        assert!(free_run > 50.0, "{seed}: {free_run}");
    }
}
