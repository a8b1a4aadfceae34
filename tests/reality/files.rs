//! What happens to a recording on its way to a file.

use host_sim::{Background, Bench, FreeFlight, Plant, Table, dirt};
use sysid::diagnosis::answer::Verdict;
use sysid::diagnosis::data_checks::State;
use sysid::recording::{ReadOptions, SectionSpec};

use crate::{
    ask, ask_nominal, bench, check, effect, estimate, ids, logged, model_of, read, read_with, words,
};

#[test]
fn times_are_those_of_the_files_clock() {
    let change = effect("inertia_step", &[("delta", 0.35), ("t_star", 40.0)]);
    let table = dirt::clock_from(logged(&bench(1, vec![change])), 180.0);
    let section = |text: &str| text.parse::<SectionSpec>().expect("it is a section");
    let sections = vec![section("A=180..210"), section("B=210..235"), section("C=235..260")];
    let options = ReadOptions { sections, ..ReadOptions::default() };
    let answer = ask(&[read_with(&table, &options)], Some(&model_of(&Plant::nominal(), Vec::new()))).answer;
    assert_eq!(ids(&answer), ["inertia_step"]);
    let told = estimate(&answer, "inertia_step", "t_star");
    assert!((told.value - 220.0).abs() < 1.5, "{told:?}");
    let location = answer.location.expect("it is somewhere");
    assert!(location.time_s.iter().flatten().all(|t| (179.9..260.1).contains(t)), "{:?}", location.time_s);
    assert!(answer.fit.held_out.contains_key("B"));
}

#[test]
fn a_few_wild_samples_are_left_out_counted_and_change_nothing() {
    let clean = logged(&bench(2, vec![effect("coulomb_friction", &[("Mc", 0.1)])]));
    let without = ask_nominal(&clean);
    assert_eq!((without.verdict, ids(&without)), (Verdict::Named, vec!["coulomb_friction"]));
    let mut wrong = Vec::new();
    for (bursts, in_a_row, height) in [(1, 1, 5.0), (1, 1, 100.0), (20, 1, 20.0), (4, 5, 5.0)] {
        println!("{bursts} times {in_a_row} up to {height} rad/s");
        let answer = ask_nominal(&dirt::wild(clean.clone(), "q_rad_s", bursts, in_a_row, height, 7));
        let same = answer.verdict == without.verdict && ids(&answer) == ids(&without);
        if !(same && words(&answer).contains("line")) {
            wrong.push((bursts, in_a_row, height));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// What is said of feedback where a controller of 500 Hz is logged `every` so many of its samples, averaged.
fn feedback_in(flight: FreeFlight, every: usize) -> State {
    let table = FreeFlight { duration_s: 30.0, ..flight }.pitch_alone().fly().expect("it flies").table;
    let answer = ask(&[read(&dirt::averaged(table, every))], None).answer;
    println!("{:?}", check(&answer, "feedback"));
    check(&answer, "feedback").state
}

#[test]
fn feedback_is_found_at_the_rate_of_the_loop_and_never_ruled_out_after_averaging() {
    let flight = || FreeFlight::new(3).expect("it exists");
    assert_eq!(feedback_in(flight(), 1), State::Found);
    assert_ne!(feedback_in(flight(), 10), State::RuledOut);
    let calm = FreeFlight { sigma: [0.001; 3], set_points_rad: [0.0, 0.3, 0.0], ..flight() };
    assert_ne!(feedback_in(calm, 10), State::RuledOut);
}

#[test]
fn a_rate_that_is_stamped_a_sample_off_is_told_as_stamping() {
    let mut wrong = Vec::new();
    for (delay_s, rows) in [(0.0, -1), (0.0, 1), (0.06, -1), (0.06, 1)] {
        let plant = Plant { delay_s, ..Plant::nominal().rigid() };
        let calm =
            Bench { plant, background: Background::Clean, angle_logged: false, ..bench(4, Vec::new()) };
        let table = dirt::stamped_late(logged(&calm), "q_rad_s", rows);
        let mut model = model_of(&plant, Vec::new());
        model.plant.delay_s = None;
        println!("delay {delay_s} s, stamped {rows} rows late");
        let answer = ask(&[read(&table)], Some(&model)).answer;
        println!("{:?}", check(&answer, "delay"));
        let early = delay_s == 0.0 && rows < 0;
        let told =
            !early || (check(&answer, "delay").state == State::Found && words(&answer).contains("stamp"));
        if answer.verdict != Verdict::NoMismatch || !told {
            wrong.push((delay_s, rows));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Which of the spoilt recordings are not for checking the data, or whose remedy is not told.
fn not_for_checking(
    spoilt: impl IntoIterator<Item = (&'static str, Table)>,
    remedy: &str,
) -> Vec<&'static str> {
    let mut wrong = Vec::new();
    for (what, table) in spoilt {
        println!("{what}");
        let answer = ask_nominal(&table);
        if answer.verdict != Verdict::CheckData || !answer.summary.contains(remedy) {
            wrong.push(what);
        }
    }
    wrong
}

#[test]
fn degrees_and_reversed_signs_are_for_checking_the_data_with_a_remedy() {
    let clean = logged(&bench(5, Vec::new()));
    let spoilt = [
        ("degrees", dirt::in_degrees(clean.clone(), "q_rad_s")),
        ("both in degrees", dirt::in_degrees(dirt::in_degrees(clean.clone(), "q_rad_s"), "theta_rad")),
        ("reversed rate", dirt::reversed(clean.clone(), "q_rad_s")),
        ("reversed input", dirt::reversed(clean, "u_rad")),
    ];
    assert_eq!(not_for_checking(spoilt, "--column"), Vec::<&str>::new());
}

#[test]
fn a_channel_that_dies_is_for_checking_the_data() {
    let clean = logged(&bench(5, Vec::new()));
    let spoilt = [
        ("dead rate", dirt::dead(clean.clone(), "q_rad_s", 30.0)),
        ("dead angle", dirt::dead(clean, "theta_rad", 30.0)),
    ];
    assert_eq!(not_for_checking(spoilt, "--section"), Vec::<&str>::new());
}
