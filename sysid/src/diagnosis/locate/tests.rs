//! Mismatches put into a known time, band and variable.

use super::super::data_checks::fixture::{STEP, flight};
use super::super::fixture::{asked, flight_with, flown_by, quarters};
use super::*;

#[test]
fn the_power_of_a_line_is_that_of_its_taper_and_lies_at_its_frequency() {
    let (n, omega) = (1000, 0.3);
    let line: Vec<f64> = (0..n).map(|k| 5.0 + 2.0 * (omega * k as f64).cos()).collect();
    // A half sine over n samples sums to 2 n / π, and half of the line's amplitude turns with the frequency.
    let expected = (2.0 * n as f64 / std::f64::consts::PI).powi(2);
    assert!((fourier_power(&line, omega) / expected - 1.0).abs() < 0.01);
    assert!(fourier_power(&line, 3.0 * omega) < 1e-4 * expected);
}

#[test]
fn a_ramp_over_classes_explains_all_but_what_a_class_holds() {
    let n: usize = 1200;
    let values: Vec<f64> = (0..n).map(|k| ((k * 7919) % n) as f64).collect();
    let ramp: Vec<f64> = values.iter().map(|v| 0.5 - 2.0 * v).collect();
    let independent = 600.0;
    let found = dependence("v", "1".into(), &values, &ramp, independent);
    // Variances of 100 and of 1200 even steps.
    let within = (100.0_f64.powi(2) - 1.0) / ((n * n) as f64 - 1.0);
    assert!((found.share - (1.0 - within - 11.0 / independent)).abs() < 1e-9, "{}", found.share);
    assert_eq!(found.classes.len(), 12);
    for (i, [value, moment, error]) in found.classes.iter().enumerate() {
        let middle = 100.0 * i as f64 + 49.5;
        assert!((value - middle).abs() < 1e-9 && (moment - (0.5 - 2.0 * middle)).abs() < 1e-9);
        let spread = 2.0 * ((100.0_f64.powi(2) - 1.0) / 12.0).sqrt();
        assert!((error - spread / 50.0_f64.sqrt()).abs() < 1e-9, "half of 100 samples are independent");
    }
    let rows: Vec<f64> = (0..n).map(|k| k as f64).collect();
    assert!(dependence("row", "1".into(), &rows, &ramp, independent).share < 0.02);
}

#[test]
fn a_missing_moment_is_found_on_its_variable() {
    asked(&flight_with(1, |_, _, theta| -1.5 * theta.sin()), |problem, fit| {
        let all = dependences(problem, fit);
        assert_eq!(all[0].variable, "theta");
        assert!(all[0].share > 0.3 && all[0].share > 2.0 * all[1].share, "{} {}", all[0].share, all[1].share);
        let (low, high) = (all[0].classes[0], all[0].classes[11]);
        assert!(low[0] < 0.0 && low[1] > 0.0 && high[0] > 0.0 && high[1] < 0.0, "it pulls back");
    });
    asked(&flight(1, 0.0), |problem, fit| {
        let shares: Vec<f64> = dependences(problem, fit).iter().map(|d| d.share).collect();
        assert!(shares.len() == 5 && shares.iter().all(|share| *share < 0.15), "{shares:?}");
    });
}

/// `fit` with residuals `factor` times as large from `begin` to `end`, s.
fn worse(problem: &Problem<'_>, fit: &Fit, [begin, end]: [f64; 2], factor: f64) -> Fit {
    let mut worse = fit.clone();
    let times = counted_times(problem);
    for (e, t) in worse.minimum.residuals.iter_mut().zip(times) {
        if (begin..end).contains(&t) {
            *e = e.map(|e| factor * e);
        }
    }
    worse
}

#[test]
fn a_gain_in_one_stretch_of_time_is_found_there_and_an_even_one_everywhere() {
    asked(&flight(1, 0.0), |problem, fit| {
        let [[from, to]] = time_windows(problem, &worse(problem, fit, [10.0, 15.0], 1.6), fit)[..] else {
            panic!("one window")
        };
        assert!((9.0..11.0).contains(&from) && (13.0..=16.0).contains(&to), "{from} {to}");
        let whole = [[1.0, 39.98]];
        let near = |windows: Vec<[f64; 2]>| {
            let ends = windows[0].iter().zip(&whole[0]).all(|(a, b)| (a - b).abs() < 1e-9);
            windows.len() == 1 && ends
        };
        assert!(near(time_windows(problem, &worse(problem, fit, [0.0, 40.0], 1.6), fit)));
        assert!(near(time_windows(problem, fit, fit)));
    });
}

#[test]
fn models_that_predict_alike_are_indistinct_and_one_that_is_worse_everywhere_is_not() {
    asked(&flight(1, 0.0), |problem, fit| {
        assert_eq!(indistinct(problem, fit, fit), 0.5);
        let other = worse(problem, fit, [10.0, 15.0], 1.6);
        let (odds, against) = (indistinct(problem, fit, &other), indistinct(problem, &other, fit));
        assert!((odds + against - 1.0).abs() < 1e-12);
        assert!((0.01..0.3).contains(&odds), "one stretch in eight blocks may be chance: {odds}");
        assert!(indistinct(problem, fit, &worse(problem, fit, [0.0, 40.0], 1.6)) < 1e-12);
    });
}

#[test]
fn the_band_is_where_the_input_makes_the_free_runs_differ() {
    let omega = 6.0;
    let u = (0..2000).map(|k| 0.015 * (omega * STEP * f64::from(k)).sin()).collect();
    asked(&flown_by(1, u, |_, _, _| 0.0), |problem, fit| {
        let places: Vec<Place> = quarters(problem).into_iter().flat_map(|part| part.places).collect();
        let mut stronger = fit.clone();
        stronger.minimum.values[1] *= 1.3;
        let [low, high] = band(problem, fit, &stronger, &places).unwrap();
        assert!((4.5..=6.5).contains(&low) && (5.5..8.0).contains(&high), "{low} {high}");
        assert!(band(problem, fit, fit, &places).is_none());
    });
}
