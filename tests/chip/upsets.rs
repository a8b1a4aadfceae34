//! Upsets in the loop on the emulated chip: limits hit in every part of a test, a sensor the wrong way round, resets, floods
//! of valid frames. What was told before an upset is the host's, bit for bit; what comes after it is safe.

use std::collections::BTreeSet;
use std::time::Duration;

use estimator_core::{Config, Phase, Section};
use messages::board::{
    COMMAND_LONG_DATA, MANUAL_CONTROL_DATA, MavCmd, MavMessage, MavResult, PARAM_REQUEST_LIST_DATA,
    PARAM_REQUEST_READ_DATA,
};
use pitchid_tests::chip::Pilot;
use pitchid_tests::chip::case::{TICKS, fly, fly_until, ready};
use pitchid_tests::chip::twin::{NOT_KEPT, configure};

/// Flies a test whose rate reads `offset` too much from the tenth tick of each part on until the supervisor acts; how many of
/// the parts saw a recovery, and how it ended.
fn hit_in_every_part(pilot: &mut Pilot, config: &Config, offset: f32) -> (usize, Phase) {
    let (mut part, mut ticks) = (Section::Between, 0);
    let (mut flown, mut seen, mut recovered, mut end) = (Section::Between, 0, BTreeSet::new(), Phase::Idle);
    let limits = config.supervisor;
    fly_until(
        pilot,
        config,
        |_, last, sensor| {
            let Some(last) = last else { return };
            ticks = if last.section == part { ticks + 1 } else { 0 };
            part = last.section;
            if last.phase != Phase::Exciting && ticks >= 10 {
                ticks = 1000;
            }
            if (10..1000).contains(&ticks) {
                sensor.ygyro += offset;
            }
        },
        |_, _, _| (),
        |told, texts| {
            if told.phase.runs() && told.section != flown {
                (flown, seen) = (told.section, seen + 1);
            }
            if texts.contains("recovering: ") {
                recovered.insert(seen);
            }
            let beyond = told.sample.is_some_and(|sample| {
                sample.theta_rad.abs() > limits.trip_theta_rad || sample.q_rad_s.abs() > limits.trip_q_rad_s
            });
            if beyond && told.phase.runs() {
                assert!(matches!(told.phase, Phase::Recovering { .. }), "tick {}", told.tick);
                assert!(told.supervised && told.excitation_rad == 0.0, "tick {}", told.tick);
            }
            end = told.phase;
            told.phase.ended()
        },
    );
    (recovered.len(), end)
}

#[test]
fn a_limit_hit_in_every_part_of_a_test_is_answered_in_the_same_cycle_and_the_test_goes_on() {
    let Some((mut pilot, mut config)) = ready() else { return };
    config.plan.section_s = 1.0;
    config.plan.lead_in_s = 1.0;
    config.plan.pause_s = 1.0;
    config.plan.closed_loop_s = 1.0;
    configure(&mut pilot, &config);
    assert_eq!(hit_in_every_part(&mut pilot, &config, 4.0), (8, Phase::Done));
    println!("fault case: limit of the rate hit in each of the eight parts of a test: recovered, finished");
    config.supervisor.release_theta_rad = 0.06;
    config.supervisor.trip_theta_rad = 0.12;
    configure(&mut pilot, &config);
    assert_eq!(hit_in_every_part(&mut pilot, &config, 1.8), (8, Phase::Done));
    println!("fault case: limit of the angle hit in each of the eight parts of a test: recovered, finished");
}

