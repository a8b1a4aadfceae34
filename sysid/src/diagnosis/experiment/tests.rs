//! Flights by known plants.

use super::*;
use crate::dataset::Dataset;
use crate::likelihood::fit::fit_baseline;
use crate::model::baseline::Baseline;

/// 30 s of a rigid plant, q' = −2 q + 100 u, flown by a PRBS, with a little noise.
fn recording() -> crate::recording::Recording {
    let step = 0.02;
    let u = prbs([0.1, 0.2], 0.01, step);
    let mut random = Pcg64::seed_from_u64(5);
    let (mut q, mut theta) = (0.0, 0.0);
    let mut text = String::from("t_s,u_N_m,q_rad_s,theta_rad\n");
    for (k, u) in u.iter().enumerate() {
        let noise = 1e-3 * (random.random::<f64>() - 0.5);
        text.push_str(&format!("{:.2},{u},{},{}\n", k as f64 * step, q + noise, theta + 0.1 * noise));
        q += step * (100.0 * u - 2.0 * q);
        theta += step * q;
    }
    crate::recording::parse("test.csv", text.as_bytes(), &Default::default()).unwrap()
}

#[test]
fn the_supervisor_keeps_the_angle_within_the_limit_and_hands_back_at_half_of_it() {
    let data = Dataset::new(&[recording()]).unwrap();
    let baseline = Baseline::from_data(&data);
    let problem = Problem::new(&data, &baseline, &[]);
    let fit = fit_baseline(&problem).unwrap();
    let (amplitude, limit) = (0.02, 0.08);
    let excitation = prbs([0.4, 0.8], amplitude, problem.sizes.step);
    let free = fly(&problem, &fit, excitation.clone(), amplitude, None).unwrap();
    let held = fly(&problem, &fit, excitation, amplitude, Some(limit)).unwrap();
    let largest = |run: &Run| run.angle.iter().flatten().fold(0.0, |m: f64, a| m.max(a.abs()));
    assert!(largest(&free) > 2.0 * limit, "{}", largest(&free));
    assert!(largest(&held) < 0.75 * largest(&free), "{}", largest(&held));
    let angles = held.angle.as_ref().unwrap();
    for (pair, angle) in held.supervised.windows(2).zip(&angles[1..]) {
        let handed_back = pair[0] && !pair[1];
        assert!(!handed_back || angle.abs() <= 0.5 * limit, "{angle}");
    }
    assert!(held.supervised.iter().any(|s| *s) && !held.supervised.iter().all(|s| *s));
}

