//! Laws of the whole cycle that hold for every vehicle, however it behaves.

use estimator_core::constants::TAPS;
use estimator_core::plan::PlanConfig;
use estimator_core::{
    Command, Config, Cycle, CycleState, Event, Input, Phase, Sample, Section, Telemetry, Vehicle, fly,
};
use proptest::prelude::*;

const TRIP_RAD: f32 = 0.40;

fn short_test(seed: u64) -> Config {
    let plan = PlanConfig { lead_in_s: 0.2, section_s: 3.0, pause_s: 0.4, closed_loop_s: 2.0 };
    Config { seed, plan, ..Config::default() }
}

/// Flies `cycle` on samples that `theta_and_q` makes of the last report, until it ends or `most` ticks are
/// over.
fn fly_on(
    cycle: &Cycle<TAPS>,
    most: u32,
    mut theta_and_q: impl FnMut(u32, f32) -> Option<(f32, f32)>,
) -> (Vec<Telemetry>, CycleState<TAPS>) {
    let mut state = cycle.initial_state();
    let mut reports: Vec<Telemetry> = Vec::new();
    for tick in 0..most {
        let last_u = reports.last().map_or(0.0, |r| r.u_rad);
        let now_us = u64::from(tick) * 20_000;
        let sample = theta_and_q(tick, last_u).map(|(theta_rad, q_rad_s)| Sample {
            time_us: now_us,
            q_rad_s,
            theta_rad,
        });
        let command = if tick == 0 { Command::Start } else { Command::None };
        reports.push(cycle.step(&mut state, &Input { tick, now_us, sample, theta_ref_rad: 0.2, command }));
        if reports.last().is_some_and(|r| r.phase.ended()) {
            break;
        }
    }
    (reports, state)
}

