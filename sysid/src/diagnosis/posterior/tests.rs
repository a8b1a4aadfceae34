//! Odds by hand, and models made by hand.

use super::super::another_zero::about_another_zero;
use super::super::data_checks::fixture::{Flight, GAIN, fitted, flight, model, normal};
use super::super::fixture::{asked, effects, extended, flight_with, flown_by, lagging, selection};
use super::*;
use crate::catalogue::slow_moment::SlowMoment;
use rand::SeedableRng;
use rand_pcg::Pcg64;

#[test]
fn chance_is_that_of_chi_squared() {
    assert!((chance(3.841_459, 1) - 0.05).abs() < 1e-6);
    assert!((chance(9.487_729, 4) - 0.05).abs() < 1e-6);
    assert_eq!(chance(-1.0, 1), 1.0);
}

#[test]
fn shapes_have_no_name_and_the_catalogue_has() {
    assert!(SHAPES.iter().all(|&shape| is_shape(shape)));
    assert!(crate::catalogue::CATALOGUE.iter().all(|&effect| !is_shape(effect)));
}

fn finding<'f>(findings: &'f [Finding], id: &str) -> &'f Finding {
    findings.iter().find(|finding| finding.effect.about().id == id).unwrap()
}

#[test]
fn a_needless_term_in_the_model_without_it_does_not_make_a_terms_evidence_infinite() {
    asked(&flight_with(1, |_, _, theta| -2.0 * theta.sin()), |problem, baseline| {
        let both = effects(&["gravity_stiffness", "trim_offset"]);
        let sets = [both[..1].to_vec(), both[1..].to_vec(), both];
        let mut models = selection(problem, baseline, &[], &sets);
        let evidence =
            |models: &Selection| finding(&models.findings(problem, 3), "gravity_stiffness").log_evidence;
        let (before, criterion) = (evidence(&models), models.visited[2].fit.criterion());
        let divisor = models.visited[3].information.divisor(models.visited[3].fit.own_range(problem, 0));

        // A trim that is as good as none: what the fit is worth stays.
        let trim = models.visited[2].fit.minimum.values.len() - 1;
        models.visited[2].fit.minimum.values[trim] = 0.0;
        assert_eq!(models.visited[2].log_posterior(problem, divisor), f64::NEG_INFINITY);
        assert!(before.is_finite() && (evidence(&models) - before).abs() < 1e-9, "{before}");

        // A trim at its bound takes nothing from the evidence.
        let bounds = problem.coordinates(&models.visited[2].fit.effects)[trim].bounds;
        models.visited[2].fit.minimum.values[trim] = bounds[1];
        models.visited[2].information = Information::new(problem, &models.visited[2].fit, &[]).unwrap();
        assert_eq!(models.visited[2].log_posterior(problem, divisor), f64::NEG_INFINITY);
        let occam = models.visited[3].information.occam(models.visited[3].own(problem).into_iter(), divisor);
        let gain = 0.5 * (criterion - models.visited[3].fit.criterion()) / divisor;
        let priors = models.visited[3].log_prior - models.visited[2].log_prior;
        assert!((evidence(&models) - (gain + occam.unwrap() + priors)).abs() < 1e-9);
    });
}

#[test]
fn a_term_whose_model_without_it_was_not_visited_is_held_against_the_best_of_the_rest() {
    let flown = flight_with(1, |_, q, theta| -0.8 * theta.sin() - 0.3 * q * q.abs());
    asked(&flown, |problem, baseline| {
        let both = effects(&["gravity_stiffness", "quadratic_drag"]);
        let models = selection(problem, baseline, &[], &[both[..1].to_vec(), both]);
        let findings = models.findings(problem, 2);
        let found = finding(&findings, "gravity_stiffness");
        assert_eq!(found.without, Some(0));
        let divisor = models.visited[2].information.divisor(models.visited[2].fit.own_range(problem, 0));
        let value = |i: usize| models.visited[i].log_posterior(problem, divisor);
        assert!((found.log_evidence - (value(2) - value(0))).abs() < 1e-9, "{}", found.log_evidence);
        let ratio = (models.visited[0].fit.criterion() - models.visited[2].fit.criterion()) / divisor;
        assert!((found.p_value / chance(ratio, 2) - 1.0).abs() < 1e-9, "two parameters: {}", found.p_value);
    });
}

