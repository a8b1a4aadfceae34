//! The campaigns of an independent program, and the figures that it reached (`data/reference/README.md`).

mod reference;

use estimator_core::convergence::ConvergenceConfig;
use estimator_core::lms::LmsConfig;
use reference::{campaign, joined};
use sysid::dataset::Dataset;
use sysid::identify::fir::{Fir, FirOptions, Piece, ceiling_vaf, fit, pieces};
use sysid::identify::kung::realise;
use sysid::identify::lms::replay;
use sysid::recording::Recording;
use sysid::validate::vaf::vaf;

/// Input and pitch rate of sections IV and II of the 15 mrad recording.
fn validation(recordings: &[Recording]) -> [[&[f64]; 2]; 2] {
    ["IV", "II"].map(|label| {
        let rows = recordings[1].section(label).unwrap().rows.clone();
        [&recordings[1].u[rows.clone()], &recordings[1].q.as_deref().unwrap()[rows]]
    })
}

fn score(simulate: impl Fn(&[f64]) -> Vec<f64>, recordings: &[Recording]) -> [f64; 2] {
    validation(recordings).map(|[u, q]| vaf(q, &simulate(u)))
}

/// The on-board estimator with the reference's step, started from rest as the reference is.
fn lms_from_rest(recordings: &[Recording]) -> Fir {
    let [mut u, mut q] = joined(recordings);
    // rest before the first sample, so that the window is known from there on
    u.splice(0..0, [0.0; 63]);
    q.splice(0..0, [0.0; 63]);
    let supervised = vec![false; u.len()];
    let piece = Piece { u: &u, y: &q, supervised: &supervised, rows: 63..u.len(), run: 0, step: 0.02 };
    let lms = LmsConfig { step: 0.03, leakage: 0.0, regularisation_rad2: 1e-12, input_delay: 3, taps: 60 };
    let found = replay::<60>(&[piece], &lms, &ConvergenceConfig::default()).unwrap();
    println!("{:?}", found.convergence);
    found.fir
}

fn near(found: [f64; 2], expected: [f64; 2], tolerance: f64) {
    println!("found {found:.3?} reference {expected:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= tolerance, "{found} {expected}");
    }
}

#[test]
fn lms_reaches_the_reference() {
    for (kind, expected) in [("nominal", [99.39, 99.69]), ("realistic", [62.08, 79.88])] {
        let Some(recordings) = campaign(kind) else { return };
        let fir = lms_from_rest(&recordings);
        near(score(|u| fir.simulate(u), &recordings), expected, 0.02);
    }
}

#[test]
fn kung_reaches_the_reference() {
    for (kind, expected) in [("nominal", Some([99.42, 99.70])), ("realistic", None)] {
        let Some(recordings) = campaign(kind) else { return };
        let fir = lms_from_rest(&recordings);
        for order in [None, Some(1), Some(2), Some(3), Some(4), Some(5)] {
            let found = realise(&fir, order).unwrap();
            let reached = score(|u| found.model.simulate(u, None), &recordings);
            println!("{kind} {}: {reached:.3?} {:.4?}", found.reason, found.model.poles());
            if order.is_none() {
                println!("{:.3?}", &found.singular_values[..7]);
            }
            assert_eq!(found.stable, found.model.is_stable());
            assert!(order.is_some() || found.stable, "{}", found.reason);
            if let (Some(2), Some(expected)) = (order, expected) {
                near(reached, expected, 0.02);
            }
        }
    }
}

#[test]
fn sections_as_the_data_set_has_them() {
    for kind in ["nominal", "realistic"] {
        let Some(recordings) = campaign(kind) else { return };
        let data = Dataset::new(&recordings).unwrap();
        let places: Vec<_> = data.places().into_iter().filter(|place| place.label.ends_with(":I")).collect();
        let pieces = pieces(&data, &places).unwrap();
        let lms = LmsConfig { step: 0.03, ..LmsConfig::default() };
        let replayed = replay::<60>(&pieces, &lms, &ConvergenceConfig::default()).unwrap();
        let fitted = fit(&pieces, &FirOptions { taps: 60, first_lag: 4, use_supervised: false }).unwrap();
        let by_lms = score(|u| replayed.fir.simulate(u), &recordings);
        let by_fir = score(|u| fitted.fir.simulate(u), &recordings);
        let ceiling = validation(&recordings).map(|[u, q]| ceiling_vaf(u, q, 60).unwrap());
        println!(
            "{kind}: LMS {by_lms:.3?} {:?}, {} of {}",
            replayed.convergence,
            replayed.updates,
            replayed.updates + replayed.left_out
        );
        println!(
            "{kind}: FIR {by_fir:.3?}, noise {:.4}, {} rows; ceiling {ceiling:.3?}",
            fitted.noise, fitted.rows
        );
        println!("  taps {:.3?}\n  +- {:.3?}", &fitted.fir.taps[..8], &fitted.deviations[..8]);
        for (model, ceiling) in by_fir.iter().zip(ceiling) {
            assert!(model <= &ceiling);
        }
    }
}
