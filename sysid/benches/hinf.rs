//! Time of H∞ matching and of the exact norm.

use divan::{Bencher, black_box};
use nalgebra::DMatrix;
use sysid::identify::butterworth::Butterworth;
use sysid::identify::continuous::{ContinuousStateSpace, to_continuous};
use sysid::identify::hinf_match::{MountRange, hinf_match};
use sysid::identify::hinf_norm::hinf_norm;
use sysid::model::plant::{Mount, Plant};

fn main() {
    divan::main();
}

/// A model as PI-MOESP gives it: the vehicle's lag, and a pair that noise has put near the mount's mode.
fn identified() -> Option<ContinuousStateSpace> {
    let a = [-3.03, 0.0, 0.0, 0.0, -14.1, 74.2, 0.0, -74.2, -14.1];
    let b = DMatrix::from_column_slice(3, 1, &[146.0, 4.0, 9.0]);
    let c = DMatrix::from_row_slice(1, 3, &[1.0, 1.0, -0.5]);
    ContinuousStateSpace::new(DMatrix::from_row_slice(3, 3, &a), b, c, DMatrix::zeros(1, 1), 0.06).ok()
}

const START: Plant = Plant {
    inertia: 0.1705,
    dm_dq: -0.27,
    dm_du: 23.0,
    delay: 0.06,
    mount: Some(Mount { stiffness: 1.29, damping: 6.83e-3, inertia: 2.27e-4 }),
};

#[divan::bench(args = [false, true])]
fn match_with_free_mount(bencher: Bencher, free: bool) {
    let identified = identified();
    let weight = Butterworth { order: 15, cutoff: 7.0 };
    let range = MountRange { mode_hz: [8.0, 25.0], damping_ratio: [0.1, 0.7] };
    let mount = free.then_some(&range);
    bencher.bench_local(|| identified.as_ref().map(|g| hinf_match(black_box(g), &START, &weight, mount)));
}

#[divan::bench]
fn exact_norm_of_order_3(bencher: Bencher) {
    let identified = identified();
    bencher.bench_local(|| identified.as_ref().map(|g| hinf_norm(black_box(g), &[])));
}

#[divan::bench]
fn to_continuous_time_of_order_3(bencher: Bencher) {
    let sampled = identified().and_then(|g| g.sampled(0.02).ok());
    bencher.bench_local(|| sampled.as_ref().map(|model| to_continuous(black_box(model), true)));
}