#[test]
fn probability_is_the_share_of_the_models_with_the_term() {
    asked(&flight(1, 0.0), |problem, baseline| {
        let models = selection(problem, baseline, &[], &[effects(&["servo_lag"])]);
        let found = &models.findings(problem, 1)[0];
        let divisor = models.visited[1].divisor(problem);
        let value = |i: usize| models.visited[i].log_posterior(problem, divisor);
        let odds = (value(1) - value(0)).exp();
        assert!((found.probability - odds / (1.0 + odds)).abs() < 1e-9, "{}", found.probability);
        assert!(found.probability < 0.5 && found.rivals.is_empty());
    });
}

#[test]
fn a_model_tells_its_names_its_shapes_and_its_background_apart() {
    asked(&flight(1, 0.0), |problem, baseline| {
        let shape = SHAPES.iter().find(|shape| shape.about().id == "of_theta").unwrap();
        let set: Vec<&'static dyn Effect> =
            vec![*shape, effects(&["servo_lag"])[0], effects(&["coulomb_friction"])[0]];
        let models = selection(problem, baseline, &[], &[set]);
        let model = &models.visited[1];
        assert_eq!(
            (model.names(), model.shapes()),
            (vec!["coulomb_friction", "servo_lag"], vec!["of_theta"])
        );
        assert_eq!((models.visited[0].names(), models.visited[0].shapes()), (Vec::new(), Vec::new()));
        let all = (0..3).flat_map(|i| model.fit.own_range(problem, i));
        assert_eq!(model.own(problem), all.collect::<Vec<_>>());
        assert_eq!(model.divisor(problem), model.information.divisor(model.own(problem).into_iter()));
    });
}

/// A stiffness and a drag that change every few seconds: what the blocks say of them is uneven, and κ is more than one.
fn uneven() -> Flight {
    let now = |k: usize, every: usize| if (k / every).is_multiple_of(2) { 1.8 } else { 0.2 };
    flight_with(1, move |k, q, theta| -now(k, 500) * theta.sin() - 0.3 * now(k, 100) * q * q.abs())
}

fn shape(id: &str) -> &'static dyn Effect {
    *SHAPES.iter().find(|shape| shape.about().id == id).unwrap()
}

/// Gives the models priors with which the odds of each are these, calibrated by the κ of the term at `i` of the model at `place`.
fn weighed(problem: &Problem<'_>, models: &mut Selection, [place, i]: [usize; 2], odds: &[f64]) {
    let asked = &models.visited[place];
    let divisor = asked.information.divisor(asked.fit.own_range(problem, i));
    for (visited, odds) in models.visited.iter_mut().zip(odds) {
        let value = visited.log_posterior(problem, divisor);
        assert!(value.is_finite(), "{:?}", visited.fit.ids());
        visited.log_prior += odds.ln() - value;
    }
}

fn rivals(finding: &Finding) -> Vec<(&'static str, usize)> {
    finding.rivals.iter().map(|(rival, _, place)| (rival.about().id, *place)).collect()
}

