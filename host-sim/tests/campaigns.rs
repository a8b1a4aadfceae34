//! The paper's experiment in the simulator: every campaign and amplitude, determinism, and what the files hold.

use estimator_core::{Phase, Section};
use host_sim::calibrate::{Strength, draw_effect, simulate, vaf};
use host_sim::effects::every;
use host_sim::sensors::Noise;
use host_sim::{Air, Background, Flight, Others, Plant, Scenario, Setting, Table, fly, size_for_loss};
use std::collections::BTreeSet;

const EXCITED: [Section; 3] = [Section::I, Section::II, Section::III];

#[test]
fn every_campaign_and_amplitude_finishes() {
    for campaign in 1..=4 {
        for amplitude in [0.012, 0.015, 0.019] {
            for background in [Background::Clean, Background::Paper] {
                let seed = 10 * campaign as u64;
                let scenario =
                    Scenario { background, ..Scenario::campaign(campaign, amplitude, seed).unwrap() };
                let flight = fly(&scenario).unwrap();
                let case = format!("campaign {campaign}, {amplitude} rad, {background:?}");
                assert_eq!(flight.outcome, Phase::Done, "{case}");
                for section in EXCITED {
                    let free: Vec<_> = flight.section(section).filter(|row| !row.supervised).collect();
                    assert_eq!(free.len(), 1250, "{case}");
                    assert!(free.iter().all(|row| row.u_rad.abs() == amplitude), "{case}");
                }
                let steepest = flight.rows.iter().fold(0.0_f32, |top, row| top.max(row.theta_rad.abs()));
                assert!(steepest < 0.75, "{case}: {steepest} rad");
            }
        }
    }
}

#[test]
fn campaign_4_moves_at_about_half_a_radian_per_second() {
    let flight = fly(&Scenario::campaign(4, 0.015, 3).unwrap()).unwrap();
    let rates: Vec<f64> = flight.section(Section::I).map(|row| f64::from(row.q_rad_s)).collect();
    let rms = (rates.iter().map(|q| q * q).sum::<f64>() / rates.len() as f64).sqrt();
    assert!((0.2..0.6).contains(&rms), "{rms}");
}

#[test]
fn the_background_leaves_the_true_model_what_it_promises() {
    for (background, promised, of_three_poles) in
        [(Background::Clean, 98.0, 97.0), (Background::Lab, 90.0, 86.0), (Background::Paper, 75.0, 67.0)]
    {
        for air in Air::ALL {
            let mut explained: Vec<f64> = (0..8)
                .flat_map(|seed| {
                    let plant = Plant::drawn(seed);
                    let campaign = Scenario::campaign(4, 0.015, seed).unwrap();
                    let flight = fly(&Scenario { background, air, plant, ..campaign }).unwrap();
                    let simulated = simulate(plant, &[], seed, &flight);
                    EXCITED.map(|section| vaf(&flight, &simulated, section))
                })
                .collect();
            explained.sort_by(f64::total_cmp);
            let median = explained[explained.len() / 2];
            let expected = if air == Air::ThreePoles { of_three_poles } else { promised };
            let near = (median - expected).abs() < 0.2 * (100.0 - expected) + 0.5;
            assert!(near, "{background:?}, {air}: {median}");
        }
    }
}

