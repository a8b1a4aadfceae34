//! Flights, and what a model of known values would have flown.

use super::*;
use crate::dataset::Dataset;
use crate::diagnosis::data_checks::fixture::{GAIN, fitted, flight, model};

fn place(rows: core::ops::Range<usize>) -> Place {
    Place { label: format!("{rows:?}"), run: 0, rows }
}

/// Asks for a flight, its baseline's fit, and the same data as the fitted model itself flies them without noise.
fn asked<T>(ask: impl FnOnce(&Problem<'_>, &Fit, &Dataset) -> T) -> T {
    fitted(&flight(1, 0.0).recording(), &model(GAIN, 0.06), |_, problem, fit| {
        let unpacked = problem.unpack(&[], &fit.minimum.values);
        let run = &problem.data.runs[0];
        let sampled = problem.model(&unpacked, run.step).unwrap();
        let outputs = sampled.simulate(run, 0..run.len(), sampled.start(run)).unwrap();
        let mut flown = problem.data.clone();
        flown.runs[0].rate = Some(outputs.iter().map(|y| y[0]).collect());
        flown.runs[0].angle = Some(outputs.iter().map(|y| y[1]).collect());
        ask(problem, fit, &flown)
    })
}

#[test]
fn a_model_accounts_for_all_of_what_it_flew_itself_from_wherever_it_starts() {
    asked(|problem, fit, flown| {
        let own = Problem::new(flown, problem.baseline, &[]);
        let unpacked = own.unpack(&[], &fit.minimum.values);
        let places = [place(0..700), place(700..1234), place(1500..2000)];
        let vafs = vaf_by_place(&own, &unpacked, &places);
        assert!(vafs.iter().all(|vaf| *vaf > 100.0 - 1e-9), "{vafs:?}");
        assert!(vaf_over(&own, &unpacked, &places) > 100.0 - 1e-9);
        let free = free_run(&own, &unpacked, &places[1..2]).unwrap();
        let rate = &flown.runs[0].rate.as_ref().unwrap()[700..1234];
        assert!(free[0].iter().zip(rate).all(|(a, b)| (a - b).abs() < 1e-9));
    });
}

#[test]
fn places_together_are_weighed_by_their_length_and_variance() {
    asked(|problem, fit, _| {
        let unpacked = problem.unpack(&[], &fit.minimum.values);
        let places = [place(100..400), place(900..2000)];
        let apart = vaf_by_place(problem, &unpacked, &places);
        assert!(apart.iter().all(|vaf| (1.0..99.9).contains(vaf)) && apart[0] != apart[1], "{apart:?}");
        let weight = |p: &Place| p.rows.len() as f64 * variance(problem.data.judged(p));
        let weights = [weight(&places[0]), weight(&places[1])];
        let mean = (weights[0] * apart[0] + weights[1] * apart[1]) / (weights[0] + weights[1]);
        assert!((vaf_over(problem, &unpacked, &places) - mean).abs() < 1e-9);
        assert!((vaf_over(problem, &unpacked, &places[..1]) - apart[0]).abs() < 1e-9);
    });
}

#[test]
fn a_model_that_diverges_accounts_for_nothing() {
    asked(|problem, fit, _| {
        let mut unpacked = problem.unpack(&[], &fit.minimum.values);
        unpacked.plant.dm_dq = 20.0;
        let places = [place(0..1000), place(1000..2000)];
        assert!(free_run(problem, &unpacked, &places).is_none());
        assert_eq!(vaf_by_place(problem, &unpacked, &places), [0.0, 0.0]);
        assert_eq!(vaf_over(problem, &unpacked, &places), 0.0);
    });
}

#[test]
fn a_refit_finds_the_plant_that_flew_and_leaves_the_noise_alone() {
    asked(|problem, fit, flown| {
        let own = Problem::new(flown, problem.baseline, &[]);
        let mut off = fit.clone();
        off.minimum.values[0] *= 1.3;
        off.minimum.values[1] *= 0.9;
        let found = refit_for_simulation(&own, &off, &[place(0..2000)]).unwrap();
        for i in 0..2 {
            let (found, flew) = (found.values[i], fit.minimum.values[i]);
            assert!((found / flew - 1.0).abs() < 1e-3, "{found} {flew}");
        }
        let noise = own.noise_range();
        for (held, before) in found.values[noise.clone()].iter().zip(&off.minimum.values[noise]) {
            assert!((held / before - 1.0).abs() < 1e-12);
        }
    });
}

#[test]
fn an_offset_of_the_measurement_is_no_error_of_a_section() {
    asked(|problem, fit, flown| {
        let places = [place(0..1000), place(1000..2000)];
        let own = Problem::new(flown, problem.baseline, &[]);
        let unpacked = own.unpack(&[], &fit.minimum.values);
        let points = starting_points(&own, &unpacked, &places).unwrap();
        let mut shifted = flown.clone();
        for q in shifted.runs[0].rate.iter_mut().flatten() {
            *q += 0.25;
        }
        let shifted = Problem::new(&shifted, problem.baseline, &[]);
        let errors = output_errors(&shifted, fit, &places, &points)(&fit.minimum.values).unwrap();
        assert_eq!(errors.len(), 2000);
        assert!(errors.iter().all(|e| e[0].abs() < 1e-9 && e[1] == 0.0));
    });
}
