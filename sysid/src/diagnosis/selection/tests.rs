use super::*;
use crate::catalogue::{CATALOGUE, find};
use crate::diagnosis::data_checks::fixture::{Flight, GAIN, STEP, fitted, flight, model, normal};
use crate::diagnosis::fixture::{asked, effects, extended, flight_with, flown_by, lagging};
use crate::diagnosis::posterior::Finding;
use crate::likelihood::fit::fit_baseline;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// What is selected for a flight of the model with another delay.
fn with_delay<T>(delay: f64, ask: impl Fn(&Problem<'_>, &Selection, Vec<Finding>) -> T) -> T {
    fitted(&flight(1, 0.0).recording(), &model(GAIN, delay), |_, problem, _| {
        let baseline = fit_baseline(problem).unwrap();
        let selection = select(problem, baseline, CATALOGUE, &[], &|_| ()).unwrap();
        let findings = selection.findings(problem, selection.extended);
        ask(problem, &selection, findings)
    })
}

#[test]
fn nothing_is_added_where_nothing_is_missing() {
    with_delay(0.06, |problem, selection, findings| {
        assert!(findings.is_empty());
        assert_eq!((selection.named, selection.extended), (selection.baseline, selection.baseline));
        assert_eq!(selection.gain(problem, selection.baseline), 0.0);
    });
}

#[test]
fn a_wrong_delay_is_found_with_the_size_it_has_and_takes_the_whole_share() {
    with_delay(0.1, |_, selection, findings| {
        let [found] = findings.as_slice() else { panic!("{} terms", findings.len()) };
        assert_eq!(found.effect.about().id, "extra_delay");
        assert!(found.named && found.probability > 0.95 && found.share > 0.95, "{}", found.probability);
        assert!(found.p_value < 1e-12 && found.without == Some(selection.baseline));
        let fit = &selection.visited[selection.extended].fit;
        assert!((fit.minimum.values.last().unwrap() + 0.04).abs() < 0.003);
    });
}

#[test]
fn a_name_is_twice_as_likely_beforehand_as_a_shape_and_each_term_halves_the_odds() {
    fitted(&flight(1, 0.0).recording(), &model(GAIN, 0.06), |_, problem, _| {
        let candidates = Candidates::new(problem, CATALOGUE);
        let lag = find("servo_lag").unwrap();
        let (names, shapes) = (candidates.named.len() as f64, candidates.shapes.len() as f64);
        let odds = |effects: &[&'static dyn Effect]| log_prior(problem, effects, &candidates).exp();
        assert_eq!(odds(&[]), 1.0);
        let (name, shape) = (odds(&[lag]) * names, odds(&candidates.shapes[..1]) * shapes);
        assert!((name / shape - 2.0).abs() < 1e-9 && (name + shape - 0.5).abs() < 1e-9);
        assert!((odds(&[lag, lag]) - odds(&[lag]).powi(2)).abs() < 1e-15);
    });
}

#[test]
fn a_spring_about_another_zero_is_found_with_that_zero() {
    let (stiffness, rests_at) = (200.0, 0.1);
    let flight = flight_with(3, |_, _, angle| -stiffness * (angle - rests_at).powi(3));
    asked(&flight, |problem, plain| {
        let selection = select(problem, plain.clone(), CATALOGUE, &[], &|_| ()).unwrap();
        let fit = &selection.visited[selection.extended].fit;
        let value = |id: &str| fit.range_of(problem, id).map(|range| fit.minimum.values[range.start]);
        let (Some(k3), Some(rest)) = (value("cubic_stiffness"), value("rest_angle")) else {
            panic!("{:?}, {}", fit.ids(), problem.sizes.theta)
        };
        assert!(
            (k3 / stiffness - 1.0).abs() < 0.1 && (rest - rests_at).abs() < 0.01,
            "{:?} {k3} {rest}",
            fit.ids()
        );
    });
}

#[test]
fn a_straight_spring_is_told_from_gravity_where_the_angles_are_large() {
    let far = flight(3, 0.0).u.iter().map(|u| 6.0 * u).collect();
    let swung = flown_by(3, far, |_, _, angle| -3.0 * angle);
    asked(&swung, |problem, plain| {
        let selection = select(problem, plain.clone(), CATALOGUE, &[], &|_| ()).unwrap();
        let fit = &selection.visited[selection.named].fit;
        assert!(fit.position("linear_stiffness").is_some(), "{:?}, {} rad", fit.ids(), problem.sizes.theta);
    });
}

#[test]
fn a_lag_that_was_cut_in_two_is_handed_on_whole() {
    let lagged = lagging(1, 0.25);
    asked(&lagged, |problem, plain| {
        let mut cut = extended(problem, plain, &effects(&["servo_lag", "angle_lag"]));
        let (servo, angle) = (cut.own_range(problem, 0).start, cut.own_range(problem, 1).start);
        (cut.minimum.values[servo], cut.minimum.values[angle]) = (0.01, 0.25);
        let whole = handed_on(problem, &cut, 1);
        assert_eq!((whole.len(), whole[0].ids()), (1, vec!["servo_lag"]));
        assert!((whole[0].minimum.values[servo] - 0.25).abs() < 0.02, "{}", whole[0].minimum.values[servo]);
        assert!(handed_on(problem, &extended(problem, plain, &effects(&["servo_lag"])), 0).is_empty());
    });
}

#[test]
fn a_limit_that_the_log_shows_is_found_however_far_the_rest_has_to_move() {
    let mut random = Pcg64::seed_from_u64(5);
    let mut air = vec![0.0];
    for k in 0..2000 {
        air.push(0.9 * air[k] + 0.3 * normal(&mut random));
    }
    let mut flown = flown_by(1, flight(1, 0.0).u, |k, _, _| air[k]);
    flown.q.iter_mut().for_each(|q| *q = q.clamp(-0.2, 0.2));
    asked(&flown, |problem, plain| {
        let selection = select(problem, plain.clone(), CATALOGUE, &[], &|_| ()).unwrap();
        assert!(selection.visited[selection.baseline].names().is_empty());
        let fit = &selection.visited[selection.extended].fit;
        let gain = problem.unpack(&fit.effects, &fit.minimum.values).plant.dm_du;
        assert!(fit.position("gyro_saturation").is_some(), "{:?}", fit.ids());
        assert!((gain / GAIN - 1.0).abs() < 0.1, "{gain}: without the limit it is an eighth of it");
    });
}

#[test]
fn a_mode_that_rings_as_the_servo_does_shows_the_way_to_it() {
    let (omega, zeta, fine) = (18.3, 0.1, 20);
    let Flight { u, .. } = flight(2, 0.0);
    let (mut blades, mut speed, dt) = (0.0, 0.0, STEP / f64::from(fine));
    let mut mean = |u: f64| {
        let sum = (0..fine).map(|_| {
            speed += dt * (omega * omega * (u - blades) - 2.0 * zeta * omega * speed);
            blades += dt * speed;
            blades
        });
        sum.sum::<f64>() / f64::from(fine)
    };
    let missing: Vec<f64> = u.iter().map(|&u| mean(u) - u).collect();
    let ringing = flown_by(2, u, |k, _, _| if k >= 3 { GAIN * missing[k - 3] } else { 0.0 });
    asked(&ringing, |problem, plain| {
        let named = effects(&["structural_mode", "servo_second_order"]);
        let start = [&plain.minimum.values[..], &[omega, zeta, -1.0]].concat();
        let mode = refit(problem, &named[..1], &start).unwrap();
        let mut search = Search {
            problem,
            candidates: Candidates { named, shapes: Vec::new() },
            parts: &[],
            visited: Vec::new(),
            rounds: Vec::new(),
            progress: &|_| (),
            doing: String::new(),
        };
        let found = search.visit(mode).map(|place| search.exchange(place)).unwrap();
        assert_eq!(search.visited[found].names(), ["servo_second_order"]);
    });
}
