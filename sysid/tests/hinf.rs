//! H∞ matching against closed forms, brute force, laws, and the campaigns of an independent program.

mod reference;

use nalgebra::{Complex, DMatrix, Matrix2, Vector2};
use proptest::prelude::*;
use reference::{campaign, piece};
use sysid::identify::butterworth::Butterworth;
use sysid::identify::continuous::{ContinuousStateSpace, to_continuous};
use sysid::identify::hinf_match::{MountRange, grey_box_response, hinf_match};
use sysid::identify::pi_moesp::{Method, identify};
use sysid::model::plant::{Mount, Plant};
use sysid::validate::vaf::vaf;

/// The plant of the nominal campaign.
const NOMINAL: Plant = Plant {
    inertia: 0.1705,
    dm_dq: -0.516,
    dm_du: 25.0,
    delay: 0.06,
    mount: Some(Mount { stiffness: 1.29, damping: 6.83e-3, inertia: 2.27e-4 }),
};

/// The mount of a laboratory where nothing is known about it.
const ANY_MOUNT: MountRange = MountRange { mode_hz: [8.0, 25.0], damping_ratio: [0.1, 0.7] };
const PAPER: Butterworth = Butterworth { order: 15, cutoff: 7.0 };

fn response(plant: &Plant) -> ContinuousStateSpace {
    let g = grey_box_response(plant).unwrap();
    ContinuousStateSpace::new(g.a().clone(), g.b().clone(), g.c().clone(), g.d().clone(), plant.delay)
        .unwrap()
}

fn lag(gain: f64, pole: f64, delay: f64) -> ContinuousStateSpace {
    let scalar = |x| DMatrix::from_element(1, 1, x);
    ContinuousStateSpace::new(scalar(-pole), scalar(gain * pole), scalar(1.0), scalar(0.0), delay).unwrap()
}

#[test]
fn the_transfer_function_is_that_of_the_plant() {
    // eq. 10 with its four states, solved at s = jω: (q, qP, θ, θP)
    let mount = NOMINAL.mount.unwrap();
    for omega in [0.01, 1.0, 7.0, 75.0, 400.0] {
        let s = Complex::new(0.0, omega);
        let (k, c) = (Complex::from(mount.stiffness), Complex::from(mount.damping));
        let spring = k / s + c;
        let system = Matrix2::new(
            s * NOMINAL.inertia - NOMINAL.dm_dq + spring,
            -spring,
            -spring,
            s * mount.inertia + spring,
        );
        let rates =
            system.lu().solve(&Vector2::new(Complex::from(NOMINAL.dm_du), Complex::from(0.0))).unwrap();
        let found = response(&NOMINAL).frequency_response(omega).unwrap()[0];
        let expected = rates[1] * Complex::cis(-omega * NOMINAL.delay);
        assert!((found - expected).norm() < 1e-11 * expected.norm(), "{omega} {found} {expected}");
    }
}

#[test]
fn the_grey_box_is_found_in_its_own_response() {
    let start = Plant { dm_dq: -0.1, dm_du: -7.0, delay: 0.0, ..NOMINAL };
    let held = hinf_match(&response(&NOMINAL), &start, &PAPER, None).unwrap();
    assert!((held.plant.dm_dq / NOMINAL.dm_dq - 1.0).abs() < 1e-6, "{held:?}");
    assert!((held.plant.dm_du / NOMINAL.dm_du - 1.0).abs() < 1e-6 && held.relative < 1e-6);
    assert_eq!(held.plant.delay, NOMINAL.delay);
    // a weight that reaches the mount's mode shows it
    let wide = Butterworth { order: 2, cutoff: 60.0 };
    let free = hinf_match(&response(&NOMINAL), &start, &wide, Some(&ANY_MOUNT)).unwrap();
    let (found, truth) = (free.plant.mount.unwrap(), NOMINAL.mount.unwrap());
    println!("{free:?}");
    assert!(
        (found.stiffness / truth.stiffness - 1.0).abs() < 1e-3
            && (found.damping / truth.damping - 1.0).abs() < 1e-3
    );
    assert!(!free.mount_on_bound && free.relative < 1e-4);
}

#[test]
fn no_neighbour_is_better_and_the_norm_is_that_of_a_dense_grid() {
    let identified = to_continuous(&lag(40.0, 2.2, 0.06).sampled(0.02).unwrap(), true).unwrap();
    let target = ContinuousStateSpace::new(
        DMatrix::from_row_slice(2, 2, &[-2.2, 3.0, -3.0, -4.0]),
        DMatrix::from_column_slice(2, 1, &[80.0, 20.0]),
        DMatrix::from_row_slice(1, 2, &[1.0, 0.3]),
        DMatrix::zeros(1, 1),
        0.06,
    )
    .unwrap();
    for weight in [PAPER, Butterworth { order: 1, cutoff: 3.0 }, Butterworth { order: 25, cutoff: 60.0 }] {
        for identified in [&identified, &target] {
            let found = hinf_match(identified, &NOMINAL, &weight, None).unwrap();
            println!(
                "{weight:?} {:?} dense {} relative {:.4} active {:.3?}",
                found.norm, found.dense_grid, found.relative, found.active
            );
            assert!(
                found.dense_grid <= found.norm.upper && found.dense_grid >= found.norm.value * (1.0 - 1e-6)
            );
            assert!(!found.active.is_empty() && found.agreeing_starts[0] == found.agreeing_starts[1]);
            let omegas: Vec<f64> = (0..3000).map(|k| 0.03 * f64::from(k)).collect();
            let worst = |plant: &Plant| {
                let model = response(plant);
                let error = |omega: &f64| {
                    let [a, b] = [identified, &model].map(|g| g.response_without_delay(*omega).unwrap()[0]);
                    weight.gain(*omega) * (a - b).norm()
                };
                omegas.iter().map(error).fold(0.0, f64::max)
            };
            for (dq, du) in [
                (1.01, 1.0),
                (0.99, 1.0),
                (1.0, 1.01),
                (1.0, 0.99),
                (1.01, 1.01),
                (0.99, 0.99),
                (1.3, 1.2),
                (0.7, 0.8),
            ] {
                let beside =
                    Plant { dm_dq: found.plant.dm_dq * dq, dm_du: found.plant.dm_du * du, ..found.plant };
                assert!(worst(&beside) > found.norm.value * (1.0 - 1e-4), "{weight:?} {dq} {du}");
            }
        }
    }
}

