//! Impulse responses by least squares and by the core's LMS, on data whose truth is known.

use estimator_core::convergence::{ConvergenceConfig, Verdict};
use estimator_core::lms::LmsConfig;
use proptest::prelude::*;
use sysid::identify::fir::{Fir, FirOptions, Piece, ceiling_vaf, fit};
use sysid::identify::lms::replay;

/// Uniform on [−1, 1], Knuth's MMIX generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
    fn take(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.next()).collect()
    }
}

fn decaying(taps: usize, first_lag: usize) -> Fir {
    let taps = (0..taps).map(|i| 2.0 * (-0.1 * i as f64).exp() * (0.2 * i as f64).cos()).collect();
    Fir { taps, first_lag, step: 0.02 }
}

fn whole<'a>(run: usize, u: &'a [f64], y: &'a [f64], supervised: &'a [bool]) -> Piece<'a> {
    Piece { u, y, supervised, rows: 0..u.len(), run, step: 0.02 }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

#[test]
fn exact_taps_and_offsets_from_several_sections_with_unknown_past() {
    let truth = decaying(20, 3);
    let mut noise = Noise(1);
    // the first 50 inputs are cut off: rows whose window they fill must be left out
    let runs: Vec<(Vec<f64>, Vec<f64>)> = [0.3, -0.7]
        .iter()
        .map(|offset| {
            let u: Vec<f64> = noise.take(600).iter().map(|u| u + 4.0).collect();
            let y: Vec<f64> = truth.simulate(&u).iter().map(|y| y + offset).collect();
            (u[50..].to_vec(), y[50..].to_vec())
        })
        .collect();
    let no = vec![false; 550];
    let pieces = [whole(0, &runs[0].0, &runs[0].1, &no), whole(1, &runs[1].0, &runs[1].1, &no)];
    let found = fit(&pieces, &FirOptions { taps: 20, first_lag: 3, use_supervised: false }).unwrap();
    assert_eq!(found.rows, 2 * (550 - 22));
    assert!(largest_difference(&found.fir.taps, &truth.taps) < 1e-7);
    assert!(largest_difference(&found.offsets, &[0.3, -0.7]) < 1e-6);
    assert!(found.noise < 1e-7 && found.deviations.iter().all(|d| d.is_finite()));
}

#[test]
fn a_section_inside_a_run_reaches_back_for_its_inputs() {
    let truth = decaying(12, 1);
    let u = Noise(2).take(300);
    let y = truth.simulate(&u);
    let no = vec![false; 300];
    let piece = Piece { rows: 100..200, ..whole(0, &u, &y, &no) };
    let found = fit(&[piece], &FirOptions { taps: 12, first_lag: 1, use_supervised: false }).unwrap();
    assert_eq!(found.rows, 100);
    assert!(largest_difference(&found.fir.taps, &truth.taps) < 1e-7);
}

#[test]
fn supervised_rows_leave_the_rows_but_not_the_regressor() {
    let truth = decaying(15, 2);
    let u = Noise(3).take(800);
    let mut y = truth.simulate(&u);
    let supervised: Vec<bool> = (0..800).map(|k| k % 97 < 20 || k == 333).collect();
    for (y, _) in y.iter_mut().zip(&supervised).filter(|(_, s)| **s) {
        *y += 3.0;
    }
    let pieces = [whole(0, &u, &y, &supervised)];
    let options = FirOptions { taps: 15, first_lag: 2, use_supervised: false };
    let kept = fit(&pieces, &options).unwrap();
    assert_eq!(kept.rows, (16..800).filter(|&k| !supervised[k]).count());
    assert!(largest_difference(&kept.fir.taps, &truth.taps) < 1e-7);
    let all = fit(&pieces, &FirOptions { use_supervised: true, ..options }).unwrap();
    assert!(largest_difference(&all.fir.taps, &truth.taps) > 0.01);
}

#[test]
fn standard_errors_hold_under_coloured_noise() {
    let (taps, trials) = (10, 200);
    let truth = decaying(taps, 1);
    let mut noise = Noise(4);
    let (mut squares, mut beyond) = (0.0, 0);
    for _ in 0..trials {
        let (mut level, mut gust) = (1.0, 0.0);
        let u: Vec<f64> = (0..1500)
            .map(|_| {
                if noise.next() > 0.7 {
                    level = -level;
                }
                level
            })
            .collect();
        let mut y = truth.simulate(&u);
        for y in &mut y {
            gust = 0.8 * gust + noise.next();
            *y += gust;
        }
        let no = vec![false; u.len()];
        let found = fit(&[whole(0, &u, &y, &no)], &FirOptions { taps, first_lag: 1, use_supervised: false });
        let found = found.unwrap();
        for ((w, truth), deviation) in found.fir.taps.iter().zip(&truth.taps).zip(&found.deviations) {
            let z = (w - truth) / deviation;
            squares += z * z;
            beyond += usize::from(z.abs() > 1.96);
        }
    }
    let count = (taps * trials) as f64;
    let (spread, outside) = ((squares / count).sqrt(), beyond as f64 / count);
    println!("z: standard deviation {spread:.3}, outside 95 %: {outside:.3}");
    assert!((0.9..1.15).contains(&spread), "{spread}");
    assert!((0.03..0.09).contains(&outside), "{outside}");
}