#[test]
fn the_posterior_of_a_model_is_likelihood_prior_and_what_is_left_of_its_parameters_priors() {
    let mut random = Pcg64::seed_from_u64(5);
    let (mut slow, mut band) = (vec![0.0], vec![0.0, 0.0]);
    for k in 0..2000 {
        slow.push(0.99 * slow[k] + 0.1 * normal(&mut random));
        band.push(1.815 * band[k + 1] - 0.9025 * band[k] + 0.06 * normal(&mut random));
    }
    let air = |k: usize| slow[k] + band[k];
    asked(&flight_with(1, |k, _, theta| air(k) - 2.0 * theta.sin()), |problem, baseline| {
        let set = vec![effects(&["gravity_stiffness"])[0], &SlowMoment as &'static dyn Effect];
        let models = selection(problem, baseline, &[], &[set]);
        let Visited { fit, information, log_prior } = &models.visited[1];
        let occam = [0, 1].map(|i| information.occam(fit.own_range(problem, i), 1.5).unwrap());
        assert!(occam.iter().all(|occam| *occam < -1.5), "{occam:?}");
        let by_hand = -0.5 * 300.0 / 1.5 + occam[0] + occam[1] + log_prior;
        let asked = models.visited[1].log_posterior_with(problem, 300.0, 1.5);
        assert!((asked - by_hand).abs() < 1e-9, "{asked} {by_hand}");
        let own = models.visited[1].log_posterior(problem, 1.5);
        assert_eq!(own, models.visited[1].log_posterior_with(problem, fit.criterion(), 1.5));
        assert_eq!(models.visited[1].own(problem), fit.own_range(problem, 0).collect::<Vec<_>>());
        let findings = models.findings(problem, 1);
        assert!(findings.len() == 1 && findings[0].named, "the background is no finding");
    });
}

#[test]
fn a_name_at_zero_is_no_term_and_a_shape_or_what_holds_a_craft_aside_is() {
    let finite_without = |problem: &Problem<'_>, fit: &Fit| {
        let information = Information::new(problem, fit, &[]).unwrap();
        assert!(
            Visited { fit: fit.clone(), information: information.clone(), log_prior: 0.0 }
                .log_posterior(problem, 1.0)
                .is_finite()
        );
        [0, 1].map(|i| {
            let mut fit = fit.clone();
            let own = fit.own_range(problem, i);
            fit.minimum.values[own].fill(0.0);
            let zeroed = Visited { fit, information: information.clone(), log_prior: 0.0 };
            zeroed.log_posterior(problem, 1.0).is_finite()
        })
    };
    asked(&flight_with(1, |_, q, theta| -2.0 * theta.sin() - 0.3 * q * q.abs()), |problem, baseline| {
        let fit = extended(problem, baseline, &[effects(&["gravity_stiffness"])[0], shape("of_q")]);
        assert_eq!(finite_without(problem, &fit), [false, true]);
    });
    let aside = flight_with(3, |_, _, theta| 1.2 * (0.35_f64.sin() - theta.sin()));
    asked(&aside, |problem, baseline| {
        let fit = &about_another_zero(problem, baseline, |_| true)[0];
        assert_eq!(fit.ids(), ["gravity_stiffness", "trim_offset"]);
        assert_eq!(finite_without(problem, fit), [false, true]);
    });
}

#[test]
fn two_explain_the_same_by_predictions_and_likelihoods_both() {
    asked(&flight_with(1, |_, _, theta| -2.0 * theta.sin()), |problem, baseline| {
        let [gravity, spring, friction] = ["gravity_stiffness", "linear_stiffness", "coulomb_friction"]
            .map(|id| extended(problem, baseline, &effects(&[id])));
        let same = |rival: &Fit, divisor| explains_the_same([&gravity, rival], baseline, divisor);
        assert!(same(&spring, 1.0));
        assert!(!same(&spring, 1e-9), "the likelihoods decide");
        assert!(!same(&friction, 1e9), "the predictions do");
    });
}

#[test]
fn two_terms_that_stand_in_its_place_together_are_a_rival() {
    let flown = flight_with(1, |_, q, theta| -2.0 * theta.sin() - 0.3 * q * q.abs());
    asked(&flown, |problem, baseline| {
        let sets = [effects(&["coulomb_friction"]), effects(&["gravity_stiffness", "quadratic_drag"])];
        let models = selection(problem, baseline, &[], &sets);
        let findings = models.findings(problem, 1);
        let (rival, probability, place) = findings[0].rivals[0];
        assert_eq!((rival.about().id, place, findings[0].rivals.len()), ("gravity_stiffness", 2, 1));
        assert!(probability > 0.99, "{probability}");
    });
}