#[test]
fn the_reference_is_reached() {
    let Some(recordings) = campaign("nominal") else { return };
    let pieces: Vec<_> = recordings.iter().enumerate().map(|(run, r)| piece(r, "I", run)).collect();
    let identified =
        to_continuous(&identify(&pieces, 3, 20, &Method::default()).unwrap().model, true).unwrap();
    for mount in [None, Some(&ANY_MOUNT)] {
        let found = hinf_match(&identified, &NOMINAL, &PAPER, mount).unwrap();
        let model = response(&found.plant).sampled(0.02).unwrap();
        let reached = ["IV", "II"].map(|section| {
            let piece = piece(&recordings[1], section, 1);
            vaf(&piece.y[piece.rows.clone()], &model.simulate(&piece.u[piece.rows], None))
        });
        println!("found {reached:.3?} reference [99.45, 99.74]: {found:.4?}");
        assert!((reached[0] - 99.45).abs() < 0.05 && (reached[1] - 99.74).abs() < 0.05);
        assert!((found.plant.dm_dq + 0.516).abs() < 0.01 && (found.plant.dm_du - 25.0).abs() < 0.3);
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let good = lag(40.0, 2.2, 0.06);
    let fails = |identified: &ContinuousStateSpace,
                 start: &Plant,
                 weight: Butterworth,
                 mount: Option<&MountRange>,
                 word: &str| {
        let error = hinf_match(identified, start, &weight, mount).unwrap_err().to_string();
        assert!(error.contains(word), "{word}: {error}");
    };
    fails(&good, &NOMINAL, Butterworth { order: 26, cutoff: 7.0 }, None, "order 1 to 25");
    fails(&good, &NOMINAL, Butterworth { order: 2, cutoff: f64::NAN }, None, "cutoff");
    fails(&lag(40.0, -2.2, 0.06), &NOMINAL, PAPER, None, "stable");
    fails(&lag(0.0, 2.2, 0.06), &NOMINAL, PAPER, None, "zero");
    fails(&good, &Plant { inertia: 0.0, ..NOMINAL }, PAPER, None, "positive");
    fails(&good, &Plant { mount: None, ..NOMINAL }, PAPER, Some(&ANY_MOUNT), "mount");
    let empty = MountRange { mode_hz: [9.0, 8.0], ..ANY_MOUNT };
    fails(&good, &NOMINAL, PAPER, Some(&empty), "rising");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// A first-order response is matched exactly without a mount, whatever its size, sign and delay.
    #[test]
    fn a_lag_is_a_grey_box_without_mount(gain in prop_oneof![-300.0_f64..-1.0, 1.0_f64..300.0], pole in 0.3_f64..30.0, delay in 0.0_f64..0.2) {
        let start = Plant { mount: None, ..NOMINAL };
        let found = hinf_match(&lag(gain, pole, delay), &start, &PAPER, None).unwrap();
        prop_assert!((found.plant.dm_dq / (-pole * start.inertia) - 1.0).abs() < 1e-5, "{found:?}");
        prop_assert!((found.plant.dm_du / (gain * pole * start.inertia) - 1.0).abs() < 1e-5, "{found:?}");
        prop_assert_eq!(found.plant.delay, delay);
    }

    /// The logarithm undoes the exponential.
    #[test]
    fn sampled_and_back(entries in prop::collection::vec(-4.0_f64..4.0, 9), b in prop::collection::vec(-100.0_f64..100.0, 3), shift in 0.0_f64..20.0) {
        let a = DMatrix::from_row_slice(3, 3, &entries) - DMatrix::identity(3, 3) * shift;
        let c = DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0]);
        let b = DMatrix::from_column_slice(3, 1, &b);
        let system = ContinuousStateSpace::new(a.clone(), b.clone(), c, DMatrix::zeros(1, 1), 0.04).unwrap();
        let back = to_continuous(&system.sampled(0.02).unwrap(), true).unwrap();
        prop_assert!((back.a() - &a).amax() < 1e-8 * (1.0 + a.amax()), "{}", back.a() - &a);
        prop_assert!((back.b() - &b).amax() < 1e-8 * (1.0 + b.amax()), "{}", back.b() - &b);
        prop_assert!((back.delay() - 0.04).abs() < 1e-15);
    }
}
