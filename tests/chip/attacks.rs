//! Somebody else on the link of the emulated chip: forged, replayed, unsigned and endless traffic while a test runs.
//!
//! Every tick stays the host's, bit for bit, so nothing that came in has changed what the control cycle does.

use estimator_core::{Command, Config, Event, Fault, Phase};
use firmware::link::frame::{Header, encode, sign};
use firmware::link::signing::Key;
use firmware::parameters::PARAMETERS;
use firmware::settings::Settings;
use host_sim::Scenario;
use messages::MessageData;
use messages::board::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, MANUAL_CONTROL_DATA, MavCmd, PARAM_SET_DATA,
    SETUP_SIGNING_DATA,
};
use pitchid_tests::chip::twin::{configure, lockstep};
use pitchid_tests::chip::{Flash, Pilot, Simulated, Twin};

const OURS: Key = Key([0x5a; 32]);
const THEIRS: Key = Key([0xa5; 32]);
/// Ticks under attack: 40 s of flight.
const TICKS: u32 = 2000;
/// Tick of the abort.
const ABORT: u32 = 1900;

struct Attacker {
    random: u32,
    /// Frames of ours that went over the wire.
    heard: Vec<Vec<u8>>,
}

impl Attacker {
    fn random(&mut self, below: u32) -> u32 {
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.random >> 8) % below
    }

    fn order(command: MavCmd, param1: f32) -> COMMAND_LONG_DATA {
        COMMAND_LONG_DATA { command, param1, target_system: 1, ..COMMAND_LONG_DATA::default() }
    }

    /// A message that would do harm, signed with `key` or not at all.
    fn harm(&mut self, key: Option<(&Key, u64)>) -> Vec<u8> {
        fn frame<M: MessageData>(message: &M, key: Option<(&Key, u64)>) -> Vec<u8> {
            let mut frame = encode(Header { sequence: 7, system: 255, component: 190 }, message);
            if let Some((key, timestamp)) = key {
                sign(&mut frame, M::EXTRA_CRC, key, 3, timestamp);
            }
            frame.to_vec()
        }
        match self.random(7) {
            0 => frame(&Self::order(MavCmd::MAV_CMD_USER_1, 0.0), key),
            1 => frame(&Self::order(MavCmd::MAV_CMD_USER_1, 1.0), key),
            2 => frame(&Self::order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0), key),
            3 => frame(&MANUAL_CONTROL_DATA { x: 1000, target: 1, ..MANUAL_CONTROL_DATA::default() }, key),
            4 => {
                let param_id = "LIM_THETA".into();
                let wish = PARAM_SET_DATA { param_value: 1.5, param_id, ..PARAM_SET_DATA::default() };
                frame(&PARAM_SET_DATA { target_system: 1, ..wish }, key)
            }
            5 => {
                // an hour ahead: the loop would run away from the simulator
                let sensor = HIL_SENSOR_DATA { time_usec: 3_600_000_000, ygyro: 9.0, ..Default::default() };
                frame(&sensor, key)
            }
            _ => {
                let setup = SETUP_SIGNING_DATA { target_system: 1, ..SETUP_SIGNING_DATA::default() };
                frame(&SETUP_SIGNING_DATA { secret_key: THEIRS.0, ..setup }, key)
            }
        }
    }

    /// What they send before a tick.
    fn traffic(&mut self) -> Vec<u8> {
        let late = 1 << 46;
        match self.random(7) {
            0 => self.harm(None),
            1 => self.harm(Some((&THEIRS, late))),
            2 => {
                // ours by all but the signature
                let mut frame = self.harm(Some((&OURS, late)));
                let place = frame.len() - 1 - self.random(6) as usize;
                frame[place] ^= 1 << self.random(8);
                frame
            }
            3 | 4 => {
                let place = self.random(self.heard.len() as u32) as usize;
                self.heard[place].clone()
            }
            5 => (0..self.random(300)).map(|_| self.random(256) as u8 & 0x7f).collect(),
            _ => {
                let calls =
                    encode(Header { sequence: 1, system: 9, component: 1 }, &HEARTBEAT_DATA::default());
                (0..12).flat_map(|_| calls.to_vec()).collect()
            }
        }
    }
}

/// A pilot of a board whose flash holds our key.
fn ready() -> Option<Pilot> {
    let values = PARAMETERS.map(|parameter| parameter.value(&Config::default()));
    let mut pilot =
        Flash::holding(|memory| memory.keep(&Settings { values, signing: Some((OURS, 50_000)) })).boot()?;
    // the board was a minute ahead of the last frame when its power went
    pilot.signing = Some((OURS, 10_000_000));
    Some(pilot)
}

#[test]
fn an_attack_changes_nothing_and_an_abort_gets_through() {
    let Some(mut pilot) = ready() else { return };
    let mut scenario = Scenario::campaign(4, 0.015, 5).expect("campaign 4 exists");
    scenario.plan.section_s = 60.0;
    let config = scenario.core();
    pilot.enter_hil();
    configure(&mut pilot, &config);

    let mut attacker = Attacker { random: 1, heard: Vec::new() };
    let arm = Attacker::order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    attacker.heard.push(pilot.frame(&arm));
    // not yet ours: an unsigned, a forged and a foreign start before the vehicle is armed by us
    for frame in [attacker.harm(None), attacker.harm(Some((&THEIRS, 1 << 46)))] {
        pilot.emulator.send(&frame);
    }
    pilot.arm();
    pilot.begin();
    let (mut twin, mut aircraft) = (Twin::new(&config), Simulated::new(&scenario));
    twin.command = Command::Start;
    let (mut sent, mut ended) = (0, None);
    for tick in 0..TICKS {
        let (sensor, _) = aircraft.sense(tick);
        let traffic = attacker.traffic();
        sent += traffic.len();
        pilot.emulator.send(&traffic);
        // a start of a frame in what they sent may have swallowed what follows, up to the longest frame
        pilot.emulator.send(&[0; 300]);
        if tick == ABORT {
            pilot.abort();
            twin.command = Command::Abort;
        }
        let signing = pilot.signing;
        attacker.heard.push(pilot.frame(&sensor));
        pilot.signing = signing;
        let (telemetry, said) = lockstep(&mut pilot, &mut twin, &sensor);
        aircraft.advance(said.u_rad.unwrap_or_default(), &telemetry);
        if let Some(Event::Aborted(cause)) = telemetry.event {
            ended = Some((tick, cause));
            break;
        }
        assert!(telemetry.phase.runs() || telemetry.phase == Phase::Done, "{:?}", telemetry.phase);
    }
    assert_eq!(ended, Some((ABORT, Fault::Operator)));
    println!("fault case: {sent} bytes of forged, replayed, unsigned and endless traffic: passed over");
}
