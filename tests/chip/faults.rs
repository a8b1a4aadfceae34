//! Faults flown in the loop on the emulated chip: every tick is still the host's, bit for bit, and the end is the right one.

use std::time::Duration;

use estimator_core::Command;
use firmware::link::frame::{Header, encode, sign};
use firmware::link::signing::Key;
use messages::MessageData;
use messages::board::{
    COMMAND_LONG_DATA, HIL_SENSOR_DATA, HilSensorUpdatedFlags, MavCmd, MavMessage, MavResult,
    SETUP_SIGNING_DATA,
};
use pitchid_tests::chip::case::{fly, ready};
use pitchid_tests::chip::{Pilot, Twin};

/// Tick of the fault: in section I.
const FAULT: u32 = 60;

fn nothing(_: u32, _: &mut Pilot, _: &mut Twin) {}

fn clean(_: u32, _: &mut HIL_SENSOR_DATA) {}

type Spoil = fn(u32, &mut HIL_SENSOR_DATA);

/// Name, what happens to the sensor `n` ticks after the fault began, and the words of the abort; none where the test goes on.
const SENSOR_CASES: [(&str, Spoil, Option<&str>); 15] = [
    ("rate NaN", |_, s| s.ygyro = f32::NAN, Some("pitch rate is not a number")),
    ("rate infinite", |_, s| s.ygyro = f32::INFINITY, Some("pitch rate is not a number")),
    ("rate minus infinite", |_, s| s.ygyro = f32::NEG_INFINITY, Some("pitch rate is not a number")),
    ("force NaN", |_, s| s.xacc = f32::NAN, Some("pitch angle is not a number")),
    ("force infinite", |_, s| s.zacc = f32::INFINITY, Some("pitch angle is not a number")),
    ("rate frozen", |_, s| s.ygyro = 0.125, Some("pitch rate unchanged for 10 samples")),
    (
        "sensors silent",
        |_, s| s.fields_updated = HilSensorUpdatedFlags::empty(),
        Some("no sample for 3 ticks"),
    ),
    (
        "gyro alone silent",
        |_, s| s.fields_updated.remove(HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_YGYRO),
        Some("no sample for 3 ticks"),
    ),
    (
        "one sample lost",
        |n, s| {
            if n == 0 {
                s.fields_updated = HilSensorUpdatedFlags::empty();
            }
        },
        None,
    ),
    (
        "two samples lost",
        |n, s| {
            if n < 2 {
                s.fields_updated = HilSensorUpdatedFlags::empty();
            }
        },
        None,
    ),
    ("samples late", |_, s| s.time_usec -= 100_000, Some("no timely sample for 3 ticks")),
    (
        "one sample late",
        |n, s| {
            if n == 0 {
                s.time_usec -= 100_000;
            }
        },
        None,
    ),
    ("clock leaps", |_, s| s.time_usec += 10_000_000, Some("no sample for ")),
    (
        "rate spike",
        |n, s| {
            if n == 0 {
                s.ygyro = 4.0;
            }
        },
        None,
    ),
    (
        "shock",
        |n, s| {
            if n < 10 {
                s.xacc = 40.0;
            }
        },
        None,
    ),
];

#[test]
fn sensor_faults_end_the_test_with_their_cause_or_are_borne() {
    let Some((mut pilot, config)) = ready() else { return };
    for (name, spoil, cause) in SENSOR_CASES {
        let end = fly(
            &mut pilot,
            &config,
            |tick, s| {
                if tick >= FAULT {
                    spoil(tick - FAULT, s);
                }
            },
            nothing,
        );
        match cause {
            Some(cause) => {
                assert!(end.texts.contains(&format!("aborted: {cause}")), "{name}: {}", end.texts.trim());
            }
            None => assert!(end.phase.runs(), "{name}: {}", end.texts.trim()),
        }
        println!("fault case: {name}: {}", cause.unwrap_or("borne"));
    }
}

#[test]
fn a_rate_that_stays_beyond_the_limit_ends_in_neutral() {
    let Some((mut pilot, config)) = ready() else { return };
    let end = fly(
        &mut pilot,
        &config,
        |tick, s| {
            if tick >= FAULT {
                s.ygyro += 4.0;
            }
        },
        nothing,
    );
    assert!(end.texts.contains("aborted: not level 5.02 s after pitch"), "{}", end.texts.trim());
    assert_eq!(end.u_rad, 0.0);
    println!("fault case: rate beyond the limit for good: aborted");
}

