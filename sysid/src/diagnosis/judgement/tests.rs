//! Two names, of which one is small.

use super::super::data_checks::fixture::Flight;
use super::super::fixture::{
    asked, effects, extended, flight_with, flown_by, quarters, selection, weaker_at_first,
};
use super::*;

/// The judgement of stiffness and drag together, where all models of the two were visited.
fn judged<T>(flight: &Flight, ask: impl FnOnce(&Judgement<'_, '_>) -> T) -> T {
    judged_in_a_loop(flight, false, ask)
}

fn judged_in_a_loop<T>(flight: &Flight, fed_back: bool, ask: impl FnOnce(&Judgement<'_, '_>) -> T) -> T {
    asked(flight, |problem, baseline| {
        let parts = quarters(problem);
        let both = effects(&["gravity_stiffness", "quadratic_drag"]);
        let sets = [both[..1].to_vec(), both[1..].to_vec(), both];
        let selection = selection(problem, baseline, &parts, &sets);
        ask(&Judgement::new(problem, &parts, selection, fed_back, &|_| {}))
    })
}

fn ids(findings: &[Finding]) -> Vec<&'static str> {
    findings.iter().map(|finding| finding.effect.about().id).collect()
}

#[test]
fn a_small_name_that_not_every_rotation_chooses_is_told_as_a_remainder() {
    // Only where the input is strong does the vehicle turn fast enough for the drag to show.
    let flown = flown_by(1, weaker_at_first(0.2), |_, q, theta| -4.0 * theta.sin() - 0.8 * q * q.abs());
    judged(&flown, |judgement| {
        assert_eq!(
            (ids(&judgement.named), ids(&judgement.small)),
            (vec!["gravity_stiffness"], vec!["quadratic_drag"])
        );
        assert!(judgement.small[0].share < 0.2 && judgement.small[0].share > 0.0);
        assert!(judgement.rotation.gain("quadratic_drag").unwrap().chosen < 4);
        assert_eq!(judgement.grounds.named, 1 + usize::from(judgement.gust.is_some()));
    });
}

#[test]
fn a_small_name_that_every_rotation_chooses_stays_a_name() {
    let flown = flight_with(1, |_, q, theta| -4.0 * theta.sin() - 0.6 * q * q.abs());
    judged(&flown, |judgement| {
        assert_eq!(ids(&judgement.named), ["gravity_stiffness", "quadratic_drag"]);
        assert!(judgement.small.is_empty() && judgement.named[1].share < 0.2);
        assert_eq!(judgement.rotation.gain("quadratic_drag").unwrap().chosen, 4);
        assert!(!judgement.grounds.unstable && judgement.verdict == Verdict::Named);
        assert_eq!(judgement.extended().effects.len(), 2);
        assert!(judgement.baseline().effects.is_empty());
    });
}

#[test]
fn names_that_close_little_give_way_to_what_closes_more() {
    let stiff = |_, _, theta: f64| -0.8 * theta.sin();
    asked(&flight_with(1, stiff), |problem, baseline| {
        let parts = quarters(problem);
        let sets = [effects(&["quadratic_drag"]), effects(&["gravity_stiffness"])];
        for (named, place) in [(1, 2), (2, 2)] {
            let mut models = selection(problem, baseline, &parts, &sets);
            (models.named, models.extended) = (named, named);
            let judgement = Judgement::new(problem, &parts, models, false, &|_| {});
            assert_eq!(judgement.place, place);
            let gains = (judgement.grounds.gained_by_names, judgement.grounds.gained_by_all);
            assert_eq!(gains.0 < MATERIAL * gains.1, named == 1, "{gains:?}");
        }
    });
}

#[test]
fn a_name_that_neither_explains_nor_predicts_is_told_as_what_is_left() {
    // The air moves the vehicle more than the input does, and the loop is closed.
    let weak = weaker_at_first(1.0).iter().map(|u| 0.15 * u).collect();
    let flown = flown_by(1, weak, |_, _, theta| -4.0 * theta.sin());
    judged_in_a_loop(&flown, true, |judgement| {
        assert!(ahead(&judgement.rotation).max(free_run(&judgement.rotation)) < SEEN_IN_A_LOOP);
        assert_eq!((judgement.verdict, judgement.named.len()), (Verdict::Unlisted, 0));
        assert!(ids(&judgement.small).contains(&"gravity_stiffness"));
        assert!(judgement.grounds.named > 0);
    });
}