#[test]
fn the_ceiling_is_full_without_noise_and_the_signal_share_with_it() {
    let truth = decaying(20, 1);
    let mut noise = Noise(5);
    let u = noise.take(3000);
    let mut y = truth.simulate(&u);
    assert!(ceiling_vaf(&u, &y, 20).unwrap() > 99.999_999);
    let signal = sysid::validate::vaf::variance(&y);
    y.iter_mut().for_each(|y| *y += 3.0 * noise.next());
    let share = 100.0 * signal / (signal + 3.0);
    assert!((ceiling_vaf(&u, &y, 20).unwrap() - share).abs() < 2.0, "{share}");
}

#[test]
fn bad_input_is_an_error() {
    let (u, no) = (Noise(6).take(100), vec![false; 100]);
    let options = FirOptions { taps: 20, first_lag: 1, use_supervised: false };
    let refused = |u: &[f64], options: FirOptions| fit(&[whole(0, u, u, &no)], &options).is_err();
    assert!(!refused(&u, options));
    assert!(refused(&u, FirOptions { taps: 0, ..options }));
    assert!(refused(&u, FirOptions { taps: 60, ..options }), "too few rows");
    assert!(refused(&u, FirOptions { first_lag: 500, ..options }));
    assert!(refused(&u, FirOptions { first_lag: usize::MAX, ..options }));
    assert!(refused(&[f64::NAN; 100], options) && refused(&[1e200; 100], options));
    assert!(refused(&[0.0; 100], options), "no input");
    assert!(refused(&[2.5; 100], options), "constant input");
    assert!(fit(&[], &options).is_err());
    let other = Piece { step: 0.01, ..whole(1, &u, &u, &no) };
    assert!(fit(&[whole(0, &u, &u, &no), other], &options).is_err());
}

#[test]
fn lms_finds_known_taps_and_says_that_it_did() {
    let truth = decaying(16, 4);
    let mut noise = Noise(7);
    let u: Vec<f64> = noise.take(6000).iter().map(|u| 0.02 * u + 0.01).collect();
    let y = truth.simulate(&u);
    let no = vec![false; u.len()];
    let lms = LmsConfig { step: 0.3, input_delay: 3, ..LmsConfig::default() };
    let found = replay::<16>(&[whole(0, &u, &y, &no)], &lms, &ConvergenceConfig::default()).unwrap();
    assert_eq!((found.fir.first_lag, found.updates, found.left_out), (4, 6000 - 19, 19));
    assert!(largest_difference(&found.fir.taps, &truth.taps) < 1e-3);
    assert_eq!(found.convergence.verdict, Verdict::Converged, "{:?}", found.convergence);
}

#[test]
fn lms_leaves_supervised_rows_and_rows_between_sections_alone() {
    let truth = decaying(16, 1);
    let u: Vec<f64> = Noise(8).take(6000).iter().map(|u| 0.02 * u + 0.01).collect();
    let mut y = truth.simulate(&u);
    let mut supervised = vec![false; u.len()];
    supervised[3000..3200].fill(true);
    y[3000..3200].fill(9.0);
    y[4000..4500].fill(-9.0);
    let section = |rows| Piece { rows, ..whole(0, &u, &y, &supervised) };
    let lms = LmsConfig { step: 0.3, input_delay: 0, ..LmsConfig::default() };
    let pieces = [section(4500..5500), section(500..4000)];
    let found = replay::<16>(&pieces, &lms, &ConvergenceConfig::default()).unwrap();
    assert_eq!((found.updates, found.left_out), (4300, 200));
    assert!(largest_difference(&found.fir.taps, &truth.taps) < 1e-3);
    let error = replay::<16>(&pieces, &LmsConfig { step: 2.5, ..lms }, &ConvergenceConfig::default());
    assert!(error.unwrap_err().to_string().contains("lms.step"));
    let huge = vec![1e300; 6000];
    let wild = [Piece { y: &huge, ..section(0..6000) }];
    assert!(replay::<16>(&wild, &lms, &ConvergenceConfig::default()).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    /// The correlations along the diagonals give what the plain normal equations give.
    #[test]
    fn agrees_with_the_plain_normal_equations(
        seed in any::<u64>(), taps in 1_usize..12, first_lag in 0_usize..4, hole in 30_usize..60, start in 0_usize..40,
    ) {
        let mut noise = Noise(seed);
        let (u, y) = (noise.take(120), noise.take(120));
        let supervised: Vec<bool> = (0..120).map(|k| (hole..hole + 9).contains(&k) || k % 31 == 0).collect();
        let piece = Piece { rows: start..120, ..whole(0, &u, &y, &supervised) };
        let found = fit(&[piece], &FirOptions { taps, first_lag, use_supervised: false }).unwrap();
        let rows: Vec<usize> = (start.max(taps + first_lag - 1)..120).filter(|&k| !supervised[k]).collect();
        let phi = nalgebra::DMatrix::from_fn(rows.len(), taps + 1, |r, i| {
            if i == taps { 1.0 } else { u[rows[r] - first_lag - i] }
        });
        let target = nalgebra::DVector::from_fn(rows.len(), |r, _| y[rows[r]]);
        let (q, r) = phi.qr().unpack();
        let plain = r.solve_upper_triangular(&q.tr_mul(&target)).unwrap();
        prop_assert_eq!(found.rows, rows.len());
        prop_assert!(largest_difference(&found.fir.taps, &plain.as_slice()[..taps]) < 1e-6);
        prop_assert!((found.offsets[0] - plain[taps]).abs() < 1e-6);
    }
}
