//! Which terms are listed, and with which values: one story, one set of numbers.

use host_sim::{Background, Scenario, Setting, Table, dirt, fly};
use pitchid_tests::nominal_model;
use sysid::diagnosis::Diagnosis;
use sysid::diagnosis::answer::Verdict;
use sysid::estimate::Estimate;

use crate::{ask, ask_nominal, bench, effect, estimate, ids, is_right, logged, read, words};

#[test]
fn the_friction_that_everyone_knows_of_is_found_beside_three_others() {
    let concealed = vec![
        effect("coulomb_friction", &[("Mc", 0.1)]),
        effect("gyro_scale", &[("s", 0.2)]),
        effect("gyro_bias", &[("b", 0.05)]),
        effect("servo_lag", &[("T", 0.08)]),
    ];
    let answer = ask_nominal(&logged(&bench(1, concealed)));
    for id in ["coulomb_friction", "gyro_scale", "gyro_bias"] {
        assert!(ids(&answer).contains(&id), "{id}");
    }
    let lags = ["servo_lag", "gyro_lag", "extra_delay"];
    assert_eq!(ids(&answer).iter().filter(|id| lags.contains(id)).count(), 1);
    assert_eq!(answer.effects.len(), 4);
    assert!(matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous));
}

/// What is listed is what is written, and nothing else.
fn one_set_of_numbers(diagnosis: &Diagnosis) {
    let Diagnosis { answer, model, .. } = diagnosis;
    let same = |p: &Estimate, written: Option<&f64>| {
        let written = *written.unwrap_or_else(|| panic!("{} is not written", p.name));
        assert!((written - p.value).abs() <= 1e-6 * p.value.abs(), "{}: {} {written}", p.name, p.value);
    };
    for effect in answer.effects.iter().filter(|effect| effect.id != "unlisted") {
        let written = model.effects.iter().find(|entry| entry.id == effect.id);
        let written = written.unwrap_or_else(|| panic!("{} is not written", effect.id));
        effect.parameters.iter().for_each(|p| same(p, written.parameters.get(&p.name)));
    }
    let named = |id: &str| ids(answer).contains(&id) || answer.in_model.iter().any(|known| known.id == id);
    for entry in &model.effects {
        let remains = answer.remainder.as_ref().is_some_and(|r| {
            r.words.contains(&entry.id) || r.equation.contains(&entry.id) || entry.id == "unlisted"
        });
        assert!(named(&entry.id) || remains, "{} is written and not told", entry.id);
    }
    let plant = [("dM_dq", model.plant.dm_dq), ("dM_du", model.plant.dm_du)];
    for (name, written) in plant {
        let told = answer.told().parameters.iter().find(|p| p.name == name);
        same(told.unwrap_or_else(|| panic!("{name} is not told")), written.as_ref());
    }
}

#[test]
fn what_is_listed_is_what_is_written() {
    let nominal = Scenario::campaign(4, 0.015, 2).expect("it exists");
    let effects = vec![effect("coulomb_friction", &[("Mc", 0.1)])];
    let flight = fly(&Scenario { effects, background: Background::Paper, ..nominal }).expect("it flies");
    let whole = Table::of(&flight);
    let closes = whole.sections.iter().position(|label| label == "IV").expect("the loop is closed at last");
    let closed_loop = dirt::cut(whole.clone(), [whole.t_s[closes], f64::INFINITY]);
    for table in [whole, closed_loop] {
        one_set_of_numbers(&ask(&[read(&table)], Some(&nominal_model())));
    }
}

#[test]
fn each_term_is_kept_by_its_own_gain() {
    let concealed =
        vec![effect("extra_delay", &[("Delta", -0.03)]), effect("gravity_stiffness", &[("G", 0.01)])];
    let answer = ask_nominal(&logged(&bench(3, concealed)));
    assert!(is_right(estimate(&answer, "extra_delay", "Delta"), -0.03, 0.1));
    for effect in &answer.effects {
        assert!(effect.evidence.log_evidence > 0.0, "{}", effect.id);
        let p = &effect.parameters[0];
        assert!(p.ci95[0] * p.ci95[1] > 0.0, "{} may be nought", effect.id);
    }
    assert_eq!(answer.verdict, Verdict::Named);
}

#[test]
fn friction_that_is_larger_one_way_is_dry_friction_of_that_size() {
    let asymmetric = effect("asymmetric_friction", &[("M_up", 0.11), ("M_down", 0.09)]);
    let answer = ask_nominal(&logged(&bench(4, vec![asymmetric])));
    assert!(matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous));
    let value = |name: &str| estimate(&answer, ids(&answer)[0], name).value;
    let mean = match ids(&answer)[..] {
        ["coulomb_friction"] | ["coulomb_friction", "trim_offset"] => value("Mc"),
        ["asymmetric_friction"] => 0.5 * (value("M_up") + value("M_down")),
        _ => panic!("{:?}", ids(&answer)),
    };
    assert!((mean - 0.1).abs() < 0.015, "{mean}");
}

#[test]
fn friction_that_falls_with_speed_is_dry_friction_with_a_remainder() {
    let falling = Setting::usual("stribeck_friction", true).expect("the simulator knows it");
    let answer = ask_nominal(&logged(&bench(5, vec![falling])));
    assert!(matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous));
    assert_eq!(ids(&answer).first(), Some(&"coulomb_friction"));
}

#[test]
fn an_end_stop_is_added_or_it_is_said_why_it_is_not() {
    let stop = Setting::usual("end_stop", false).expect("the simulator knows it");
    let nominal = Scenario::campaign(4, 0.015, 3).expect("it exists");
    let flight = fly(&Scenario { effects: vec![stop], ..nominal }).expect("it flies");
    let diagnosis = ask(&[read(&Table::of(&flight))], Some(&nominal_model()));
    one_set_of_numbers(&diagnosis);
    let answer = &diagnosis.answer;
    assert!(words(answer).contains("end_stop"));
    for effect in &answer.effects {
        let strongest = &effect.parameters[0];
        assert!(strongest.ci95[0] * strongest.ci95[1] > 0.0, "{} may be nought", effect.id);
        assert!(effect.evidence.vaf_gain_points.value > -1.0, "{} costs VAF", effect.id);
    }
}
