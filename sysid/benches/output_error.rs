//! Time of the grey box by maximum likelihood: one core, 3 × 1250 samples.

mod signal;

use divan::{Bencher, black_box};
use signal::{TwoLevel, uniform};
use sysid::identify::fir::Piece;
use sysid::identify::hinf_match::{MountRange, grey_box_response};
use sysid::identify::output_error::{Noise, Options, fit};
use sysid::model::plant::{Mount, Plant};

fn main() {
    divan::main();
}

const TRUTH: Plant = Plant {
    inertia: 0.1705,
    dm_dq: -0.516,
    dm_du: 25.0,
    delay: 0.06,
    mount: Some(Mount { stiffness: 1.29, damping: 6.83e-3, inertia: 2.27e-4 }),
};

/// Two-level input with switches every 20 to 40 samples, the plant's answer and white noise.
fn record(samples: usize, seed: u64) -> Option<[Vec<f64>; 2]> {
    let (mut uniform, mut input) = (uniform(seed), TwoLevel::new());
    let u: Vec<f64> = (0..samples).map(|_| input.next(&mut uniform)).collect();
    let model = grey_box_response(&TRUTH).ok()?.sampled(0.02).ok()?;
    let delayed: Vec<f64> = std::iter::repeat_n(u[0], 3).chain(u.iter().copied()).take(samples).collect();
    let y = model.simulate(&delayed, None).iter().map(|y| y + 0.07 * (uniform() - 0.5)).collect();
    Some([u, y])
}

fn run(bencher: Bencher, samples: usize, options: &Options) {
    let records: Vec<[Vec<f64>; 2]> = (1..=3).filter_map(|seed| record(samples / 3, seed)).collect();
    let free = vec![false; samples];
    let pieces: Vec<Piece> = records
        .iter()
        .enumerate()
        .map(|(run, [u, y])| Piece { u, y, supervised: &free, rows: 0..u.len(), run, step: 0.02 })
        .collect();
    let start = Plant { dm_dq: -0.27, dm_du: 23.0, delay: 0.05, ..TRUTH };
    bencher.bench_local(|| fit(black_box(&pieces), &start, options).map(|found| found.plant));
}

const ONE: Options = Options {
    output: sysid::identify::output_error::Output::Rate,
    held_input: true,
    free_delay: false,
    mount: None,
    noise: Noise::White,
    use_supervised: false,
    several_starts: false,
};

#[divan::bench(args = [3_750, 900_000], sample_count = 20, max_time = 4)]
fn one_start_damping_and_gain(bencher: Bencher, samples: usize) {
    run(bencher, samples, &ONE);
}

#[divan::bench(sample_count = 50)]
fn one_start_with_delay(bencher: Bencher) {
    run(bencher, 3_750, &Options { free_delay: true, ..ONE });
}

#[divan::bench(sample_count = 50)]
fn one_start_with_delay_and_mount(bencher: Bencher) {
    let mount = MountRange { mode_hz: [6.0, 25.0], damping_ratio: [0.05, 1.0] };
    run(bencher, 3_750, &Options { free_delay: true, mount: Some(mount), ..ONE });
}

#[divan::bench(sample_count = 20)]
fn all_starts_with_colour(bencher: Bencher) {
    let options = Options { noise: Noise::Coloured, several_starts: true, free_delay: true, ..ONE };
    run(bencher, 3_750, &options);
}