/// Bytes that arrive in the middle of a test.
fn noise() -> Vec<(&'static str, Vec<u8>)> {
    let sensor =
        HIL_SENSOR_DATA { fields_updated: HilSensorUpdatedFlags::all(), ..HIL_SENSOR_DATA::default() };
    let frame = encode(Header { sequence: 9, system: 255, component: 190 }, &sensor);
    let mut broken = frame.to_vec();
    broken[20] ^= 0x10;
    // the length and the id of a known message, and never its end
    let mut overlong = vec![0xFD, 255, 0, 0, 0, 255, 190];
    overlong.extend(&HIL_SENSOR_DATA::ID.to_le_bytes()[..3]);
    overlong.extend([0x55; 300]);
    let mut state = 1_u32;
    let garbage = (0..600).map(|_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8 & 0x7f
    });
    vec![
        ("garbage", garbage.collect()),
        ("starts without end", vec![0xFD; 40].into_iter().chain([0; 300]).collect()),
        ("a truncated frame", frame[..20].to_vec()),
        ("an overlong frame", overlong),
        ("a frame with a flipped bit", broken),
    ]
}

#[test]
fn noise_on_the_link_does_not_disturb_the_cycle() {
    let Some((mut pilot, config)) = ready() else { return };
    for (name, bytes) in noise() {
        let end = fly(&mut pilot, &config, clean, |tick, pilot, _| {
            if (FAULT..FAULT + 20).contains(&tick) {
                pilot.emulator.send(&bytes);
            }
        });
        assert!(end.phase.runs(), "{name}: {}", end.texts.trim());
        println!("fault case: {name}: borne");
    }
}

#[test]
fn orders_out_of_place_are_refused() {
    let Some((mut pilot, config)) = ready() else { return };
    let denied = MavResult::MAV_RESULT_DENIED;
    assert_eq!(pilot.command(MavCmd::MAV_CMD_USER_1, 1.0), denied, "start while disarmed");
    let end = fly(&mut pilot, &config, clean, |tick, pilot, twin| match tick {
        60 => assert_eq!(pilot.command(MavCmd::MAV_CMD_USER_1, 1.0), denied, "a second start"),
        70 => {
            assert_eq!(pilot.set("EXC_AMPL", 0.02), config.prbs.amplitude_rad, "a parameter while exciting");
        }
        80 => assert_eq!(pilot.command(MavCmd::MAV_CMD_DO_SET_MODE, 0.0), denied, "leaving HIL while armed"),
        90 => {
            let unsupported = MavResult::MAV_RESULT_UNSUPPORTED;
            assert_eq!(pilot.command(MavCmd::MAV_CMD_NAV_TAKEOFF, 1.0), unsupported);
        }
        200 => {
            pilot.abort();
            twin.command = Command::Abort;
        }
        _ => {}
    });
    assert!(end.texts.contains("aborted: operator's command"), "{}", end.texts.trim());
    assert_eq!(pilot.set("EXC_AMPL", 0.5), config.prbs.amplitude_rad, "a parameter out of range");
    println!("fault case: six orders out of place: refused");

    let end = fly(&mut pilot, &config, clean, |tick, pilot, twin| {
        if tick == FAULT {
            pilot.order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
            twin.command = Command::Abort;
        }
    });
    assert!(end.texts.contains("aborted: operator's command"), "{}", end.texts.trim());
    println!("fault case: disarmed in the middle: aborted");

    pilot.order(MavCmd::MAV_CMD_DO_SET_MODE, 0.0);
    assert_eq!(pilot.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0), denied, "arming without an IMU");
    println!("fault case: arming without an IMU: refused");
}

#[test]
fn with_a_key_set_only_fresh_signed_orders_are_taken() {
    let Some((mut pilot, _)) = ready() else { return };
    let key = Key([0x5a; 32]);
    let secret_key = key.0;
    pilot.send(&SETUP_SIGNING_DATA {
        initial_timestamp: 1000,
        target_system: 1,
        secret_key,
        ..SETUP_SIGNING_DATA::default()
    });
    let arm = COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        param1: 1.0,
        target_system: 1,
        ..COMMAND_LONG_DATA::default()
    };
    let signed = |key: &Key, timestamp| {
        let mut frame = encode(Header { sequence: 0, system: 255, component: 190 }, &arm);
        sign(&mut frame, COMMAND_LONG_DATA::EXTRA_CRC, key, 3, timestamp);
        frame
    };
    let unsigned = encode(Header { sequence: 0, system: 255, component: 190 }, &arm);
    let fresh = signed(&key, 50_000);
    let mut taken = |bytes: &[u8]| {
        pilot.emulator.send(bytes);
        let answer = |pilot: &mut Pilot| pilot.hear_within(Duration::from_secs(1));
        std::iter::from_fn(|| answer(&mut pilot)).any(|message| matches!(message, MavMessage::COMMAND_ACK(_)))
    };
    assert!(!taken(&unsigned), "unsigned");
    assert!(!taken(&signed(&Key([1; 32]), 40_000)), "another key");
    assert!(!taken(&signed(&key, 999)), "older than the key");
    assert!(taken(&fresh), "fresh");
    assert!(!taken(&fresh), "replayed");
    println!("fault case: unsigned, another key, too old, replayed: passed over");
}
