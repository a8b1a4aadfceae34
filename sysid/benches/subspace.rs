//! Time of subspace identification: one core, one record of 3 × 1250 samples.

mod signal;

use divan::{Bencher, black_box};
use signal::{TwoLevel, uniform};
use sysid::identify::block_hankel::Instruments;
use sysid::identify::fir::Piece;
use sysid::identify::pi_moesp::{Method, identify, search};

fn main() {
    divan::main();
}

/// Two-level input with switches every 20 to 40 samples, and a second-order response with noise.
fn record(samples: usize, seed: u64) -> [Vec<f64>; 2] {
    let (mut uniform, mut input, mut x) = (uniform(seed), TwoLevel::new(), [0.0; 2]);
    let (mut u, mut y) = (Vec::new(), Vec::new());
    for k in 0..samples {
        u.push(input.next(&mut uniform));
        y.push(x[0] + 0.05 * (uniform() - 0.5));
        let delayed = if k < 3 { 0.0 } else { u[k - 3] };
        x = [0.94 * x[0] + 0.02 * x[1] + 1.5 * delayed, 0.5 * x[1] + 4.0 * delayed];
    }
    [u, y]
}

fn run<T>(samples: usize, bencher: Bencher, work: impl Fn(&[Piece], &[Piece]) -> T) {
    let records = [1, 2, 3, 4].map(|seed| record(if seed == 4 { 1250 } else { samples / 3 }, seed));
    let supervised = vec![false; samples];
    let pieces: Vec<Piece> = records
        .iter()
        .enumerate()
        .map(|(run, [u, y])| Piece { u, y, supervised: &supervised, rows: 0..u.len(), run, step: 0.02 })
        .collect();
    bencher.bench_local(|| work(black_box(&pieces[..3]), &pieces[3..]));
}

#[divan::bench(args = [3_750, 375_000], sample_count = 50, max_time = 2)]
fn one_model_n4_i40(bencher: Bencher, samples: usize) {
    run(samples, bencher, |pieces, _| identify(pieces, 4, 40, &Method::default()).map(|found| found.columns));
}

#[divan::bench(args = [Instruments::PastInputs, Instruments::PastInputsAndOutputs], sample_count = 20, max_time = 3)]
fn grid_of_205_models(bencher: Bencher, instruments: Instruments) {
    let method = Method { instruments, ..Method::default() };
    run(3_750, bencher, |pieces, validation| {
        search(pieces, validation, 1..=5, 10..=50, &method).map(|grid| grid.best)
    });
}
