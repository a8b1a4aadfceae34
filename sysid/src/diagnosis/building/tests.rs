//! What is listed is what is written, and the other way round.

use super::super::data_checks::fixture::Flight;
use super::super::fixture::{asked, effects, flight_with, quarters, selection};
use super::*;
use crate::catalogue::roll_off::RollOff;
use crate::catalogue::shapes::SHAPES;

/// The answer where the models visited are the baseline and these, the last of them the answer's.
fn built(flight: &Flight, sets: &[Vec<&'static dyn Effect>], names: bool) -> Diagnosis {
    asked(flight, |problem, baseline| {
        let parts = quarters(problem);
        let mut models = selection(problem, baseline, &parts, sets);
        if !names {
            models.named = models.baseline;
        }
        build(&Judgement::new(problem, &parts, models, false, &|_| {}), vec!["a note".into()])
    })
}

/// A flight on a spring of `stiffness` N m, with `drag` in N m s²/rad².
fn sprung(stiffness: f64, drag: f64) -> Flight {
    flight_with(1, move |_, q, theta| -stiffness * theta.sin() - drag * q * q.abs())
}

fn sets() -> [Vec<&'static dyn Effect>; 3] {
    let both = effects(&["gravity_stiffness", "quadratic_drag"]);
    [both[..1].to_vec(), both[1..].to_vec(), both]
}

/// Name and value of all that the model file holds of its effects, sorted.
fn written(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let of = |effect: &EffectEntry| effect.parameters.clone().into_iter();
    let mut all: Vec<(String, f64)> = diagnosis.model.effects.iter().flat_map(of).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// The same of all that the answer lists, the remainder's with it.
fn listed(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let answer = &diagnosis.answer;
    let remainder = answer.remainder.iter().flat_map(|remainder| &remainder.parameters);
    let all = answer.effects.iter().flat_map(|effect| &effect.parameters).chain(remainder);
    let mut all: Vec<(String, f64)> = all.map(|e| (e.name.clone(), e.value)).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

fn plant_is_listed(diagnosis: &Diagnosis) {
    let value = |name: &str| {
        let own = diagnosis.answer.fit.extended.parameters.iter().find(|estimate| estimate.name == name);
        own.map(|estimate| estimate.value)
    };
    let plant = &diagnosis.model.plant;
    assert!(plant.dm_dq.is_some() && plant.dm_dq == value("dM_dq"));
    assert!(plant.dm_du.is_some() && plant.dm_du == value("dM_du"));
    assert_eq!(plant.delay_s, Some(0.06), "the delay was given");
}

#[test]
fn every_term_of_the_model_is_listed_with_its_values_and_no_other() {
    let diagnosis = built(&sprung(4.0, 0.6), &sets(), true);
    let answer = &diagnosis.answer;
    let ids: Vec<&str> = answer.effects.iter().map(|effect| effect.id.as_str()).collect();
    assert_eq!(ids, ["gravity_stiffness", "quadratic_drag"]);
    let in_file: Vec<&str> = diagnosis.model.effects.iter().map(|effect| effect.id.as_str()).collect();
    assert_eq!(in_file, ids);
    assert_eq!(listed(&diagnosis).len(), 2);
    assert_eq!(listed(&diagnosis), written(&diagnosis));
    plant_is_listed(&diagnosis);
    let stiffness = &answer.effects[0].parameters[0];
    assert!(
        (stiffness.value - 4.0).abs() < 0.6 && stiffness.ci95[0] < stiffness.value && stiffness.ci95[0] > 3.0,
        "{stiffness:?}"
    );
    assert_eq!(answer.fit.chosen_in["quadratic_drag"], [4, 4]);
    assert_eq!(answer.fit.held_out.keys().collect::<Vec<_>>(), ["a", "b", "c", "d"]);
    assert!(answer.notes.contains(&"a note".to_owned()));
}

#[test]
fn a_small_term_is_in_the_model_and_in_the_remainder() {
    let diagnosis = built(&sprung(2.0, 0.6), &sets(), true);
    let remainder = diagnosis.answer.remainder.as_ref().unwrap();
    assert_eq!(diagnosis.answer.effects.len(), 1);
    assert!(remainder.words.contains("quadratic_drag, chosen in"), "{}", remainder.words);
    assert_eq!(remainder.parameters.len(), 1);
    let drag = effects(&["quadratic_drag"])[0].about();
    assert_eq!((remainder.variable.as_str(), remainder.equation.as_str()), (drag.variable, drag.equation));
    assert!(remainder.words.starts_with(drag.sentence) && remainder.words.contains(" of 4 rotations)"));
    let left: Vec<(&str, bool)> = diagnosis.components.iter().map(|c| (c.about.id, c.left)).collect();
    assert_eq!(left, [("gravity_stiffness", false), ("quadratic_drag", true)]);
    assert!((0.0..0.2).contains(&remainder.share), "{}", remainder.share);
    assert_eq!(listed(&diagnosis), written(&diagnosis));
    assert_eq!(diagnosis.model.effects.len(), 2);
}

#[test]
fn the_intervals_beside_a_remainder_reach_to_what_the_names_alone_say() {
    let flight = sprung(2.0, 0.6);
    let [name, ..] = sets();
    let (with_rest, alone) = (built(&flight, &sets(), true), built(&flight, &[name], true));
    assert!(alone.answer.effects.len() == 1 && alone.answer.remainder.is_none());
    let physics = |diagnosis: &Diagnosis| diagnosis.answer.fit.extended.parameters.clone();
    let (with_rest, alone) = (physics(&with_rest), physics(&alone));
    for plain in &alone {
        let reached = with_rest.iter().find(|estimate| estimate.name == plain.name).unwrap();
        let [low, high] = reached.ci95;
        assert!(low <= plain.value && plain.value <= high, "{reached:?} {plain:?}");
    }
    let damping = |all: &[Estimate]| all.iter().find(|e| e.name == "dM_dq").unwrap().value;
    let (beside, alone) = (damping(&with_rest), damping(&alone));
    assert!(
        (beside - alone).abs() > 0.1 * alone.abs(),
        "the drag has no part in the damping: {beside} {alone}"
    );
}

#[test]
fn a_term_without_a_name_is_written_with_the_coefficients_that_are_listed() {
    let of_theta = SHAPES.iter().find(|shape| shape.about().id == "of_theta").unwrap();
    let diagnosis = built(&sprung(2.0, 0.0), &[vec![*of_theta as &'static dyn Effect]], false);
    assert_eq!(diagnosis.answer.verdict, Verdict::Unlisted);
    assert!(
        diagnosis.components.iter().all(|component| !component.left),
        "where no name explains, it is the answer"
    );
    let [effect] = diagnosis.answer.effects.as_slice() else { panic!("one term") };
    assert!(diagnosis.answer.remainder.as_ref().is_none_or(|left| left.parameters.is_empty()));
    let [entry] = diagnosis.model.effects.as_slice() else { panic!("one entry") };
    assert_eq!((effect.id.as_str(), entry.id.as_str()), (UNLISTED, UNLISTED));
    assert_eq!(entry.shape.as_deref(), Some("of_theta"));
    let mut coefficients: Vec<f64> =
        entry.parameters.iter().filter(|(name, _)| name.starts_with('c')).map(|(_, value)| *value).collect();
    let mut values: Vec<f64> = effect.parameters.iter().map(|estimate| estimate.value).collect();
    assert!(!values.is_empty());
    coefficients.sort_by(f64::total_cmp);
    values.sort_by(f64::total_cmp);
    assert_eq!(values, coefficients);
    plant_is_listed(&diagnosis);
}

#[test]
fn the_background_is_no_term_and_does_not_shift_the_values_of_those_behind_it() {
    let stiff = find_stiffness();
    let behind: Vec<&'static dyn Effect> = vec![&RollOff, stiff];
    let diagnosis = built(&sprung(2.0, 0.0), &[vec![&RollOff], behind], true);
    let ids: Vec<&str> = diagnosis.answer.effects.iter().map(|effect| effect.id.as_str()).collect();
    assert_eq!(ids, ["gravity_stiffness"]);
    assert_eq!(listed(&diagnosis), written(&diagnosis));
    assert_eq!(diagnosis.answer.effects[0].parameters[0].name, "G");
    assert!((diagnosis.answer.effects[0].parameters[0].value - 2.0).abs() < 0.3);
}

fn find_stiffness() -> &'static dyn Effect {
    effects(&["gravity_stiffness"])[0]
}

#[test]
fn an_answer_has_no_figure_that_json_cannot_hold() {
    asked(&sprung(2.0, 0.0), |problem, baseline| {
        let parts = quarters(problem);
        let with = effects(&["gravity_stiffness", "trim_offset"]);
        let mut models =
            selection(problem, baseline, &parts, &[with[..1].to_vec(), with[1..].to_vec(), with]);
        // The model without the stiffness is none: its trim's interval holds zero.
        *models.visited[2].fit.minimum.values.last_mut().unwrap() = 0.0;
        assert_eq!(models.visited[2].log_posterior(problem, 1.0), f64::NEG_INFINITY);
        let diagnosis = build(&Judgement::new(problem, &parts, models, false, &|_| {}), Vec::new());
        let json = serde_json::to_value(&diagnosis.answer).unwrap();
        let all = json["effects"].as_array().unwrap();
        assert!(!all.is_empty());
        for effect in all {
            assert!(effect["evidence"]["log_evidence"].is_f64(), "{effect}");
            assert!(effect["evidence"]["p_value"].is_f64() && effect["share"].is_f64(), "{effect}");
        }
    });
}

#[test]
fn a_delay_below_zero_is_added_to_the_extra_delay_that_the_model_has() {
    asked(&sprung(0.0, 0.0), |problem, baseline| {
        let mut all =
            problem.unpack(&effects(&["extra_delay"]), &[&baseline.minimum.values[..], &[0.05]].concat());
        all.plant.delay = -0.02;
        let file = all.to_model_file(problem);
        let [entry] = &file.effects[..] else { panic!("{:?}", file.effects) };
        assert!(
            (entry.parameters["Delta"] - 0.03).abs() < 1e-12 && file.plant.delay_s == Some(0.0),
            "{entry:?}"
        );
    });
}
