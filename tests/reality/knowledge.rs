//! What the user knows already: physics in the model that is a little off, placeholders, nothing at all.

use host_sim::{Bench, FreeFlight, Input, Plant, Setting, Table, dirt};
use sysid::diagnosis::answer::Verdict;
use sysid::diagnosis::data_checks::State;
use sysid::model::file::{EffectEntry, PlantSection};

use crate::{ask, bench, check, effect, entry, estimate, ids, is_right, logged, model_of, read, words};

/// `concealed` is in the user's model with another value, and that is all that is wrong.
fn is_no_mismatch_and_said_so(concealed: Setting, in_model: EffectEntry, seed: u64) {
    let (id, parameter, value) = {
        let (parameter, value) = concealed.parameters().next().expect("it has a parameter");
        (concealed.entry().id, parameter.name, value)
    };
    let table = logged(&bench(seed, vec![concealed]));
    let answer = ask(&[read(&table)], Some(&model_of(&Plant::nominal(), vec![in_model]))).answer;
    assert_eq!((answer.verdict, ids(&answer)), (Verdict::NoMismatch, vec![]));
    assert_eq!(answer.in_model.len(), 1);
    assert!(is_right(estimate(&answer, id, parameter), value, 0.3));
    assert!(answer.summary.contains(id), "{}", answer.summary);
}

#[test]
fn a_users_friction_that_is_too_large_is_no_mismatch_and_said_so() {
    let friction = effect("coulomb_friction", &[("Mc", 0.1)]);
    is_no_mismatch_and_said_so(friction, entry("coulomb_friction", &[("Mc", 0.15)]), 1);
}

#[test]
fn a_users_friction_that_is_too_small_is_no_mismatch_and_said_so() {
    let friction = effect("coulomb_friction", &[("Mc", 0.1)]);
    is_no_mismatch_and_said_so(friction, entry("coulomb_friction", &[("Mc", 0.05)]), 2);
}

#[test]
fn a_users_spring_that_is_a_fifth_too_stiff_is_no_mismatch_and_said_so() {
    let spring = effect("gravity_stiffness", &[("G", 1.0)]);
    is_no_mismatch_and_said_so(spring, entry("gravity_stiffness", &[("G", 1.2)]), 3);
}

#[test]
fn a_users_servo_that_is_twice_too_slow_is_no_mismatch_and_said_so() {
    let lag = effect("servo_lag", &[("T", 0.06)]);
    is_no_mismatch_and_said_so(lag, entry("servo_lag", &[("T", 0.12)]), 4);
}

#[test]
fn a_placeholder_of_the_gain_is_no_evidence_for_degrees() {
    let table = logged(&bench(5, Vec::new()));
    for factor in [25.0, 57.3] {
        let placeholder = Plant { dm_du: Plant::nominal().dm_du / factor, ..Plant::nominal() };
        let answer = ask(&[read(&table)], Some(&model_of(&placeholder, Vec::new()))).answer;
        assert_eq!(answer.verdict, Verdict::NoMismatch, "{factor}");
        assert_eq!(check(&answer, "input_unit").state, State::CannotTell, "{factor}");
        assert!(check(&answer, "input_unit").words.contains("degrees"), "{factor}");
    }
}

#[test]
fn a_rate_and_an_angle_in_degrees_are_still_told_where_the_gain_is_known() {
    let table = dirt::in_degrees(dirt::in_degrees(logged(&bench(6, Vec::new())), "q_rad_s"), "theta_rad");
    let answer = ask(&[read(&table)], Some(&model_of(&Plant::nominal(), Vec::new()))).answer;
    assert!(words(&answer).contains("degrees"));
}

fn is_per_unit_inertia_and_said_so(table: &Table) {
    let diagnosis = ask(&[read(table)], None);
    let PlantSection { inertia_kg_m2, mount_k, .. } = diagnosis.model.plant;
    assert_eq!((inertia_kg_m2, mount_k), (1.0, None));
    assert!(words(&diagnosis.answer).contains("inertia"), "the assumption is not told");
}

#[test]
fn a_normalised_input_without_a_model_is_per_unit_inertia_and_said_so() {
    let flight = FreeFlight { tick_s: 0.004, ..FreeFlight::new(7).expect("it exists") };
    let flown = flight.pitch_alone().fly().expect("it flies").table;
    is_per_unit_inertia_and_said_so(&dirt::averaged(flown, 5));
}

#[test]
fn a_blade_angle_without_a_model_is_no_vehicle_of_a_paper() {
    let rigid = Bench { plant: Plant::nominal().rigid(), ..bench(7, Vec::new()) };
    is_per_unit_inertia_and_said_so(&logged(&rigid));
}

#[test]
fn nothing_is_written_where_nothing_was_estimated() {
    let still = Bench { input: Input::Rest, duration_s: 20.0, ..Bench::new(8) };
    let diagnosis = ask(&[read(&logged(&still))], None);
    assert_eq!(diagnosis.answer.verdict, Verdict::NotExcited);
    let PlantSection { dm_dq, dm_du, mount_k, .. } = diagnosis.model.plant;
    assert_eq!((dm_dq, dm_du, mount_k), (None, None, None));
}
