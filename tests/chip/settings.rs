//! Settings that the flash held before the power came: parameters and key are those, from the first frame on.

use std::time::Duration;

use estimator_core::Config;
use firmware::link::frame::{Header, encode, sign};
use firmware::link::signing::Key;
use firmware::parameters::{self, PARAMETERS};
use firmware::settings::Settings;
use messages::MessageData;
use messages::board::{COMMAND_LONG_DATA, MavCmd, MavMessage, MavResult};
use pitchid_tests::chip::twin::NOT_KEPT;
use pitchid_tests::chip::{Flash, Pilot};

/// The chip, its flash holding `settings`.
fn boot(settings: &Settings) -> Option<Pilot> {
    Flash::holding(|memory| memory.keep(settings)).boot()
}

fn value(pilot: &mut Pilot, name: &str) -> f32 {
    // a value that no parameter takes is answered with the one that stands
    pilot.set(name, f32::NAN)
}

#[test]
fn parameters_are_those_of_the_flash_and_a_change_that_is_not_kept_is_told() {
    let mut config = Config::default();
    parameters::set(&mut config, "LIM_THETA", 0.3125).expect("legal");
    parameters::set(&mut config, "LMS_TAPS", 64.0).expect("legal");
    let values = PARAMETERS.map(|parameter| parameter.value(&config));
    let Some(mut pilot) = boot(&Settings { values, signing: None }) else { return };
    for parameter in PARAMETERS {
        assert_eq!(value(&mut pilot, parameter.name), parameter.value(&config), "{}", parameter.name);
    }
    pilot.set("LIM_THETA", 0.25);
    // flash cannot be written in the emulator: what is seen is that the image notices
    pilot.wait_for(|message| match message {
        MavMessage::STATUSTEXT(text) => (text.text.to_str() == Ok(NOT_KEPT)).then_some(()),
        _ => None,
    });
    println!("fault case: a flash that does not take the settings: told");
}

#[test]
fn a_key_of_the_flash_holds_from_the_first_frame_on() {
    let values = PARAMETERS.map(|parameter| parameter.value(&Config::default()));
    let key = Key([0x5a; 32]);
    let Some(mut pilot) = boot(&Settings { values, signing: Some((key, 50_000)) }) else { return };
    let order = COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_USER_1,
        param1: 0.0,
        target_system: 1,
        ..COMMAND_LONG_DATA::default()
    };
    let mut answer = |timestamp: Option<u64>| {
        let mut frame = encode(Header { sequence: 0, system: 255, component: 190 }, &order);
        if let Some(timestamp) = timestamp {
            sign(&mut frame, COMMAND_LONG_DATA::EXTRA_CRC, &key, 3, timestamp);
        }
        pilot.emulator.send(&frame);
        let answers = std::iter::from_fn(|| pilot.hear_within(Duration::from_millis(700)));
        answers.take(60).find_map(|message| match message {
            MavMessage::COMMAND_ACK(ack) => Some(ack.result),
            _ => None,
        })
    };
    assert_eq!(answer(None), None, "unsigned");
    assert_eq!(answer(Some(49_999)), None, "signed before the power went");
    assert_eq!(answer(Some(5_000_000)), Some(MavResult::MAV_RESULT_ACCEPTED));
    println!("fault case: unsigned and replayed orders after the power was off: passed over");
}