#[test]
fn without_noise_and_background_the_true_model_is_exact() {
    for entry in every() {
        let effects = vec![Setting::usual(entry.id, false).unwrap()];
        let (background, noise) = (Background::None, Noise::none());
        let scenario = Scenario { effects, background, noise, ..Scenario::campaign(4, 0.015, 5).unwrap() };
        let flight = fly(&scenario).unwrap();
        let simulated = simulate(scenario.plant, &scenario.effects, 5, &flight);
        for section in [Section::I, Section::II, Section::III, Section::IV] {
            assert!(vaf(&flight, &simulated, section) > 99.9999, "{} {section}", entry.id);
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let scenario = |seed| {
        let effects = vec![Setting::usual("gust_disturbance", false).unwrap()];
        Scenario { effects, plant: Plant::drawn(seed), ..Scenario::campaign(2, 0.012, seed).unwrap() }
    };
    let [a, b, c] = [1, 1, 2].map(|seed| fly(&scenario(seed)).unwrap());
    assert_eq!(a.recording(), b.recording());
    assert_ne!(a.recording(), c.recording());
}

#[test]
fn the_recording_has_no_trace_of_the_truth_and_the_truth_names_it() {
    let effects = vec![
        Setting::new("servo_lag", &[("T", 0.07)]).unwrap(),
        Setting::new("coulomb_friction", &[("Mc", 0.05)]).unwrap(),
    ];
    let flight = fly(&Scenario { effects, ..Scenario::campaign(3, 0.015, 4).unwrap() }).unwrap();
    let text = flight.recording();
    let header = "t_s,u_rad,q_rad_s,theta_rad,qdot_rad_s2,section,supervised,theta_ref_rad";
    assert_eq!(text.lines().nth(1), Some(header));
    assert!(["servo", "friction", "plant", "inertia", "background"].iter().all(|word| !text.contains(word)));
    let truth: serde_json::Value = serde_json::from_str(&flight.truth_json().unwrap()).unwrap();
    assert_eq!(truth["effects"][0]["id"], "servo_lag");
    assert_eq!(truth["effects"][0]["parameters"][0]["value"], 0.07);
    assert_eq!(truth["effects"][1]["parameters"][0]["unit"], "N m");
    assert_eq!(truth["plant"]["dm_du"], 23.0);
    assert_eq!(truth["outcome"], "finished");
}

#[test]
fn a_size_is_found_for_a_given_cost() {
    let scenario = Scenario { background: Background::Clean, ..Scenario::campaign(4, 0.015, 6).unwrap() };
    let lag = Setting::usual("servo_lag", false).unwrap();
    let (setting, cost) = size_for_loss(&scenario, &lag, 5.0).unwrap();
    assert!((cost - 5.0).abs() < 0.5, "{setting:?} costs {cost}");
    let error = size_for_loss(&scenario, &lag, 99.0).unwrap_err().to_string();
    assert!(error.contains("cannot be reached"), "{error}");
}

#[test]
fn a_drawn_effect_costs_what_its_strength_says() {
    let scenario = Scenario { background: Background::Clean, ..Scenario::campaign(4, 0.019, 8).unwrap() };
    let ids = ["servo_lag", "coulomb_friction", "gravity_stiffness"];
    let (first, cost) = draw_effect(&scenario, &ids, Strength::Strong).unwrap();
    assert!((7.0..16.0).contains(&cost), "{first:?} costs {cost}");
    let (again, _) = draw_effect(&scenario, &ids, Strength::Strong).unwrap();
    assert_eq!(format!("{first:?}"), format!("{again:?}"));
}

/// FNV-1a over the bytes of a recording.
fn hash(flight: &Flight) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    flight.recording().bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

#[test]
fn the_bytes_of_known_flights_stay_what_they_are() {
    let effects = vec![Setting::usual("gust_disturbance", false).unwrap()];
    let gust = Scenario { effects, plant: Plant::drawn(1), ..Scenario::campaign(2, 0.012, 1).unwrap() };
    let paper = Scenario { background: Background::Paper, ..Scenario::campaign(4, 0.019, 7).unwrap() };
    assert_eq!(hash(&fly(&gust).unwrap()), 0x5d6b_42f6_0091_d572);
    assert_eq!(hash(&fly(&paper).unwrap()), 0x1090_599c_b268_bc3c);
}

#[test]
fn every_air_can_be_flown_and_is_told_in_the_truth_alone() {
    for background in [Background::Clean, Background::Lab, Background::Paper] {
        let flown = |air| {
            let scenario = Scenario { background, air, ..Scenario::campaign(4, 0.015, 12).unwrap() };
            fly(&scenario).unwrap()
        };
        let flights = Air::ALL.map(flown);
        for (air, flight) in Air::ALL.into_iter().zip(&flights) {
            assert_eq!(flight.outcome, Phase::Done, "{background:?} {air}");
            assert_eq!(
                flight.truth.background.sigma, flights[0].truth.background.sigma,
                "{background:?} {air}"
            );
            assert!(!flight.recording().contains(air.word()));
            let truth = serde_json::to_value(&flight.truth).unwrap();
            let told = truth["background"].get("air").and_then(|told| told.as_str());
            assert_eq!(told, (air != Air::BandPassed).then_some(air.word()));
            assert_eq!(flight.recording(), flown(air).recording());
        }
        let hashes: BTreeSet<u64> = flights.iter().map(hash).collect();
        assert_eq!(hashes.len(), Air::ALL.len());
    }
}

#[test]
fn a_gust_in_one_section_shakes_that_section_alone() {
    let scenario = |gusty| Scenario { gusty, ..Scenario::campaign(4, 0.015, 3).unwrap() };
    let [plain, gusty] = [None, Some((Section::II, 4.0))].map(|gusty| fly(&scenario(gusty)).unwrap());
    let missed = |flight: &Flight, section| {
        let simulated = simulate(flight.truth.plant, &[], 3, flight);
        vaf(flight, &simulated, section)
    };
    assert_eq!(missed(&plain, Section::I), missed(&gusty, Section::I));
    assert!(missed(&gusty, Section::II) < missed(&plain, Section::II) - 20.0);
    assert!((missed(&gusty, Section::III) - missed(&plain, Section::III)).abs() < 10.0);
}

#[test]
fn what_goes_on_beside_the_pitch_axis_is_logged_where_it_is_asked_for() {
    let others = Others { roll: true, yaw: true, roll_command: true, thrust: true, battery: true };
    let flight = fly(&Scenario { others, ..Scenario::campaign(4, 0.015, 3).unwrap() }).unwrap();
    let recording = flight.recording();
    assert!(recording.contains(",p_rad_s,r_rad_s,phi_rad,u_roll_rad,thrust_norm,battery_v\n"));
    let table = Table::of(&flight);
    let moves = |name| table.column(name).unwrap().windows(2).any(|pair| pair[0] != pair[1]);
    assert!(["p_rad_s", "u_roll_rad", "thrust_norm", "battery_v"].into_iter().all(moves));
}
