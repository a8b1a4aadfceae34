//! What recordings tell, held against the truth of the simulator.

use experiment::forecast::{estimated, recordings};
use experiment::{Craft, Test, Weather};
use host_sim::Setting;
use sysid::likelihood::contest::contest;

const TEST: Test = Test {
    dwell_s: [0.1, 0.2],
    amplitude_rad: 0.015,
    section_s: 10.0,
    closed_loop_s: 10.0,
    trip_theta_rad: 0.3,
};

fn craft() -> Craft {
    let text = "[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\ndM_du_N_m = 23.0\n";
    Craft::of_model(sysid::model::file::parse("m.toml", text, None, &[]).unwrap(), "m.toml").unwrap()
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    let craft = craft();
    let truth = [("dM_dq", -0.27_f64), ("dM_du", 23.0), ("delay", 0.06)];
    let (mut held, mut all) = (0, 0);
    for seed in 0..25 {
        let estimates = estimated(&[TEST], &craft, &[], Weather::default(), seed).unwrap();
        for (name, value) in truth {
            let [low, high] = estimates.iter().find(|estimate| estimate.name == name).unwrap().ci95;
            assert!(high - low < value.abs(), "{name}: {low} {high}");
            held += usize::from((low..=high).contains(&value));
            all += 1;
        }
    }
    // 95 % of 75 is 71; fewer than 65 has a probability of 0.002
    assert!(held >= 65, "{held} of {all}");
}

#[test]
fn a_contest_goes_to_the_one_that_is_there_at_its_size() {
    let craft = craft();
    let lag = Setting::new("servo_lag", &[("T", 0.08)]).unwrap();
    let found = recordings(&[TEST], &craft, &[lag], Weather::default(), 3).unwrap();
    let contest = contest(&found, &craft.model, ["servo_lag", "coulomb_friction"]).unwrap();
    assert!(contest.evidence > 20.0, "{contest:?}");
    let (name, value) = &contest.parameters[0][0];
    assert!(name == "T" && (value / 0.08 - 1.0).abs() < 0.3, "{contest:?}");
}

#[test]
fn a_rival_that_no_catalogue_has_is_named() {
    let craft = craft();
    let found = recordings(&[TEST], &craft, &[], Weather::default(), 3).unwrap();
    let refused = contest(&found, &craft.model, ["servo_lag", "gremlins"]).unwrap_err();
    assert!(refused.to_string().contains("gremlins"), "{refused}");
}
