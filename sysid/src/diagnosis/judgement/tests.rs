//! Two names, of which one is small.

use super::super::data_checks::fixture::{Flight, GAIN, fitted, flown, model, normal};
use super::super::fixture::{
    asked, effects, flight_with, flown_by, lagging, quarters, selection, weaker_at_first,
};
use super::super::levels::LONGEST_HORIZON_S;
use super::*;
use crate::catalogue::find;
use crate::catalogue::shapes::SHAPES;
use crate::likelihood::evidence::Information;
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

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
        assert_eq!(judgement.predicted, Predicted::Little);
        assert_eq!((judgement.verdict, judgement.named.len()), (Verdict::Unlisted, 0));
        assert!(ids(&judgement.small).contains(&"gravity_stiffness"));
        assert!(judgement.grounds.named > 0);
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
        // and answer for themselves
        let sections: Vec<_> = judgement.parts.iter().flat_map(|part| part.places.clone()).collect();
        let ahead = |fit: &Fit| vaf_ahead(judgement.problem, fit, &sections, LONGEST_HORIZON_S);
        let by_hand = closed(ahead(judgement.baseline()), ahead(alone));
        let of_names = judgement.grounds.closed;
        assert!((of_names - by_hand).abs() < 1e-9 && by_hand > 0.0, "{of_names} {by_hand}");
        let [by_names, all] = [judgement.grounds.gained_by_names, judgement.grounds.gained_by_all];
        assert!(by_names > 0.5 * all && by_names < 0.99 * all, "{by_names} of {all}");
    });
    let flown = flight_with(1, |_, q, theta| -4.0 * theta.sin() - 0.6 * q * q.abs());
    judged(&flown, |judgement| assert!(judgement.names_alone.is_none() && judgement.small.is_empty()));
}

/// The test flight's input, `by` times as strong, with stiffness in slow air of strength `air`.
fn in_slow_air(by: f64, air: f64, decay: f64) -> Flight {
    let mut random = Pcg64::new(5, 7);
    let mut slow = vec![0.0];
    for k in 0..2000 {
        slow.push(decay * slow[k] + 0.05 * normal(&mut random));
    }
    let u = weaker_at_first(1.0).iter().map(|u| by * u).collect();
    flown_by(1, u, move |k, _, theta| air * slow[k] - 2.0 * theta.sin())
}

