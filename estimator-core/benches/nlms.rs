//! One NLMS update: prediction, adaptation, push of the next input. Run: `cargo bench -p estimator-core`.

use divan::{Bencher, black_box};
use estimator_core::lms::{LmsConfig, LmsState};

fn main() {
    divan::main();
}

#[divan::bench(consts = [16, 32, 64, 128, 256])]
fn nlms_update<const N: usize>(bencher: Bencher<'_, '_>) {
    let Ok(lms) = (LmsConfig { taps: N as u16, ..LmsConfig::default() }).build::<N>() else { return };
    let mut state = LmsState::default();
    let mut u = 0.015_f32;
    bencher.bench_local(move || {
        let update = lms.observe(&mut state, black_box(0.3), true);
        u = -u;
        lms.push(&mut state, black_box(u));
        update.error
    });
}
