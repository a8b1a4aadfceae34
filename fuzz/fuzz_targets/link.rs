//! The board's link: bytes as they come, and frames with valid checksums of any content, between cycles of the core.
#![no_main]

use arbitrary::Arbitrary;
use estimator_core::constants::MAX_TAPS;
use estimator_core::{Command, Config, Input, Sample};
use firmware::link::decoder::{Decoder, LONGEST};
use firmware::link::ground::extra_crc;
use firmware::link::{Action, Ground};
use firmware::watch::Watch;
use libfuzzer_sys::fuzz_target;
use messages::calculate_crc;

/// Ids of the messages that the board understands.
const KNOWN: [u32; 8] = [76, 350, 107, 69, 21, 20, 23, 256];

#[derive(Arbitrary, Debug)]
enum Event<'a> {
    Bytes(&'a [u8]),
    Frame { message: u8, flags: u8, sequence: u8, payload: &'a [u8] },
    Cycle { q: f32, theta: f32, lost: bool },
}

/// A frame with a valid checksum; a signature of zeros where it claims to be signed.
fn frame(message: u8, flags: u8, sequence: u8, payload: &[u8]) -> Vec<u8> {
    let id = KNOWN[usize::from(message) % KNOWN.len()];
    let payload = &payload[..payload.len().min(255)];
    let [low, middle, high, _] = id.to_le_bytes();
    let mut bytes = vec![0xFD, payload.len() as u8, flags & 1, 0, sequence, 255, 190, low, middle, high];
    bytes.extend(payload);
    let crc = calculate_crc(&bytes[1..], extra_crc(id).expect("a message that the board understands"));
    bytes.extend(crc.to_le_bytes());
    bytes.resize(bytes.len() + if flags & 1 == 1 { 13 } else { 0 }, 0);
    bytes
}

fuzz_target!(|events: Vec<Event<'_>>| {
    let mut ground = Ground::new(Config::default()).expect("the defaults are legal");
    ground.sensors = true;
    let mut decoder = Decoder::new(extra_crc);
    let mut test = *ground.test();
    let mut state = test.initial_state();
    let mut watch = Watch::default();
    let mut command = Command::None;
    let mut armed = false;
    let mut tick = 0;
    for event in events.iter().take(200) {
        let bytes = match event {
            Event::Bytes(bytes) => bytes.to_vec(),
            Event::Frame { message, flags, sequence, payload } => frame(*message, *flags, *sequence, payload),
            Event::Cycle { q, theta, lost } => {
                let now_us = u64::from(tick) * 20_000;
                let sample = Sample { time_us: now_us, q_rad_s: *q, theta_rad: *theta };
                let input =
                    Input { tick, now_us, sample: (!lost).then_some(sample), theta_ref_rad: 0.0, command };
                let telemetry = test.step(&mut state, &input);
                assert!(telemetry.u_rad.is_finite(), "what the servo gets is a number");
                let report = watch.step(&telemetry);
                let taps = *state.taps();
                ground.report(&telemetry, report.as_ref(), || taps, &mut |out| assert!(out.len() <= LONGEST));
                (tick, command) = (tick + 1, Command::None);
                continue;
            }
        };
        for byte in bytes {
            let mut action = None;
            decoder.push(byte, |frame| {
                action = ground.receive(&frame, &mut |out| assert!(out.len() <= LONGEST));
            });
            match action {
                Some(Action::Arm) => armed = true,
                Some(Action::Disarm) => armed = false,
                Some(Action::Start) => {
                    assert!(armed, "no test begins on a vehicle that is not armed");
                    test = *ground.test();
                    state = test.initial_state();
                    command = Command::Start;
                }
                Some(Action::Abort) => command = Command::Abort,
                Some(Action::Model) => ground.begin(&mut watch),
                Some(Action::Reference(theta)) => assert!(theta.abs() <= 0.31),
                Some(Action::Hil(_) | Action::Tick(_)) | None => {}
            }
        }
        let _ = ground.take_unsaved();
    }
    let _: [f32; MAX_TAPS] = *state.taps();
});