/// The baseline, and the same with a delay of its own.
fn asked<T>(ask: impl FnOnce(&Problem<'_>, &Fit, &Fit) -> T) -> T {
    let data = Dataset::new(&[recording()]).unwrap();
    let baseline = Baseline::from_data(&data);
    let problem = Problem::new(&data, &baseline, &[]);
    let fit = fit_baseline(&problem).unwrap();
    let mut later = fit.clone();
    later.effects.push(crate::catalogue::find("extra_delay").unwrap());
    later.minimum.values.push(0.03);
    ask(&problem, &fit, &later)
}

#[test]
fn a_prbs_has_two_levels_and_dwells_within_its_range() {
    let step = 0.02;
    let u = prbs([0.2, 0.4], 0.03, step);
    assert_eq!(u.len(), (DURATION_S / step) as usize);
    assert!(u.iter().all(|u| u.abs() == 0.03));
    let dwells: Vec<f64> = u.chunk_by(|a, b| a == b).map(|dwell| dwell.len() as f64 * step).collect();
    let whole = &dwells[..dwells.len() - 1];
    assert!(whole.iter().all(|d| (0.2 - step..=0.4 + step).contains(d)), "{whole:?}");
    assert!(whole.iter().any(|d| *d < 0.26) && whole.iter().any(|d| *d > 0.34));
}

#[test]
fn between_linear_models_the_ratio_grows_with_the_square_of_the_amplitude_and_is_none_for_a_model_itself() {
    asked(|problem, fit, later| {
        let ratio = |a: &Fit, b: &Fit, amplitude: f64| {
            let run =
                fly(problem, a, prbs(DWELLS[1], amplitude, problem.sizes.step), amplitude, None).unwrap();
            expected_ratio(problem, a, b, &run).unwrap()
        };
        let once = ratio(later, fit, 0.01);
        assert!(once > 1.0, "{once}");
        assert!((ratio(later, fit, 0.02) / once - 4.0).abs() < 0.01);
        assert!(ratio(fit, fit, 0.01) < 1e-9 * once);
    });
}

#[test]
fn what_the_rival_can_make_good_by_its_plant_does_not_separate() {
    asked(|problem, fit, _| {
        let mut stronger = fit.clone();
        stronger.minimum.values[1] *= 1.001;
        let run = fly(problem, &stronger, prbs(DWELLS[1], 0.01, 0.02), 0.01, None).unwrap();
        let ratio = expected_ratio(problem, &stronger, fit, &run).unwrap();
        let unpacked = problem.unpack(&[], &fit.minimum.values);
        let model = problem.model(&unpacked, run.step).unwrap();
        let gain = model.gain(&unpacked.disturbance, &run).unwrap();
        let errors = model.innovations(&run, &gain, run.len(), |_, _| {}).unwrap();
        let weight = weights(&fit.minimum.residuals).0;
        let kept: f64 = errors
            .iter()
            .map(|e| {
                let e = nalgebra::Vector2::from(*e);
                e.dot(&(weight * e))
            })
            .sum();
        assert!(kept > 0.0 && ratio < 1e-3 * kept, "{ratio} of {kept}");
    });
}

#[test]
fn the_best_excitation_is_the_one_with_the_largest_ratio_for_as_long_as_that_takes() {
    asked(|problem, fit, later| {
        let found = best(problem, later, fit).unwrap();
        let limit = largest_angle(problem);
        let mut ratios = Vec::new();
        for (dwell, relative) in DWELLS.iter().flat_map(|d| AMPLITUDES.map(|a| (*d, a))) {
            let amplitude = relative * problem.sizes.u;
            let run = fly(problem, later, prbs(dwell, amplitude, problem.sizes.step), amplitude, limit);
            let ratio = expected_ratio(problem, later, fit, &run.unwrap()).unwrap();
            ratios.push((ratio, dwell, amplitude));
        }
        let (most, dwell, amplitude) = ratios.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        assert_eq!(found.switching_s, dwell);
        assert!((found.amplitude_rad - amplitude).abs() <= 0.5e-4);
        assert_eq!(found.length_s, (25.0 * 12.0 / most).clamp(10.0, 300.0).ceil());
        assert_eq!(found.separates, ["extra_delay", "baseline"]);
        assert!(found.why.contains("supervisor"), "{}", found.why);
    });
}

#[test]
fn an_experiment_names_what_the_two_models_do_not_share() {
    asked(|problem, fit, later| {
        let [friction, lag] = ["coulomb_friction", "servo_lag"].map(|id| crate::catalogue::find(id).unwrap());
        let with = |effects: &[&'static dyn Effect]| Fit { effects: effects.to_vec(), ..fit.clone() };
        let [delay, both] = [later.effects[0], friction];
        assert_eq!(own_term(&with(&[lag, both]), &with(&[delay, both])), "servo_lag");
        assert_eq!(own_term(&with(&[both]), &with(&[both, lag])), "baseline");
        let shape: &'static dyn Effect = crate::catalogue::shapes::SHAPES[0];
        assert_eq!(own_term(&with(&[shape]), fit), "unlisted");
        assert_eq!(best(problem, later, fit).unwrap().separates, ["extra_delay", "baseline"]);
    });
}