/// Nominal rigid airframe with three samples of delay and a moment that drifts (rad/s²).
fn airframe(moment: f32) -> impl FnMut(u32, f32) -> Option<(f32, f32)> {
    let (mut theta, mut q, mut line) = (0.0_f32, 0.0_f32, [0.0_f32; 4]);
    move |tick, u| {
        line.rotate_right(1);
        line[0] = u;
        let gust = moment * (0.7 * tick as f32 * 0.02).sin();
        for _ in 0..20 {
            q += 1e-3 * (-1.583 * q + 134.9 * line[3] + gust);
            theta += 1e-3 * q;
        }
        // sensors are never silent; one that is counts as frozen
        let noise = 1e-4 * ((tick * 7919) % 101) as f32 - 5e-3;
        Some((theta + noise, q + noise))
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever the angle does, the excitation never reaches the servo in a tick that finds it beyond the
    /// limit.
    #[test]
    fn never_excites_beyond_the_limit(
        seed in any::<u64>(),
        angles in prop::collection::vec(-0.8_f32..0.8, 800),
        present in prop::collection::vec(prop::bool::weighted(0.9), 800),
    ) {
        let cycle = short_test(seed).build().unwrap();
        let (reports, _) = fly_on(&cycle, 800, |tick, _| {
            let k = tick as usize;
            present[k].then(|| (angles[k], 0.1 * angles[(k * 7) % 800]))
        });
        for report in &reports {
            if report.sample.is_some_and(|s| s.theta_rad.abs() > TRIP_RAD) {
                prop_assert_eq!(report.excitation_rad, 0.0, "tick {}", report.tick);
            }
        }
    }

    /// Every test ends, with a cause: within its own length, its recoveries, and one tick each.
    #[test]
    fn always_terminates(
        seed in any::<u64>(),
        angles in prop::collection::vec(-0.8_f32..0.8, 64),
        hold in 1_usize..400,
    ) {
        let config = short_test(seed);
        let cycle = config.build().unwrap();
        let most = 612 + u32::from(config.supervisor.max_recoveries) * 252 + 1;
        let (reports, _) = fly_on(&cycle, most, |tick, _| {
            let k = tick as usize;
            let wobble = 1e-4 * (tick % 5) as f32;
            Some((angles[(k / hold) % 64] + wobble, wobble))
        });
        prop_assert!(reports.last().unwrap().phase.ended());
        prop_assert!(reports.last().unwrap().event.is_some());
    }

    /// The excitation that was flown, holds cut out, is the sequence without holds.
    #[test]
    fn resumes_at_the_same_place(seed in any::<u64>(), moment in 0.0_f32..2.0) {
        let cycle = short_test(seed).build().unwrap();
        let flown = |moment: f32| {
            let (reports, _) = fly_on(&cycle, 20_000, airframe(moment));
            [Section::I, Section::II, Section::III].map(|section| {
                let free = reports.iter().filter(|r| r.section == section && !r.supervised);
                free.map(|r| r.excitation_rad).collect::<Vec<_>>()
            })
        };
        let disturbed = flown(moment);
        prop_assert_eq!(disturbed[0].len(), 150);
        // without the moment the recoveries fall elsewhere, or nowhere
        prop_assert_eq!(disturbed, flown(0.0));
    }
}

#[test]
fn a_whole_test_flies_its_sections_and_finds_the_airframe() {
    let mut config = Config { seed: 7, ..Config::default() };
    config.lms.step = 0.1;
    let cycle = config.build().unwrap();
    let (reports, state) = fly_on(&cycle, 100_000, airframe(0.0));
    assert_eq!(reports.last().unwrap().phase, Phase::Done);
    for section in [Section::I, Section::II, Section::III] {
        let rows: Vec<_> = reports.iter().filter(|r| r.section == section).collect();
        let free = rows.iter().filter(|r| !r.supervised);
        assert!(free.clone().all(|r| r.u_rad.abs() == 0.015), "quasi-open loop: nothing but the excitation");
        assert_eq!(free.count(), 1250);
    }
    let level_before = reports.iter().find(|r| r.section == Section::II).unwrap();
    assert!(level_before.sample.unwrap().theta_rad.abs() < 0.1, "the pause brings the vehicle to level");
    let end = reports.iter().rfind(|r| r.section == Section::IV).unwrap();
    assert!((end.sample.unwrap().theta_rad - 0.2).abs() < 0.01, "IV follows its reference");
    let pulse = |i: i32| 85.2 * (1.0 - (-1.583_f32 * 0.02).exp()) * (-1.583_f32 * 0.02).exp().powi(i);
    // not the last taps: they gather what lies beyond the window
    for i in [0, 10, 20, 30] {
        let found = state.taps()[i as usize];
        assert!((found / pulse(i) - 1.0).abs() < 0.25, "tap {i}: {found} {}", pulse(i));
    }
}

#[test]
fn the_taps_rest_outside_the_excitation_and_in_recoveries() {
    let cycle = short_test(3).build::<TAPS>().unwrap();
    let mut state = cycle.initial_state();
    let mut vehicle = airframe(1.5);
    let (mut u, mut recovered) = (0.0, 0);
    for tick in 0..3000 {
        let (theta_rad, q_rad_s) = vehicle(tick, u).unwrap();
        let now_us = u64::from(tick) * 20_000;
        let sample = Some(Sample { time_us: now_us, q_rad_s, theta_rad });
        let command = if tick == 0 { Command::Start } else { Command::None };
        let before = *state.taps();
        let report = cycle.step(&mut state, &Input { tick, now_us, sample, theta_ref_rad: 0.0, command });
        u = report.u_rad;
        recovered += u32::from(report.supervised);
        if report.supervised || report.section.sequence().is_none() {
            assert_eq!(state.taps(), &before);
        }
    }
    assert!(recovered > 0, "this vehicle is meant to need recoveries");
}

#[test]
fn the_operator_and_a_frozen_gyro_end_a_test_with_their_cause() {
    let cycle = short_test(1).build::<TAPS>().unwrap();
    let mut vehicle = airframe(0.3);
    let (reports, _) = fly_on(&cycle, 5000, |tick, u| {
        let (theta, q) = vehicle(tick, u)?;
        Some((theta, if tick < 40 { q } else { 0.123 }))
    });
    let last = reports.last().unwrap();
    assert_eq!((last.tick, last.u_rad), (49, 0.0));
    let Some(event @ Event::Aborted(_)) = last.event else { panic!("{:?}", last.event) };
    assert_eq!(event.to_string(), "aborted: pitch rate unchanged for 10 samples");
}

/// A vehicle that is moved by what it is told and keeps every report.
struct Recorder<F> {
    moves: F,
    start_at: u32,
    u: f32,
    reports: Vec<Telemetry>,
}

impl<F: FnMut(u32, f32) -> Option<(f32, f32)>> Vehicle for Recorder<F> {
    fn sense(&mut self, tick: u32) -> Input {
        let now_us = u64::from(tick) * 20_000;
        let sample = (self.moves)(tick, self.u).map(|(theta_rad, q_rad_s)| Sample {
            time_us: now_us,
            q_rad_s,
            theta_rad,
        });
        let command = if tick == self.start_at { Command::Start } else { Command::None };
        Input { tick, now_us, sample, theta_ref_rad: 0.2, command }
    }

    fn actuate(&mut self, u_rad: f32) {
        self.u = u_rad;
    }

    fn emit(&mut self, telemetry: &Telemetry) {
        assert_eq!(telemetry.u_rad, self.u, "what is reported has been sent");
        self.reports.push(*telemetry);
    }
}

#[test]
fn a_vehicle_is_flown_from_the_wait_for_its_start_to_the_end() {
    let cycle = short_test(5).build::<TAPS>().unwrap();
    let (mut state, start_at) = (cycle.initial_state(), 20);
    // hardly moves, so there is nothing to recover from
    let moves = |tick, _| Some((1e-4 * (tick % 5) as f32, 1e-4 * (tick % 7) as f32));
    let mut vehicle = Recorder { moves, start_at, u: 0.0, reports: Vec::new() };
    assert_eq!(fly(&cycle, &mut state, &mut vehicle), Phase::Done);
    // lead-in, three sections, two pauses between them and one before IV, and the tick that finds nothing left
    let ticks = start_at + 10 + 3 * 150 + 3 * 20 + 100;
    let found: Vec<u32> = vehicle.reports.iter().map(|report| report.tick).collect();
    assert!(found.iter().copied().eq(0..=ticks), "{} cycles, {ticks} expected", found.len());
    let idle = vehicle.reports.iter().take_while(|report| report.phase == Phase::Idle).count();
    assert_eq!(idle, start_at as usize);
}

#[test]
fn the_state_of_64_taps_fits_its_budget() {
    assert!(size_of::<CycleState<64>>() + size_of::<Cycle<64>>() <= 1200);
}