#[test]
fn a_gyro_the_wrong_way_round_ends_in_an_abort() {
    let Some((mut pilot, config)) = ready() else { return };
    let (mut told_abort, mut ticks, mut last) = (String::new(), 0, 0.0);
    fly_until(
        &mut pilot,
        &config,
        |_, _, sensor| sensor.ygyro = -sensor.ygyro,
        |_, _, _| (),
        |told, texts| {
            (ticks, last) = (ticks + 1, told.u_rad);
            if texts.contains("aborted: ") {
                told_abort = texts.to_owned();
            }
            told.phase.ended() || ticks > 10 * TICKS
        },
    );
    println!("fault case: gyro inverted: {told_abort:?} after {ticks} ticks, u {last}");
    assert!(!told_abort.is_empty(), "an inverted gyro was borne for {ticks} ticks");
}

#[test]
fn a_reset_in_any_cycle_leaves_a_disarmed_board_that_tells_so() {
    let mut state = 7_u32;
    for _ in 0..3 {
        let Some((mut pilot, config)) = ready() else { return };
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let at = 20 + (state >> 16) % 300;
        // every cycle before it is compared with the host's
        fly_until(&mut pilot, &config, |_, _, _| (), |_, _, _| (), |told, _| told.tick + 1 >= at);
        pilot.emulator.reset();
        let greeting = pilot.wait_for(|message| match message {
            MavMessage::STATUSTEXT(text) => text.text.to_str().ok().map(str::to_owned),
            _ => None,
        });
        assert_eq!(greeting, "pitchid: up at 16 MHz");
        assert_eq!(
            pilot.command(MavCmd::MAV_CMD_USER_1, 1.0),
            MavResult::MAV_RESULT_DENIED,
            "it is disarmed"
        );
        println!("fault case: reset in cycle {at}: told, disarmed");
    }
}

#[test]
fn a_flood_of_valid_frames_does_not_disturb_the_cycle() {
    let Some((mut pilot, config)) = ready() else { return };
    let mut flood = Vec::new();
    for _ in 0..40 {
        // for another system, for nobody, and for this one without an effect
        let foreign = COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
            target_system: 9,
            ..COMMAND_LONG_DATA::default()
        };
        flood.extend(pilot.frame(&foreign));
        flood.extend(
            pilot.frame(&PARAM_REQUEST_READ_DATA { param_index: 999, ..PARAM_REQUEST_READ_DATA::default() }),
        );
        flood.extend(pilot.frame(&MANUAL_CONTROL_DATA { target: 1, ..MANUAL_CONTROL_DATA::default() }));
    }
    let end = fly(
        &mut pilot,
        &config,
        |_, _| (),
        |tick, pilot, _| {
            if (60..90).contains(&tick) {
                pilot.emulator.send(&flood);
            }
        },
    );
    assert!(end.phase.runs(), "{}", end.texts.trim());
    println!("fault case: 3600 valid frames in 30 cycles: borne");
}

#[test]
fn a_flood_of_questions_costs_answers_but_no_cycle() {
    let Some((mut pilot, _)) = ready() else { return };
    pilot.order(MavCmd::MAV_CMD_DO_SET_MODE, 0.0);
    let question = pilot.frame(&PARAM_REQUEST_LIST_DATA::default());
    pilot.emulator.send(&question.repeat(300));
    let (mut last, mut cycles, mut answers) = (None, 0, 0);
    while let Some(message) = pilot.hear_within(Duration::from_secs(2)) {
        match message {
            MavMessage::DEBUG_FLOAT_ARRAY(array) => {
                let tick = array.data[0];
                assert!(last.is_none_or(|last| tick > last), "the board began anew: {last:?} {tick}");
                (last, cycles) = (Some(tick), cycles + 1);
            }
            MavMessage::PARAM_VALUE(_) => answers += 1,
            MavMessage::STATUSTEXT(text) if text.text.to_str() != Ok(NOT_KEPT) => {
                panic!("{:?}", text.text.to_str())
            }
            _ => {}
        }
        if cycles > 100 && answers > 0 {
            break;
        }
    }
    assert!(cycles > 100, "{cycles} cycles told");
    println!(
        "fault case: 300 questions for all parameters at once: {answers} answers, no cycle lost its deadline"
    );
}