#[test]
fn a_term_is_calibrated_by_its_own_blocks_and_told_by_what_the_whole_gains() {
    asked(&uneven(), |problem, baseline| {
        let both = effects(&["gravity_stiffness", "quadratic_drag"]);
        let sets = [both[..1].to_vec(), both[1..].to_vec(), both];
        let mut models = selection(problem, baseline, &[], &sets);
        for (visited, log_prior) in models.visited.iter_mut().zip([0.0, 0.0, 0.0, 5.0]) {
            visited.log_prior = log_prior;
        }
        let all = &models.visited[3];
        let own = |i: usize| all.fit.own_range(problem, i);
        let divisors = [0, 1].map(|i| all.information.divisor(own(i)));
        let of_both = all.information.divisor(own(0).chain(own(1)));
        assert!(divisors[0] > 1.1 && divisors[1] > 1.1 && of_both > 1.1, "{divisors:?} {of_both}");
        assert_eq!(all.divisor(problem), of_both);
        assert_eq!(all.divisor_beyond(problem, &models.visited[1].fit), divisors[1]);
        assert_eq!(all.divisor_beyond(problem, &models.visited[2].fit), divisors[0]);
        assert_eq!(all.divisor_beyond(problem, baseline), of_both);

        let value = |models: &Selection, i: usize| models.visited[i].log_posterior(problem, of_both);
        let whole = value(&models, 3) - value(&models, 0);
        assert!(whole > 5.0 && (models.gain(problem, 3) - whole).abs() < 1e-9, "{whole}");
        assert_eq!(models.gain(problem, 0), 0.0);

        let criterion = |i: usize| models.visited[i].fit.criterion();
        let found = finding(&models.findings(problem, 3), "quadratic_drag").clone();
        let ratio = (criterion(1) - criterion(3)) / divisors[1];
        assert!(ratio > 1.0 && (found.p_value / chance(ratio, 1) - 1.0).abs() < 1e-9, "{ratio}");
        let share = found.log_evidence / whole;
        assert!((0.05..0.95).contains(&share) && (found.share - share).abs() < 1e-9, "{share}");

        // the model without the term is all of the rest, though less of it be more probable
        models.visited[0].log_prior += 1e4;
        assert_eq!(finding(&models.findings(problem, 3), "quadratic_drag").without, Some(1));
        models.visited[0].log_prior -= 1e4;
        // where the whole gains nothing nobody has a share
        models.fullest = models.baseline;
        let found = finding(&models.findings(problem, 3), "quadratic_drag").clone();
        assert!(found.log_evidence > 0.0 && found.share == 0.0, "{}", found.share);
    });
}

#[test]
fn a_name_is_weighed_among_the_models_with_the_same_shapes_and_a_shape_among_all() {
    let flown = flight_with(1, |_, q, theta| -1.5 * theta.sin() * theta.abs() - 0.3 * q * q.abs());
    asked(&flown, |problem, baseline| {
        let drag = effects(&["quadratic_drag"])[0];
        let sets = [vec![shape("of_theta")], vec![drag], vec![drag, shape("of_theta")]];
        let mut models = selection(problem, baseline, &[], &sets);
        for (i, id, probability) in [(0, "quadratic_drag", 4.0 / 6.0), (1, "of_theta", 6.0 / 9.0)] {
            for in_common in [1.0, 1e-200, 1e200] {
                weighed(problem, &mut models, [3, i], &[2.0, 2.0, 1.0, 4.0].map(|odds| in_common * odds));
                let findings = models.findings(problem, 3);
                let found = finding(&findings, id);
                assert!((found.probability - probability).abs() < 1e-6, "{id}: {}", found.probability);
                assert_eq!(found.named, i == 0);
            }
        }
    });
}

