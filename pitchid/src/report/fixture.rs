//! An answer with something in every part, for tests.

use std::collections::BTreeMap;
use sysid::diagnosis::answer::{
    Alternative, Answer, Dependence, EffectAnswer, Evidence, FailedTest, FitAnswer, HeldOutAnswer, Location,
    ModelAnswer, NextExperiment, Predicted, Remainder, VafAnswer, Verdict, WithError,
};
use sysid::diagnosis::data_checks::{DataCheck, Gravity};
use sysid::diagnosis::questions::questions;
use sysid::estimate::Estimate;
use sysid::model::effect::Locus;

/// What a malicious file might hold.
pub const HOSTILE: &str = "</script><script>alert('x')</script>&\"";

pub fn estimate(name: &str, value: f64) -> Estimate {
    Estimate { name: name.into(), unit: "N m".into(), value, ci95: [0.9 * value, 1.1 * value] }
}

pub fn model(vaf: f64, parameters: Vec<Estimate>) -> ModelAnswer {
    ModelAnswer {
        vaf_percent: BTreeMap::from([("I".into(), vaf), (HOSTILE.into(), vaf)]),
        parameters,
        ..ModelAnswer::default()
    }
}

/// An answer with these effects, each with one parameter, and rivals of the first.
pub fn answer(verdict: Verdict, effects: &[(&str, f64)], rivals: &[&str]) -> Answer {
    let parameter = |id: &str| if id == "coulomb_friction" { "Mc" } else { "b" };
    let added = effects.iter().map(|(id, value)| estimate(parameter(id), *value));
    let plant = || vec![estimate("dM_dq", 0.1)];
    let after = plant().into_iter().chain(added.clone()).collect();
    let alternatives: Vec<Alternative> =
        rivals.iter().map(|id| Alternative { id: (*id).into(), probability: 0.3 }).collect();
    let effect = |((id, _), parameter): (&(&str, f64), Estimate)| EffectAnswer {
        id: (*id).into(),
        locus: Locus::PitchMoment,
        equation: "M -= Mc sign(q)".into(),
        parameters: vec![parameter],
        by_part: BTreeMap::new(),
        probability: 0.7,
        alternatives: alternatives.clone(),
        share: 0.9,
        evidence: Evidence {
            log_evidence: 1963.0,
            p_value: 0.0,
            vaf_gain_points: WithError { value: 16.7, standard_error: 1.0 },
            held_out_log_likelihood: WithError { value: 900.0, standard_error: 80.0 },
        },
    };
    let vaf = |free_run| VafAnswer {
        free_run,
        horizons: BTreeMap::from([("1.0", WithError { value: free_run + 1.0, standard_error: 0.5 })]),
    };
    let held = |_| HeldOutAnswer {
        baseline: vaf(79.6),
        extended: vaf(96.3),
        past_alone: 40.0,
        past_alone_far: 10.0,
        share_of_motion: 0.5,
        terms: Vec::new(),
    };
    let mut answer = Answer {
        schema: "pitchid.diagnosis/1",
        verdict,
        summary: "Dry friction, or a deadband.".into(),
        effects: effects.iter().zip(added).map(effect).collect(),
        location: Some(location()),
        fit: FitAnswer {
            baseline: model(79.6, plant()),
            extended: model(96.3, after),
            held_out: ["I", HOSTILE].map(|label| (label.to_owned(), held(label))).into(),
            predicted: Some(Predicted::Far),
            chosen_in: BTreeMap::new(),
            ceiling_vaf_percent: BTreeMap::from([("I".into(), 97.0)]),
        },
        in_model: Vec::new(),
        remainder: Some(Remainder {
            words: "a friction that falls with the speed".into(),
            variable: "q".into(),
            equation: String::new(),
            parameters: Vec::new(),
            share: 0.04,
            tests: vec![FailedTest { name: "constancy", p_value: 1e-4 }],
        }),
        next_experiment: Some(NextExperiment {
            switching_s: [0.05, 0.1],
            amplitude_rad: 0.012,
            length_s: 40.0,
            section: "quasi-open loop",
            separates: ["coulomb_friction".into(), "servo_deadband".into()],
            why: "a small signal shows the deadband".into(),
        }),
        data_checks: vec![
            DataCheck::found("feedback", Gravity::Headline, HOSTILE),
            DataCheck::cannot_tell("input_hold", "half a sample"),
            DataCheck::ruled_out("rate_sign", "correlation 1.00"),
        ],
        per_unit_inertia: false,
        notes: vec![HOSTILE.into()],
        questions: Vec::new(),
        balance: None,
    };
    answer.questions = questions(&answer);
    answer
}

fn location() -> Location {
    Location {
        locus: Locus::PitchMoment,
        time_s: vec![[2.0, 3.0]],
        band_rad_s: [0.5, 7.0],
        variable: "q".into(),
        condition: "when the pitch rate changes sign".into(),
        dependence: vec![Dependence {
            variable: "q".into(),
            unit: "rad/s".into(),
            share: 0.25,
            classes: vec![[-0.3, 0.1, 0.01], [0.3, -0.1, 0.01]],
        }],
    }
}
