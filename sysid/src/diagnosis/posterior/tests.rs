//! Odds by hand, and models made by hand.

use super::super::data_checks::fixture::flight;
use super::super::fixture::{asked, effects, flight_with, selection};
use super::*;

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