#[test]
fn a_rival_is_a_name_in_the_terms_place_with_the_best_of_its_models() {
    let flown = flight_with(1, |_, q, theta| -2.0 * theta.sin() - 0.3 * q * q.abs());
    asked(&flown, |problem, baseline| {
        let [stiff, drag, cubic] =
            ["gravity_stiffness", "quadratic_drag", "cubic_stiffness"].map(|id| effects(&[id])[0]);
        let sets = [
            vec![stiff, drag],
            vec![cubic],
            vec![cubic, drag],
            vec![cubic, shape("of_theta")],
            vec![shape("of_theta"), drag],
            vec![&SlowMoment, drag],
            vec![shape("of_q"), drag],
        ];
        let mut models = selection(problem, baseline, &[], &sets);
        let odds = |cubic: [f64; 2]| [1.0, 60.0, cubic[0], cubic[1], 9.0, 9.0, 9.0, 9.0];
        for (odds, place) in [(odds([9.0, 8.0]), 2), (odds([8.0, 9.0]), 3)] {
            weighed(problem, &mut models, [1, 0], &odds);
            let findings = models.findings(problem, 1);
            let found = finding(&findings, "gravity_stiffness");
            assert_eq!(rivals(found), [("cubic_stiffness", place)]);
            // those with a shape do not count
            assert!((found.rivals[0].1 - 9.0 / 87.0).abs() < 1e-6, "{}", found.rivals[0].1);
        }
        weighed(problem, &mut models, [1, 0], &odds([1.0, 3.0]));
        assert!(
            rivals(finding(&models.findings(problem, 1), "gravity_stiffness")).is_empty(),
            "four in a hundred"
        );
        weighed(problem, &mut models, [5, 0], &odds([1.0, 9.0]));
        let findings = models.findings(problem, 5);
        let names = rivals(finding(&findings, "of_theta"));
        assert_eq!(names, [("gravity_stiffness", 1), ("cubic_stiffness", 3)], "a shape is no rival");
    });
}