/// The judgement of a selection in which the last of `sets` is the answer's, but for a `change`.
fn judged_of<T>(
    flight: &Flight,
    sets: &[Vec<&'static dyn Effect>],
    fed_back: bool,
    change: impl FnOnce(&mut Selection),
    ask: impl FnOnce(&Judgement<'_, '_>) -> T,
) -> T {
    asked(flight, |problem, baseline| {
        let parts = quarters(problem);
        let mut models = selection(problem, baseline, &parts, sets);
        change(&mut models);
        ask(&Judgement::new(problem, &parts, models, fed_back, &|_| {}))
    })
}

#[test]
fn the_answers_model_is_that_of_the_names_if_they_close_nearly_all_and_the_fullest_if_they_gain_little() {
    let both = effects(&["cubic_stiffness", "gravity_stiffness"]);
    let sets = [both[..1].to_vec(), both[1..].to_vec(), both];
    let place = |stiffness: f64, [named, extended, fullest]: [usize; 3]| {
        let change = |models: &mut Selection| {
            (models.named, models.extended, models.fullest) = (named, extended, fullest);
        };
        let flown = flight_with(1, |_, _, theta| -stiffness * theta.sin());
        judged_of(&flown, &sets, false, change, |judgement| (judgement.place, judgement.grounds.closed))
    };
    let (found, closed) = place(1.0, [1, 2, 3]);
    assert!(found == 3 && closed < MATERIAL, "the cubic closes little and gains little: {closed}");
    let (found, closed) = place(1.0, [2, 2, 3]);
    assert!(found == 2 && closed < MATERIAL, "stiffness gains all: {closed}");
    let (found, closed) = place(4.0, [2, 1, 3]);
    assert!(found == 2 && closed > MATERIAL, "a name is missing from what is beside it: {closed}");
    assert_eq!(place(4.0, [2, 3, 1]).0, 3, "nothing is missing");
}

#[test]
fn a_names_share_is_that_of_the_motion_where_it_is_more_than_that_of_the_evidence() {
    let both = effects(&["gravity_stiffness", "quadratic_drag"]);
    let sets = [both[..1].to_vec(), both[1..].to_vec(), both];
    let flown = flight_with(1, |_, q, theta| -4.0 * theta.sin() - 0.6 * q * q.abs());
    // beside a baseline that is as good as impossible no name has a share of the evidence
    let change = |models: &mut Selection| models.visited[0].log_prior -= 1e6;
    judged_of(&flown, &sets, false, change, |judgement| {
        let sections: Vec<_> = judgement.parts.iter().flat_map(|part| part.places.clone()).collect();
        let ahead = |place: usize| {
            vaf_ahead(
                judgement.problem,
                &judgement.selection.visited[place].fit,
                &sections,
                LONGEST_HORIZON_S,
            )
        };
        let [_, stiff, drag, all] = [0, 1, 2, 3].map(|place| closed(ahead(0), ahead(place)));
        for (id, by_hand) in [("gravity_stiffness", all - drag), ("quadratic_drag", all - stiff)] {
            let found = judgement.named.iter().chain(&judgement.small).find(|f| f.effect.about().id == id);
            let share = found.unwrap().share;
            assert!(by_hand > 0.001 && (share - by_hand).abs() < 1e-9, "{id}: {share} {by_hand}");
        }
    });
}

#[test]
fn untold_is_half_of_what_the_failed_test_of_physics_that_closes_most_would_gain() {
    // half of the moment comes a sample early
    let early = flown(3, 0.0, [0.5, 0.5]);
    judged_of(
        &early,
        &[effects(&["gravity_stiffness"])],
        false,
        |_| {},
        |judgement| {
            let of_physics = judgement.failed.iter().filter(|test| test.of_physics).map(|test| test.closes);
            let most = of_physics.fold(0.0, f64::max);
            assert!(most > 4.0, "{:?}", judgement.failed);
            assert_eq!(judgement.grounds.untold, 0.5 * most);
        },
    );
}

#[test]
fn a_name_is_clear_by_what_it_gains_or_by_how_often_it_gains() {
    let [stiff, step] = ["gravity_stiffness", "moment_step"].map(|id| find(id).unwrap());
    let clear = |effect: &dyn Effect, gain: f64, error: f64, signed_rank: f64| {
        is_clear(effect, &TermGain { log_likelihood: (gain, error), signed_rank, ..TermGain::default() })
    };
    let limit = HELD_OUT_ERRORS;
    assert!(clear(stiff, 10.1 * limit, 10.0, 0.0) && !clear(stiff, 9.9 * limit, 10.0, 0.0));
    assert!(clear(stiff, -5.0, 10.0, limit + 0.01) && !clear(stiff, -5.0, 10.0, limit - 0.01));
    assert!(!clear(stiff, 0.0, 0.0, limit), "no more than chance");
    let halving = |gain: f64| TermGain { log_likelihood: (gain, 10.0), halves: true, ..TermGain::default() };
    assert!(
        is_clear(stiff, &halving(10.1)) && !is_clear(stiff, &halving(9.9)),
        "of a swing the free run tells"
    );
    assert!(clear(step, -5.0, 10.0, 0.0), "what comes and goes shows in few blocks");
}

#[test]
fn a_name_beside_a_larger_one_is_minor_where_it_is_small_and_not_sure() {
    let (small, sure, beyond_doubt) = (1.0 - MATERIAL - 0.01, [true, false], [true; 2]);
    assert!(is_minor(small, [3, 4], sure) && !is_minor(small, [4, 4], sure));
    assert!(!is_minor(small, [3, 4], beyond_doubt) && is_minor(small, [2, 4], beyond_doubt));
    assert!(!is_minor(1.0 - MATERIAL, [3, 4], sure), "a fifth is not small");
    assert!(is_minor(0.9, [2, 4], sure) && !is_minor(0.9, [2, 3], sure), "no majority chooses it");
    assert!(is_minor(WORTH_A_NAME - 0.001, [4, 4], beyond_doubt) && !is_minor(WORTH_A_NAME, [4, 4], sure));
    assert!(is_minor(0.5, [4, 4], [false; 2]), "not clear");
}

#[test]
fn a_small_name_of_a_larger_ones_class_mends_its_form() {
    asked(&lagging(1, 0.1), |problem, baseline| {
        let [servo, gyro, stiff] = ["servo_lag", "gyro_lag", "gravity_stiffness"].map(|id| find(id).unwrap());
        let models = selection(problem, baseline, &[], &[vec![servo, stiff]]);
        let mends = |id: &str, share: f64, before: &[&'static dyn Effect]| {
            let findings = models.findings(problem, 1);
            let found = findings.into_iter().find(|finding| finding.effect.about().id == id).unwrap();
            mends(&Finding { share, ..found }, before)
        };
        let small = 0.99 * MENDS;
        assert!(mends("servo_lag", small, &[stiff, gyro]) && !mends("servo_lag", small, &[stiff]));
        assert!(!mends("servo_lag", MENDS, &[gyro]), "a tenth is not small");
        assert!(!mends("gravity_stiffness", small, &[stiff]), "of no class");
    });
}

#[test]
fn a_sure_small_lag_beside_a_larger_one_is_told_as_what_is_left() {
    let mut flown = lagging(1, 0.02);
    let mut filtered = 0.0;
    for q in &mut flown.q {
        filtered += 0.2 * (*q - filtered);
        *q = filtered;
    }
    let sets = [effects(&["servo_lag"]), effects(&["gyro_lag"]), effects(&["servo_lag", "gyro_lag"])];
    judged_of(
        &flown,
        &sets,
        false,
        |_| {},
        |judgement| {
            assert_eq!((ids(&judgement.named), ids(&judgement.small)), (vec!["gyro_lag"], vec!["servo_lag"]));
            let (share, gain) = (judgement.small[0].share, judgement.rotation.gain("servo_lag").unwrap());
            let clear = is_clear(judgement.small[0].effect, &gain);
            assert!(
                !is_minor(share, [gain.chosen_in_kind, 4], [clear, false]) && share < 1.0 - MATERIAL,
                "{share}"
            );
        },
    );
}

#[test]
fn a_moment_that_is_over_within_a_block_is_an_event() {
    let [stiff, step] = ["gravity_stiffness", "moment_step"].map(|id| find(id).unwrap());
    assert!(is_event(step, &[0.5, 14.0, 14.0 + 0.9 * BLOCK_S]));
    assert!(!is_event(step, &[0.5, 14.0, 14.0 + BLOCK_S]) && !is_event(stiff, &[0.5]));

    let judged = |rows: std::ops::Range<usize>| {
        let within = |k: usize| if rows.contains(&k) { 0.5 } else { 0.0 };
        let flown = flight_with(1, |k, _, _| within(k));
        asked(&flown, |problem, baseline| {
            let parts = quarters(problem);
            let [from, to] = [rows.start, rows.end].map(|row| problem.sizes.step * row as f64);
            let start = [&baseline.minimum.values[..], &[0.5, from, to]].concat();
            let fit = refit(problem, &[step], &start).unwrap();
            let mut models = selection(problem, baseline, &parts, &[vec![step]]);
            let places: Vec<_> = parts.iter().map(|part| part.places.clone()).collect();
            models.visited[1].information = Information::new(problem, &fit, &places).unwrap();
            models.visited[1].fit = fit;
            let judgement = Judgement::new(problem, &parts, models, false, &|_| {});
            (ids(&judgement.named), ids(&judgement.small))
        })
    };
    assert_eq!(judged(700..760), (Vec::new(), vec!["moment_step"]));
    assert_eq!(judged(700..1100), (vec!["moment_step"], Vec::new()));
}

#[test]
fn the_first_name_stays_one_however_little_it_gains() {
    let flown = flight_with(1, |_, _, theta| -0.05 * theta.sin());
    judged_of(
        &flown,
        &[effects(&["gravity_stiffness"])],
        false,
        |_| {},
        |judgement| {
            let gain = judgement.rotation.gain("gravity_stiffness").unwrap();
            assert!(!is_clear(judgement.named[0].effect, &gain) && judgement.grounds.unstable);
            assert_eq!((ids(&judgement.named), judgement.small.len()), (vec!["gravity_stiffness"], 0));
        },
    );
}

#[test]
fn a_name_that_turns_its_sign_without_the_shapes_is_told_as_what_is_left() {
    let shape = *SHAPES.iter().find(|shape| shape.about().id == "of_q").unwrap();
    let set = vec![effects(&["gravity_stiffness"])[0], shape];
    let judged = |factor: f64| {
        let change = |models: &mut Selection| {
            let fit = &mut models.visited[1].fit;
            let stiffness = fit.minimum.values.len() - set[1].starts(&Default::default())[0].len() - 1;
            assert!(fit.minimum.values[stiffness] > 1.0);
            fit.minimum.values[stiffness] *= factor;
        };
        let flown = flight_with(1, |_, q, theta| -2.0 * theta.sin() - 4.0 * q * q.abs());
        judged_of(&flown, std::slice::from_ref(&set), false, change, |judgement| {
            (ids(&judgement.named), ids(&judgement.small), judgement.names_alone.is_some())
        })
    };
    assert_eq!(judged(1.0), (vec!["gravity_stiffness"], Vec::new(), true));
    assert_eq!(judged(-0.1), (Vec::new(), vec!["gravity_stiffness"], false));
}

#[test]
fn a_shape_that_held_out_data_do_not_show_is_none() {
    let shape = *SHAPES.iter().find(|shape| shape.about().id == "of_q").unwrap();
    let stiff = effects(&["gravity_stiffness"])[0];
    let judged = |drag: f64| {
        let flown = flight_with(1, |_, q, theta| -2.0 * theta.sin() - drag * q * q.abs());
        let sets = [vec![stiff], vec![stiff, shape]];
        judged_of(
            &flown,
            &sets,
            false,
            |models| models.extended = 2,
            |judgement| (ids(&judgement.named), ids(&judgement.shapes)),
        )
    };
    assert_eq!(judged(4.0), (vec!["gravity_stiffness"], vec!["of_q"]));
    assert_eq!(judged(0.0), (vec!["gravity_stiffness"], Vec::new()));
}

#[test]
fn an_input_of_which_a_lag_within_a_row_is_not_known_is_no_finding() {
    let sines = (0..2000).map(|k| 0.015 * (0.31 * f64::from(k)).sin()).collect();
    judged_of(
        &flown_by(1, sines, |_, _, _| 0.0),
        &[effects(&["servo_lag"])],
        false,
        |_| {},
        |judgement| {
            assert_eq!((ids(&judgement.named), ids(&judgement.small)), (Vec::new(), vec!["servo_lag"]));
        },
    );
}

#[test]
fn a_moment_at_a_line_of_the_input_is_told_as_what_is_left() {
    let tone = |k: usize| (TAU * 4.0 * 0.02 * k as f64).sin();
    let judged = |of_input: f64| {
        let u = weaker_at_first(1.0).iter().enumerate().map(|(k, u)| u + of_input * tone(k)).collect();
        let flown = flown_by(1, u, |k, _, _| 0.2 * tone(k));
        let sets = [effects(&["periodic_moment"])];
        judged_of(&flown, &sets, false, |_| {}, |judgement| (ids(&judgement.named), ids(&judgement.small)))
    };
    assert_eq!(judged(0.0), (vec!["periodic_moment"], Vec::new()));
    assert_eq!(judged(0.01), (Vec::new(), vec!["periodic_moment"]));
}

#[test]
fn lags_of_which_nothing_tells_one_from_the_other_are_ambiguous() {
    let mut recording = lagging(1, 0.03).recording();
    recording.theta = None;
    fitted(&recording, &model(GAIN, 0.06), |_, problem, baseline| {
        let parts = quarters(problem);
        let models = selection(problem, baseline, &parts, &[effects(&["gyro_lag"]), effects(&["servo_lag"])]);
        let judgement = Judgement::new(problem, &parts, models, false, &|_| {});
        assert_eq!((judgement.verdict, ids(&judgement.named)), (Verdict::Ambiguous, vec!["servo_lag"]));
    });
}

#[test]
fn a_name_that_no_rotation_chooses_explains_nothing_but_is_kept_where_the_model_predicts() {
    let flown = flight_with(1, |_, _, theta| -theta.sin());
    let change = |models: &mut Selection| models.visited[1].log_prior -= 1e3;
    judged_of(&flown, &[effects(&["gravity_stiffness"])], false, change, |judgement| {
        assert!(judgement.grounds.unstable && judgement.verdict == Verdict::Unlisted);
        let gain = judgement.rotation.gain("gravity_stiffness").unwrap();
        assert!(gain.chosen == 0 && gain.signed_rank > HELD_OUT_ERRORS, "on held-out data it gains");
        assert_eq!(judgement.predicted, Predicted::Near);
        assert_eq!(ids(&judgement.named), ["gravity_stiffness"]);
    });
    // most of what can be closed is closed by a shape, and a second ahead is seen
    let shape = *SHAPES.iter().find(|shape| shape.about().id == "of_q").unwrap();
    let stiff = effects(&["gravity_stiffness"])[0];
    let change = |models: &mut Selection| {
        models.named = 1;
        models.visited[2].log_prior += 1e3;
    };
    judged_of(&in_slow_air(1.0, 1.8, 0.98), &[vec![stiff], vec![stiff, shape]], false, change, |judgement| {
        assert!(!judgement.grounds.unstable && judgement.verdict == Verdict::Unlisted);
        assert_eq!(judgement.predicted, Predicted::Far);
        assert_eq!(ids(&judgement.named), ["gravity_stiffness"]);
    });
    // a name that explains the data is one, however little is predicted
    let tone = |k: usize| 0.2 * (TAU * 4.0 * 0.02 * k as f64).sin();
    let weak = weaker_at_first(1.0).iter().map(|u| 0.15 * u).collect();
    let sets = [effects(&["periodic_moment"])];
    judged_of(
        &flown_by(1, weak, |k, _, _| tone(k)),
        &sets,
        false,
        |_| {},
        |judgement| {
            assert_eq!(judgement.predicted, Predicted::Little);
            assert_eq!((judgement.verdict, ids(&judgement.named)), (Verdict::Named, vec!["periodic_moment"]));
        },
    );
}

#[test]
fn names_are_lost_only_where_nothing_of_the_input_is_seen() {
    let judged = |flight: &Flight, fed_back: bool| {
        let sets = [effects(&["gravity_stiffness"])];
        judged_of(
            flight,
            &sets,
            fed_back,
            |_| {},
            |judgement| (judgement.grounds.unseen, judgement.predicted),
        )
    };
    let rough = in_slow_air(1.0, 2.6, 0.98);
    assert_eq!([true, false].map(|fed_back| judged(&rough, fed_back)), [(true, Predicted::Little); 2]);
    assert_eq!(judged(&in_slow_air(3.0, 5.0, 0.96), true), (false, Predicted::Near));
    assert_eq!(judged(&in_slow_air(1.0, 1.8, 0.98), true), (false, Predicted::Far));
}

#[test]
fn what_acts_at_its_own_time_and_what_a_sensor_adds_is_seen_without_the_input() {
    let of_the_input = |id: &str| is_of_the_input(find(id).unwrap());
    assert!(["servo_lag", "coulomb_friction", "extra_delay", "end_stop"].into_iter().all(of_the_input));
    assert!(
        !["periodic_moment", "moment_step", "gyro_bias", "gust_disturbance"].into_iter().any(of_the_input)
    );
}
