//! A rate that forgets itself: y[k+1] = φ y[k] + w, without noise of the sensor.

use super::*;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::noise::Disturbance;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const STEP: f64 = 0.02;
const ROWS: usize = 6000;
/// Decay of the rate, 1/s.
const DECAY: f64 = 2.0;
const HORIZONS: [f64; 3] = [0.1, 0.3, 1.0];

#[test]
fn a_ratio_of_equal_blocks_has_no_error_and_uneven_ones_have() {
    assert_eq!(ratio(&[(0, [1.0, 4.0]), (1, [1.0, 4.0])]), Some((75.0, 0.0)));
    let (vaf, error) = ratio(&[(0, [0.0, 4.0]), (1, [2.0, 4.0])]).unwrap();
    assert!(vaf == 75.0 && (error - 25.0).abs() < 1e-9, "{vaf} {error}");
}

/// VAF by horizon over `rows` of a model that takes the rate to decay by `decay` and every sample for exact.
fn predicted(decay: f64, places: &[core::ops::Range<usize>]) -> (Vec<f64>, Vec<Option<Vaf>>) {
    let mut random = Pcg64::seed_from_u64(4);
    let mut draw = || (0..12).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
    let mut text = String::from("t_s,u_N_m,q_rad_s\n");
    let (mut y, mut last) = (Vec::new(), 0.0);
    for k in 0..ROWS {
        y.push(last);
        // An input too weak to do anything.
        text.push_str(&format!(
            "{:.2},{},{last}\n",
            STEP * k as f64,
            if k / 20 % 2 == 0 { 1e-9 } else { -1e-9 }
        ));
        last = (-DECAY * STEP).exp() * last + 0.01 * draw();
    }
    let recording = crate::recording::parse("test.csv", text.as_bytes(), &Default::default()).unwrap();
    let data = Dataset::new(&[recording]).unwrap();
    assert_eq!(data.thinned, 1);
    let mut baseline = Baseline::from_data(&data);
    baseline.plant =
        crate::model::plant::Plant { inertia: 1.0, dm_dq: -decay, dm_du: 1.0, delay: 0.0, mount: None };
    let problem = Problem::new(&data, &baseline, &[]);
    let start = [problem.plant_start(), problem.noise_start(1.0)].concat();
    let mut unpacked = problem.unpack(&[], &start);
    // A moment without a memory, against which the sensor has no noise.
    unpacked.disturbance = Disturbance {
        intensity: 1e6,
        frequency: 400.0,
        damping: 1.0,
        zero: 1e3,
        angle_noise: 1.0,
        third: None,
        corrects: None,
    };
    let places: Vec<Place> =
        places.iter().map(|rows| Place { label: "p".into(), run: 0, rows: rows.clone() }).collect();
    (y, horizon_vaf(&problem, &unpacked, &places, &HORIZONS).unwrap())
}

/// The same by hand: y[k] e^{−decay h} for y[k+h], from every fifth row on that is counted.
fn by_hand(y: &[f64], decay: f64, places: &[core::ops::Range<usize>], horizon: f64) -> f64 {
    let all: Vec<f64> = places.iter().flat_map(|rows| y[rows.clone()].to_vec()).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let (ahead, factor) = ((horizon / STEP).round() as usize, (-decay * horizon).exp());
    let (mut left, mut whole) = (0.0, 0.0);
    for rows in places {
        for k in rows.clone().filter(|k| k % 5 == 0 && *k >= 50 && k + ahead < rows.end) {
            left += (y[k + ahead] - factor * y[k]).powi(2);
            whole += (y[k + ahead] - mean).powi(2);
        }
    }
    100.0 * (1.0 - left / whole).max(0.0)
}

#[test]
fn a_prediction_falls_off_as_the_rate_forgets_itself() {
    let whole = 0..ROWS;
    let places = std::slice::from_ref(&whole);
    let (y, found) = predicted(DECAY, places);
    for (&horizon, (vaf, error)) in HORIZONS.iter().zip(found.iter().map(|vaf| vaf.unwrap())) {
        let hand = by_hand(&y, DECAY, places, horizon);
        assert!((vaf - hand).abs() < 0.2, "{horizon}: {vaf} {hand}");
        let in_the_mean = 100.0 * (-2.0 * DECAY * horizon).exp();
        assert!((vaf - in_the_mean).abs() < 4.0 * error && error < 6.0, "{horizon}: {vaf} ± {error}");
    }
}

#[test]
fn a_wrong_model_and_places_of_their_own_are_counted_as_they_are() {
    let places = [100..1503, 2000..2040, 4000..6000];
    for decay in [0.2, 8.0] {
        let (y, found) = predicted(decay, &places);
        for (&horizon, (vaf, _)) in HORIZONS.iter().zip(found.iter().map(|vaf| vaf.unwrap())) {
            let hand = by_hand(&y, decay, &places, horizon);
            assert!((vaf - hand).abs() < 0.3, "{decay}, {horizon}: {vaf} {hand}");
        }
    }
}

#[test]
fn a_place_shorter_than_the_horizon_has_nothing_to_say() {
    let places = [1000..1045, 3000..3045, 5000..5045];
    let (y, found) = predicted(DECAY, &places);
    let (near, _) = found[0].unwrap();
    assert!((near - by_hand(&y, DECAY, &places, 0.1)).abs() < 0.3 && near > 0.0, "{found:?}");
    assert_eq!(found[2], None);
}