/// What the findings of a model with a lag of the actuator say of one of the gyro: the name's own probability, its rivals, and the
/// odds that the two are one by the noise and ahead.
fn lags(lag: f64, angle: bool, beside: &[&str]) -> (f64, Vec<(&'static str, f64)>, [f64; 2]) {
    let mut recording = lagging(1, lag).recording();
    recording.theta = recording.theta.filter(|_| angle);
    fitted(&recording, &model(GAIN, 0.06), |_, problem, baseline| {
        let sets =
            [effects(&["servo_lag"]), effects(&["gyro_lag"]), effects(&[&["servo_lag"], beside].concat())];
        let mut models = selection(problem, baseline, &[], &sets);
        models.visited[2].log_prior -= 30.0;
        let [servo, gyro] = [1, 2].map(|i| &models.visited[i].fit);
        let unpacked = [servo, gyro].map(|fit| problem.unpack(&fit.effects, &fit.minimum.values));
        let [a, b] = &unpacked;
        let ahead = indistinct_ahead(problem, [a, b], &problem.data.places(), LAG_HORIZONS_S[0]).unwrap();
        let findings = models.findings(problem, if beside.is_empty() { 1 } else { 3 });
        let found = finding(&findings, "servo_lag");
        let rivals = found.rivals.iter().map(|(rival, p, _)| (rival.about().id, *p)).collect();
        (found.probability, rivals, [indistinct(problem, servo, gyro), ahead])
    })
}

#[test]
fn lags_of_actuator_and_gyro_are_told_apart_by_an_angle_and_by_nothing_else() {
    let (_, rivals, [noise, ahead]) = lags(0.008, true, &[]);
    assert!(
        rivals.is_empty() && noise < 1e-3 && ahead > 2.0 * PLAUSIBLE,
        "with an angle: {rivals:?} {ahead}"
    );
    for lag in [0.008, 0.03] {
        let (own, rivals, odds) = lags(lag, false, &[]);
        assert!(odds.iter().all(|odds| *odds < 0.9 * own), "{odds:?}");
        assert_eq!(rivals, [("gyro_lag", own)], "they answer the input alike");
    }
    let (_, rivals, _) = lags(0.03, false, &["gravity_stiffness"]);
    assert!(rivals.is_empty(), "one name in place of two: {rivals:?}");
}

/// The rivals of `asked` where `others` are next to excluded by their priors.
fn however_unlikely(
    problem: &Problem<'_>,
    baseline: &Fit,
    asked: &str,
    others: &[&str],
) -> Vec<(&'static str, f64)> {
    let sets: Vec<_> = [asked].iter().chain(others).map(|id| effects(&[id])).collect();
    let mut models = selection(problem, baseline, &[], &sets);
    models.visited[2..].iter_mut().for_each(|model| model.log_prior -= 30.0);
    let findings = models.findings(problem, 1);
    finding(&findings, asked).rivals.iter().map(|(rival, p, _)| (rival.about().id, *p)).collect()
}

#[test]
fn names_that_explain_the_same_are_rivals_however_wide_their_ranges_are() {
    let friction = |_, q: f64, _| -0.15 * q.signum();
    // turning one way, friction is a constant moment
    let one_way = flown_by(1, flight(1, 0.0).u.iter().map(|u| 0.025 + u).collect(), friction);
    let mut recording = one_way.recording();
    recording.theta = None;
    fitted(&recording, &model(GAIN, 0.06), |_, problem, baseline| {
        let rivals = however_unlikely(problem, baseline, "coulomb_friction", &["trim_offset"]);
        assert!(matches!(rivals[..], [("trim_offset", p)] if p > 0.2), "{rivals:?}");
    });
    asked(&flight_with(1, friction), |problem, baseline| {
        let rivals = however_unlikely(problem, baseline, "coulomb_friction", &["trim_offset"]);
        assert!(rivals.is_empty(), "both ways: {rivals:?}");
    });
    asked(&flight_with(1, |_, _, theta| -2.0 * theta.sin()), |problem, baseline| {
        let rivals = however_unlikely(problem, baseline, "gravity_stiffness", &["linear_stiffness"]);
        assert!(rivals.is_empty(), "the more usual one stands for both: {rivals:?}");
    });
}

#[test]
fn lags_are_compared_at_the_longest_horizon_that_tells_them_from_none() {
    let chosen = |air: f64, pole: f64, delay: f64, seed: u64| {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut gust = vec![0.0];
        for k in 0..2000 {
            gust.push(pole * gust[k] + air * normal(&mut random));
        }
        let mut recording = flown_by(1, flight(1, 0.0).u, |k, _, _| gust[k]).recording();
        recording.theta = None;
        fitted(&recording, &model(GAIN, delay), |_, problem, baseline| {
            let [servo, gyro] =
                ["servo_lag", "gyro_lag"].map(|id| extended(problem, baseline, &effects(&[id])));
            let unpack = |fit: &Fit| problem.unpack(&fit.effects, &fit.minimum.values);
            let [a, b, none] = [&servo, &gyro, baseline].map(unpack);
            let places = problem.data.places();
            let odds = |other: &_, horizon| indistinct_ahead(problem, [&a, other], &places, horizon).unwrap();
            let told = LAG_HORIZONS_S.map(|horizon| odds(&none, horizon) < PLAUSIBLE);
            let alike = alike_ahead(problem, [&servo, &gyro], Some(baseline));
            (told, LAG_HORIZONS_S.into_iter().find(|horizon| odds(&b, *horizon) == alike))
        })
    };
    assert_eq!(chosen(1.0, 0.98, 0.03, 9), ([true, true], Some(0.3)));
    assert_eq!(chosen(1.4, 0.995, 0.03, 10), ([false, true], Some(0.1)));
    assert_eq!(chosen(1.8, 0.9, 0.02, 9), ([false, false], Some(0.3)), "no horizon tells it");
}

#[test]
fn what_restates_two_others_is_said_by_both_together() {
    let said =
        |others: &[&str], id: &str| is_in_other_words(effects(&[id])[0], |part| others.contains(&part));
    assert!(said(&["coulomb_friction", "trim_offset", "servo_lag"], "asymmetric_friction"));
    assert!(!said(&["servo_lag"], "servo_lag"), "its own words");
    assert!(!said(&["coulomb_friction"], "asymmetric_friction"), "half of it");
    assert!(!said(&["linear_stiffness"], "gravity_stiffness"), "nearly the same is not the same");
}