#[test]
fn figures_held_out_are_means_over_the_parts() {
    judged(&flight_with(1, |_, _, theta| -4.0 * theta.sin()), |judgement| {
        let parts = &judgement.rotation.parts;
        let by_hand =
            |vaf: fn(&Scores) -> f64| parts.iter().map(|part| vaf(&part.extended)).sum::<f64>() / 4.0;
        let [longest, free] = [by_hand(|s| s.horizons.last().unwrap().0), by_hand(|s| s.free_run)];
        assert!(longest > 50.0 && free > 5.0 && longest != free, "{longest} {free}");
        assert_eq!((ahead(&judgement.rotation), free_run(&judgement.rotation)), (longest, free));
        let nearest = parts.iter().map(|part| {
            let (vaf, error) = part.extended.horizons[0];
            [part.past_alone, vaf, error]
        });
        let own = the_inputs_own(&judgement.rotation);
        assert_eq!(own, beyond_the_past(nearest));
        assert!(own > 0.1 && own < 0.9, "{own}");
    });
}

#[test]
fn names_are_fitted_again_without_what_is_left_where_something_is() {
    let flown = flown_by(1, weaker_at_first(0.2), |_, q, theta| -4.0 * theta.sin() - 0.8 * q * q.abs());
    judged(&flown, |judgement| {
        let alone = judgement.names_alone.as_ref().unwrap();
        assert_eq!(alone.ids(), ["gravity_stiffness"]);
        let named = judgement.selection.visited.iter().find(|v| v.fit.ids() == alone.ids()).unwrap();
        assert!((alone.criterion() - named.fit.criterion()).abs() < 0.5, "{}", alone.criterion());
    });
    let flown = flight_with(1, |_, q, theta| -4.0 * theta.sin() - 0.6 * q * q.abs());
    judged(&flown, |judgement| assert!(judgement.names_alone.is_none() && judgement.small.is_empty()));
}

#[test]
fn a_name_turns_about_where_its_sign_may_be_either_and_is_the_other_one_alone() {
    let place = |problem: &Problem<'_>, fit: &Fit, id: &str| fit.range_of(problem, id).unwrap().start;
    asked(&flight_with(1, |_, _, theta| -theta.sin()), |problem, baseline| {
        let all = effects(&["trim_offset", "servo_lag", "quadratic_drag", "coulomb_friction"]);
        let [moment, lag, drag, friction] = [0, 1, 2, 3].map(|i| &all[i]);
        let mut fit = extended(problem, baseline, &[*moment, *lag, *drag]);
        let mut alone = extended(problem, baseline, &[*drag, *lag, *moment]);
        let mut turns = |id: &str, values: [f64; 2], effect: &dyn Effect| {
            let (own, other) = (place(problem, &fit, id), place(problem, &alone, id));
            (fit.minimum.values[own], alone.minimum.values[other]) = (values[0], values[1]);
            turns_about(problem, &fit, &alone, effect)
        };
        assert!(turns("trim_offset", [0.1, -0.05], *moment) && turns("trim_offset", [-0.1, 0.05], *moment));
        assert!(!turns("trim_offset", [0.1, 0.05], *moment) && !turns("trim_offset", [-0.1, -0.05], *moment));
        assert!(!turns("trim_offset", [0.1, 0.0], *moment), "none is no other sign");
        assert!(!turns("trim_offset", [-0.1, 0.0], *moment), "nor of what pulls the other way");
        assert!(!turns("servo_lag", [0.1, -0.1], *lag), "a time constant has one sign");
        assert!(!turns("quadratic_drag", [0.1, -0.1], *drag), "a drag begins at none");
        assert!(!turns("trim_offset", [0.1, -0.05], *friction), "what neither has");
    });
}
