//! Responses of two taps beside a known share of noise.

use super::super::data_checks::fixture::{GAIN, model, normal, read};
use super::super::fixture::quarters;
use super::*;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const STEP: f64 = 0.02;

/// y[k] = `response` · (0.5 u[k−1] + 0.3 u[k−1−lag]) + noise with this standard deviation; u of two levels, new at every sample.
fn asked<T>(response: f64, lag: usize, noise: f64, ask: impl FnOnce(&Problem<'_>, &[Part]) -> T) -> T {
    let mut random = Pcg64::seed_from_u64(8);
    let u: Vec<f64> = (0..2000).map(|_| if random.random() { 1.0 } else { -1.0 }).collect();
    let before = |k: usize, lag: usize| if k >= lag { u[k - lag] } else { 0.0 };
    let mut text = String::from("t_s,u_rad,q_rad_s\n");
    for (k, now) in u.iter().enumerate() {
        let y = response * (0.5 * before(k, 1) + 0.3 * before(k, 1 + lag)) + noise * normal(&mut random);
        text.push_str(&format!("{:.2},{now},{y}\n", STEP * k as f64));
    }
    let data = Dataset::new(&[read(&text)]).unwrap();
    let baseline = Baseline::from_model(&model(GAIN, 0.06), &data).unwrap();
    let problem = Problem::new(&data, &baseline, &[]);
    ask(&problem, &quarters(&problem))
}

#[test]
fn the_ceiling_is_the_share_of_what_the_input_causes() {
    for noise in [0.0, 0.3, 0.6] {
        asked(1.0, 1, noise, |problem, parts| {
            let found = ceilings(problem, parts);
            assert_eq!(found.keys().collect::<Vec<_>>(), ["a", "b", "c", "d"]);
            let own = 0.5_f64.powi(2) + 0.3_f64.powi(2);
            let expected = 100.0 * own / (own + noise * noise);
            for ceiling in found.values() {
                assert!((ceiling - expected).abs() < 0.01 + 12.0 * noise, "{noise}: {ceiling} {expected}");
            }
        });
    }
}

#[test]
fn noise_has_no_ceiling_but_what_the_taps_take_of_it() {
    asked(0.0, 1, 1.0, |problem, parts| {
        // The shortest memory has 12 taps: 12 of 488 rows' variance.
        let mean = ceilings(problem, parts).values().sum::<f64>() / 4.0;
        assert!((1.0..4.5).contains(&mean), "{mean}");
    });
}

#[test]
fn the_memory_is_as_long_as_the_response() {
    // The second tap is 0.8 s behind the first: three quarters of a second do not reach it.
    asked(1.0, 40, 0.1, |problem, parts| {
        let found = ceilings(problem, parts);
        assert!(found.values().all(|ceiling| *ceiling > 90.0), "{found:?}");
        let short = of_itself(problem, &parts[0], 0.5);
        assert!((short - 100.0 * 0.25 / 0.35).abs() < 8.0, "{short}");
    });
}

#[test]
fn a_part_of_several_places_is_their_mean_by_length() {
    asked(1.0, 1, 0.6, |problem, _| {
        let place = |rows| Place { label: "p".into(), run: 0, rows };
        let part = |places: Vec<Place>| Part { label: "p".into(), places };
        let (short, long) = (place(0..300), place(600..1500));
        let of = |places| of_itself(problem, &part(places), 0.25);
        let apart = (of(vec![short.clone()]), of(vec![long.clone()]));
        assert!((apart.0 - apart.1).abs() > 0.1);
        assert!((of(vec![short, long]) - (0.25 * apart.0 + 0.75 * apart.1)).abs() < 1e-9);
        assert_eq!(of(Vec::new()), 0.0);
    });
}

#[test]
fn taps_are_as_many_as_the_memory_a_sixth_of_the_rows_and_a_hundred_at_most() {
    asked(1.0, 1, 0.1, |problem, parts| {
        let of = |rows: usize, memory: f64| {
            taps(problem, &Place { rows: 0..rows, ..parts[0].places[0].clone() }, memory)
        };
        assert_eq!([of(2000, 0.5), of(60, 0.5), of(2000, 10.0), of(3, 0.5)], [25, 10, 100, 1]);
    });
}
