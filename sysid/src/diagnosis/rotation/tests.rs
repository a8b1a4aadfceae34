//! Flights of which every part, or one part only, shows a term.

use super::super::data_checks::fixture::{Flight, GAIN};
use super::super::fixture::{
    asked, effects, extended, flight_with, flown_by, quarters, selection, weaker_at_first,
};
use super::super::posterior::Visited;
use super::*;

const STIFF: f64 = 0.8;
const LAST: usize = 1500;

fn stiff(_: usize, _: f64, theta: f64) -> f64 {
    -STIFF * theta.sin()
}

fn rotated<T>(flight: &Flight, ask: impl FnOnce(&Problem<'_>, &Selection, &Rotation) -> T) -> T {
    asked(flight, |problem, baseline| {
        let parts = quarters(problem);
        let selection = selection(problem, baseline, &parts, &[effects(&["gravity_stiffness"])]);
        let findings = selection.findings(problem, 1);
        let rotation = rotate(problem, &selection, 1, &findings, &parts, &|_| {});
        ask(problem, &selection, &rotation)
    })
}

#[test]
fn every_part_is_held_out_once_and_a_term_in_all_of_them_is_chosen_without_each() {
    rotated(&flight_with(1, |_, _, theta| -4.0 * theta.sin()), |problem, _, rotation| {
        let labels: Vec<&str> = rotation.parts.iter().map(|part| part.label.as_str()).collect();
        assert_eq!(labels, ["a", "b", "c", "d"]);
        for (held, part) in rotation.parts.iter().zip(quarters(problem)) {
            assert_eq!(held.places, part.places);
            assert_eq!(held.chosen, ["gravity_stiffness"]);
            assert!(held.extended.free_run > held.baseline.free_run + 1.0, "{}", held.label);
            let ahead = |scores: &Scores| scores.horizons[2].unwrap().0;
            assert!(ahead(&held.extended) > ahead(&held.baseline) + 1.0, "{}", held.label);
        }
        let gain = rotation.gain("gravity_stiffness").unwrap();
        assert_eq!(gain.chosen, 4);
        let points = rotation.parts.iter().map(|p| p.extended.free_run - p.baseline.free_run);
        assert!((gain.vaf_points.0 - points.sum::<f64>() / 4.0).abs() < 1e-9);
        assert!(gain.log_likelihood.0 > 3.0 * gain.log_likelihood.1);
        assert!(rotation.gain("servo_lag").is_none());
    });
}

#[test]
fn a_term_that_one_part_alone_shows_is_not_chosen_without_it() {
    // The servo ends at 0.009 rad, where only the last quarter's input goes.
    let u = weaker_at_first(0.5);
    let command = u.clone();
    let cut = move |k: usize, _: f64, _: f64| {
        let u = if k >= 3 { command[k - 3] } else { 0.0 };
        GAIN * (u.clamp(-0.009, 0.009) - u)
    };
    asked(&flown_by(1, u, cut), |problem, baseline| {
        let parts = quarters(problem);
        let selection = selection(problem, baseline, &parts, &[effects(&["servo_saturation"])]);
        let rotation = rotate(problem, &selection, 1, &selection.findings(problem, 1), &parts, &|_| {});
        let chosen: Vec<usize> = rotation.parts.iter().map(|part| part.chosen.len()).collect();
        assert_eq!(chosen, [1, 1, 1, 0]);
        assert_eq!(rotation.gain("servo_saturation").unwrap().chosen, 3);
        let last = &rotation.parts[3];
        assert_eq!(last.model.1, last.baseline_values, "the baseline is what was selected");
        assert_eq!(last.extended.free_run, last.baseline.free_run);
    });
}

/// Stiffness of a fit of all, its standard deviation, and that without the last part.
fn stiffness(_: &Problem<'_>, selection: &Selection, rotation: &Rotation) -> [f64; 3] {
    let minimum = &selection.visited[1].fit.minimum;
    let deviation = selection.visited[1].information.deviations(&minimum.values);
    let last = |values: &[f64]| *values.last().unwrap();
    [last(&minimum.values), last(&deviation), last(&rotation.parts[3].model.1)]
}

#[test]
fn what_the_held_out_part_holds_does_not_enter_its_model() {
    let [all, _, without] = rotated(&flight_with(1, stiff), stiffness);
    let other = |k, q, theta| if k < LAST { stiff(k, q, theta) } else { 0.5 * stiff(k, q, theta) };
    let [of_other, _, without_other] = rotated(&flight_with(1, other), stiffness);
    let (apart, entered) = ((all - of_other).abs(), (without - without_other).abs());
    assert!(apart > 0.08 && entered < 0.35 * apart, "{all} {of_other}, without it {without} {without_other}");
}

#[test]
fn the_model_without_a_part_is_near_the_one_that_is_fitted_without_it() {
    rotated(&flight_with(1, stiff), |problem, selection, rotation| {
        let Visited { information, fit, .. } = &selection.visited[1];
        let values = &fit.minimum.values;
        let deviations = information.deviations(values);
        let (mut left, mut whole) = (0.0, 0.0);
        for held in &rotation.parts {
            let rest = Problem::new(problem.data, problem.baseline, &held.places);
            let again = extended(&rest, &selection.visited[0].fit, &effects(&["gravity_stiffness"]));
            for i in (0..problem.plant_unknowns()).chain([values.len() - 1]) {
                let apart = |v: f64| ((v - again.minimum.values[i]) / deviations[i]).powi(2);
                left += apart(held.model.1[i]);
                whole += apart(values[i]);
            }
        }
        assert!(whole > 1.0 && left < 0.25 * whole, "{left} of {whole}");
    });
}

#[test]
fn the_gain_in_likelihood_is_that_of_the_covariances() {
    asked(&flight_with(1, stiff), |problem, _| {
        let wave = |i: usize, per: f64| (i as f64 * per).sin();
        let of = |size: f64| -> Vec<Vec<Output>> {
            vec![
                (0..2000)
                    .map(|k| [size * wave(k, 0.7), size * size * (wave(k, 0.3) + wave(k, 0.7))])
                    .collect(),
            ]
        };
        let (before, after) = (of(1.0), of(0.8));
        let places = &quarters(problem)[1].places;
        let blocks = gains_by_block(problem, places, &before, &after);
        // N (ln det S − ln det S'): both channels' sizes shrink, by 0.8 and 0.64.
        let expected = -2.0 * 500.0 * (0.8_f64 * 0.64).ln();
        assert!((blocks.iter().sum::<f64>() / expected - 1.0).abs() < 1e-9);
        assert_eq!(blocks.len(), 4, "500 rows at 50 Hz in blocks of 3 s");
    });
}

#[test]
fn what_the_predictor_errs_while_it_settles_is_no_terms_loss() {
    asked(&flight_with(1, stiff), |problem, _| {
        let before = vec![(0..2000).map(|k| [(k as f64 * 0.7).sin(), (k as f64 * 0.3).sin()]).collect()];
        let mut after: Vec<Vec<Output>> = before.clone();
        let settling = 50;
        after[0][..settling].fill([40.0, 40.0]);
        let first = &quarters(problem)[0].places;
        assert!(gains_by_block(problem, first, &before, &after).iter().all(|gain| *gain == 0.0));
        after[0][settling] = [40.0, 40.0];
        assert!(gains_by_block(problem, first, &before, &after)[0] < 0.0);
    });
}

#[test]
fn a_terms_gain_is_summed_over_blocks_and_averaged_over_parts() {
    let turn = |blocks: [f64; 2], vaf, motion, chosen| Turn {
        blocks: blocks.into(),
        vaf,
        motion,
        chosen,
        in_kind: true,
    };
    let turns = [turn([1.0, 3.0], [90.0, 92.0], 1.0, true), turn([5.0, 7.0], [80.0, 86.0], 1.0, false)];
    let gain = term_gain(&turns);
    // Sample deviation of 1, 3, 5, 7 is √(20/3), of 2, 6 it is √8.
    assert!((gain.log_likelihood.0 - 16.0).abs() < 1e-12);
    assert!((gain.log_likelihood.1 - 2.0 * (20.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!((gain.vaf_points.0 - 4.0).abs() < 1e-12 && (gain.vaf_points.1 - 2.0).abs() < 1e-12);
    assert_eq!((gain.chosen, gain.chosen_in_kind), (1, 2));
    assert!((gain.signed_rank - 10.0 / 30.0_f64.sqrt()).abs() < 1e-12);
    // of 10 and 20 points 8 and 14 are left, which is more than half; of a part that moves a hundred times as much, 40 of 90
    assert!(!gain.halves);
    let moving = turn([5.0, 7.0], [10.0, 60.0], 100.0, false);
    assert!(term_gain(&[turn([1.0, 3.0], [90.0, 80.0], 1.0, true), moving]).halves);
    let none = term_gain(&[]);
    assert_eq!(
        (none.log_likelihood, none.vaf_points, none.chosen, none.halves),
        ((0.0, 0.0), (0.0, 0.0), 0, false)
    );
}

#[test]
fn one_block_does_not_outweigh_all_others() {
    let mut blocks: Vec<f64> = (1..=30).map(|k| 1.0 + 0.01 * f64::from(k)).collect();
    blocks.push(-500.0);
    // ranks 1 to 30 gain, rank 31 loses
    let expected = (465.0 - 31.0) / (31.0 * 32.0 * 63.0 / 6.0_f64).sqrt();
    assert!((signed_rank(&blocks) - expected).abs() < 1e-12 && expected > 4.0);
    assert!((signed_rank(&[1.0, -2.0, 0.0]) + 1.0 / 5.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(signed_rank(&[]), 0.0);
}
