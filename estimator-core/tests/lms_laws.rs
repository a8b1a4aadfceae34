//! Laws of the estimator that hold for every input.

use estimator_core::lms::{LmsConfig, LmsState, NormalizedLms};
use proptest::prelude::*;

const N: usize = 19;

fn build(step: f32, regularisation_rad2: f32, input_delay: u8) -> NormalizedLms<N> {
    LmsConfig { step, regularisation_rad2, input_delay, leakage: 0.0, taps: N as u16 }.build().unwrap()
}

fn squared_distance(a: &[f32; N], b: &[f32; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
}

/// Output of the FIR `taps` that u[..k] has caused in y[k], behind `delay`.
fn output(taps: &[f32; N], u: &[f32], k: usize, delay: usize) -> f32 {
    let input = |i: usize| (k.checked_sub(1 + delay + i)).map_or(0.0, |j| u[j]);
    taps.iter().enumerate().map(|(i, h)| h * input(i)).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Without noise the distance to the true taps never grows (Haykin, section 6.3), whatever the input and 0
    /// < μ < 2.
    #[test]
    fn the_distance_to_the_truth_never_grows_inside_the_step_bound(
        step in 0.001_f32..1.999,
        truth in prop::array::uniform19(-5.0_f32..5.0),
        u in prop::collection::vec(-0.05_f32..0.05, 200),
        delay in 0_usize..=15,
    ) {
        let lms = build(step, 1e-6, delay as u8);
        let mut state = LmsState::default();
        let mut last = squared_distance(state.taps(), &truth);
        for (k, &now) in u.iter().enumerate() {
            lms.observe(&mut state, output(&truth, &u, k, delay), true);
            let distance = squared_distance(state.taps(), &truth);
            prop_assert!(distance <= last * (1.0 + 1e-4) + 1e-6, "{last} -> {distance}");
            last = distance;
            lms.push(&mut state, now);
        }
    }

    /// Two-level and noise-driven inputs alike: bounded outputs give bounded taps.
    #[test]
    fn taps_stay_bounded_with_any_bounded_output(
        step in 0.001_f32..1.999,
        data in prop::collection::vec((-0.05_f32..0.05, -1.0_f32..1.0), 400),
    ) {
        let lms = build(step, 1e-4, 3);
        let mut state = LmsState::default();
        for (u, q) in data {
            let update = lms.observe(&mut state, q, true);
            prop_assert!(update.error.is_finite());
            lms.push(&mut state, u);
        }
        // |Δw| = μ |e| |φ| / (ε + |φ|²) ≤ μ |e| / (2 √ε) = 100 |e|, and 400 of them
        prop_assert!(state.taps().iter().all(|w| w.abs() < 1e5));
    }

    /// Powers of two scale without rounding: input times s, output times r, ε times s² gives taps times r / s,
    /// bit for bit.
    #[test]
    fn scaling_input_and_output_scales_the_taps(
        exponents in (-4_i32..5, -4_i32..5),
        data in prop::collection::vec((-0.05_f32..0.05, -1.0_f32..1.0), 120),
    ) {
        let (s, r) = (2.0_f32.powi(exponents.0), 2.0_f32.powi(exponents.1));
        let (plain, scaled) = (build(0.3, 1e-3, 2), build(0.3, 1e-3 * s * s, 2));
        let (mut a, mut b) = (LmsState::default(), LmsState::default());
        for (u, q) in data {
            plain.observe(&mut a, q, true);
            scaled.observe(&mut b, q * r, true);
            plain.push(&mut a, u);
            scaled.push(&mut b, u * s);
        }
        for (a, b) in a.taps().iter().zip(b.taps()) {
            prop_assert!((a * (r / s) - b).abs() <= 1e-5 * b.abs().max(1e-3));
        }
    }

    /// White input, no noise: the taps arrive.
    #[test]
    fn converges_to_known_taps(
        step in 0.2_f32..1.5,
        truth in prop::array::uniform19(-5.0_f32..5.0),
        u in prop::collection::vec(prop::bool::ANY, 1500),
    ) {
        let lms = build(step, 1e-8, 1);
        let u: Vec<f32> = u.into_iter().map(|high| if high { 0.015 } else { -0.015 }).collect();
        let mut state = LmsState::default();
        for (k, &now) in u.iter().enumerate() {
            lms.observe(&mut state, output(&truth, &u, k, 1), true);
            lms.push(&mut state, now);
        }
        prop_assert!(squared_distance(state.taps(), &truth) < 0.01, "{:?}", state.taps());
    }

    /// A length below the capacity gives the bits of that very capacity, and leaves the rest alone.
    #[test]
    fn the_capacity_does_not_show(
        data in prop::collection::vec((-0.05_f32..0.05, -1.0_f32..1.0), 100),
        delay in 0_u8..=15,
    ) {
        let config = LmsConfig { step: 0.4, input_delay: delay, taps: N as u16, ..LmsConfig::default() };
        let (exact, roomy) = (config.build::<N>().unwrap(), config.build::<64>().unwrap());
        let (mut a, mut b) = (LmsState::default(), LmsState::default());
        for (u, q) in data {
            prop_assert_eq!(exact.observe(&mut a, q, true), roomy.observe(&mut b, q, true));
            exact.push(&mut a, u);
            roomy.push(&mut b, u);
            prop_assert_eq!(a.line().energy().to_bits(), b.line().energy().to_bits());
        }
        prop_assert_eq!(a.taps().map(f32::to_bits), b.taps().first_chunk::<N>().unwrap().map(f32::to_bits));
        prop_assert!(b.taps()[N..].iter().all(|&w| w == 0.0));
    }

    /// While gated the taps keep every bit, and the regressor goes on.
    #[test]
    fn taps_are_untouched_while_gated(
        data in prop::collection::vec((-0.05_f32..0.05, -1.0_f32..1.0), 100),
        gated_from in 0_usize..100,
    ) {
        let lms = build(0.5, 1e-4, 3);
        let (mut gated, mut witness) = (LmsState::default(), LmsState::default());
        let mut held = *gated.taps();
        for (k, (u, q)) in data.into_iter().enumerate() {
            lms.observe(&mut gated, q, k < gated_from);
            lms.observe(&mut witness, q, true);
            if k < gated_from {
                held = *gated.taps();
            }
            prop_assert_eq!(gated.taps(), &held);
            lms.push(&mut gated, u);
            lms.push(&mut witness, u);
            prop_assert_eq!(gated.line(), witness.line());
        }
    }
}
