//! Time of the methods on the sizes that recordings have.

mod signal;

use divan::{Bencher, black_box};
use estimator_core::convergence::ConvergenceConfig;
use estimator_core::lms::LmsConfig;
use signal::{TwoLevel, uniform};
use sysid::identify::fir::{FirOptions, Piece, fit};
use sysid::identify::{kung, lms};

fn main() {
    divan::main();
}

/// Two-level input with switches every 20 to 40 samples, and a first-order response with a little noise.
fn campaign(samples: usize) -> [Vec<f64>; 2] {
    let (mut uniform, mut input, mut rate) = (uniform(1), TwoLevel::new(), 0.0);
    let (mut u, mut q) = (Vec::new(), Vec::new());
    for _ in 0..samples {
        let level = input.next(&mut uniform);
        q.push(rate + 0.02 * (uniform() - 0.5));
        u.push(level);
        rate = 0.95 * rate + 2.0 * level;
    }
    [u, q]
}

fn piece<'a>([u, q]: &'a [Vec<f64>; 2], supervised: &'a [bool]) -> Piece<'a> {
    Piece { u, y: q, supervised, rows: 0..u.len(), run: 0, step: 0.02 }
}

#[divan::bench(args = [(3_750, 60), (900_000, 100)], sample_count = 5)]
fn least_squares_fir(bencher: Bencher, (samples, taps): (usize, usize)) {
    let (signals, supervised) = (campaign(samples), vec![false; samples]);
    let options = FirOptions { taps, first_lag: 4, use_supervised: false };
    bencher.bench_local(|| fit(black_box(&[piece(&signals, &supervised)]), &options));
}

#[divan::bench]
fn nlms_60_taps_3750_samples(bencher: Bencher) {
    let (signals, supervised) = (campaign(3750), vec![false; 3750]);
    let (config, thresholds) = (LmsConfig::default(), ConvergenceConfig::default());
    bencher
        .bench_local(|| lms::replay::<60>(black_box(&[piece(&signals, &supervised)]), &config, &thresholds));
}

#[divan::bench]
fn kung_60_taps(bencher: Bencher) {
    let (signals, supervised) = (campaign(3750), vec![false; 3750]);
    let options = FirOptions { taps: 60, first_lag: 4, use_supervised: false };
    let fir = fit(&[piece(&signals, &supervised)], &options).map(|found| found.fir);
    bencher.bench_local(|| fir.as_ref().map(|fir| kung::realise(black_box(fir), None)));
}

#[divan::bench]
fn simulate_order_4_1250_samples(bencher: Bencher) {
    let (signals, supervised) = (campaign(3750), vec![false; 3750]);
    let options = FirOptions { taps: 60, first_lag: 4, use_supervised: false };
    let model = fit(&[piece(&signals, &supervised)], &options)
        .and_then(|found| kung::realise(&found.fir, Some(4)))
        .map(|found| found.model);
    bencher.bench_local(|| model.as_ref().map(|model| model.simulate(black_box(&signals[0][..1250]), None)));
}
