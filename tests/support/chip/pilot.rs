//! A ground station: sends messages, waits for answers.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use firmware::link::decoder::Decoder;
use firmware::link::frame::{Header, encode, sign};
use firmware::link::signing::Key;
use messages::MavlinkVersion::V2;
use messages::board::{
    COMMAND_LONG_DATA, DEBUG_FLOAT_ARRAY_DATA, MANUAL_CONTROL_DATA, MavCmd, MavMessage, MavModeFlag,
    MavResult, PARAM_SET_DATA,
};
use messages::{Message, MessageData};

use super::Emulator;

/// Longest wait for an answer. A loaded machine may be slow; a chip that hangs never answers.
const PATIENCE: Duration = Duration::from_secs(20);

/// The ground's end of the link.
pub struct Pilot {
    /// The chip.
    pub emulator: Emulator,
    decoder: Decoder,
    waiting: VecDeque<MavMessage>,
    sequence: u8,
    /// Key, and timestamp of the last frame, where what is sent is to be signed.
    pub signing: Option<(Key, u64)>,
    /// What the chip said first.
    pub greeting: String,
}

/// Link id of what is signed.
const LINK: u8 = 3;

impl Pilot {
    /// Waits until the chip has greeted: what is sent earlier is lost.
    pub fn new(emulator: Emulator) -> Self {
        let decoder =
            Decoder::new(|id| MavMessage::default_message_from_id(id).map(|_| MavMessage::extra_crc(id)));
        let (waiting, greeting) = (VecDeque::new(), String::new());
        let mut pilot = Self { emulator, decoder, waiting, sequence: 0, signing: None, greeting };
        pilot.greeting = pilot.wait_for(|message| match message {
            MavMessage::STATUSTEXT(text) => text.text.to_str().ok().map(str::to_owned),
            _ => None,
        });
        pilot
    }

    /// Sends one message.
    pub fn send<M: MessageData>(&mut self, message: &M) {
        let frame = self.frame(message);
        self.emulator.send(&frame);
    }

    /// The frame of one message, with the next sequence number and, where there is a key, the next timestamp.
    pub fn frame<M: MessageData>(&mut self, message: &M) -> Vec<u8> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = encode(Header { sequence: self.sequence, system: 255, component: 190 }, message);
        if let Some((key, timestamp)) = &mut self.signing {
            *timestamp += 1;
            sign(&mut frame, M::EXTRA_CRC, key, LINK, *timestamp);
        }
        frame.to_vec()
    }

    /// The next message, in the order of the wire.
    pub fn hear(&mut self) -> MavMessage {
        self.hear_within(PATIENCE).expect("the chip answers")
    }

    /// The next message, if one comes.
    pub fn hear_within(&mut self, patience: Duration) -> Option<MavMessage> {
        let begin = Instant::now();
        while self.waiting.is_empty() {
            if begin.elapsed() > patience {
                return None;
            }
            let Self { emulator, decoder, waiting, .. } = self;
            for byte in emulator.receive() {
                decoder.push(byte, |frame| {
                    let message = MavMessage::parse(V2, frame.id(), frame.payload());
                    waiting.push_back(message.expect("what the chip sends can be read"));
                });
            }
        }
        self.waiting.pop_front()
    }

    /// Passes over messages until `pick` takes one.
    pub fn wait_for<T>(&mut self, mut pick: impl FnMut(&MavMessage) -> Option<T>) -> T {
        let begin = Instant::now();
        loop {
            if let Some(found) = pick(&self.hear()) {
                return found;
            }
            assert!(begin.elapsed() < PATIENCE, "the chip talks, but not of what was asked");
        }
    }

    /// Sends a command and returns the answer to it.
    pub fn command(&mut self, command: MavCmd, param1: f32) -> MavResult {
        self.send(&COMMAND_LONG_DATA { command, param1, target_system: 1, ..COMMAND_LONG_DATA::default() });
        let result = self.wait_for(|message| match message {
            MavMessage::COMMAND_ACK(ack) if ack.command == command => Some(ack.result),
            _ => None,
        });
        if result == MavResult::MAV_RESULT_DENIED {
            // and the reason in words
            self.wait_for(|message| matches!(message, MavMessage::STATUSTEXT(_)).then_some(()));
        }
        result
    }

    /// Sends a command that must be taken.
    pub fn order(&mut self, command: MavCmd, param1: f32) {
        assert_eq!(self.command(command, param1), MavResult::MAV_RESULT_ACCEPTED, "{command:?} {param1}");
    }

    /// Simulated sensors and servos from now on.
    pub fn enter_hil(&mut self) {
        self.order(MavCmd::MAV_CMD_DO_SET_MODE, f32::from(MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED.bits()));
        // what the timer's cycles said before
        while self.hear_within(Duration::from_millis(300)).is_some() {}
    }

    /// Lets the servos move.
    pub fn arm(&mut self) {
        self.order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    }

    /// Starts a test.
    pub fn begin(&mut self) {
        self.order(MavCmd::MAV_CMD_USER_1, 1.0);
    }

    /// Breaks the test off.
    pub fn abort(&mut self) {
        self.order(MavCmd::MAV_CMD_USER_1, 0.0);
    }

    /// Moves the pilot's stick, −1000 to 1000.
    pub fn stick(&mut self, x: i16) {
        self.send(&MANUAL_CONTROL_DATA { x, target: 1, ..MANUAL_CONTROL_DATA::default() });
    }

    /// Asks for a value and returns the one that stands afterwards.
    pub fn set(&mut self, name: &str, param_value: f32) -> f32 {
        let wish = PARAM_SET_DATA {
            param_value,
            target_system: 1,
            param_id: name.into(),
            ..PARAM_SET_DATA::default()
        };
        self.send(&wish);
        self.wait_for(|message| match message {
            MavMessage::PARAM_VALUE(value) if value.param_id.to_str() == Ok(name) => Some(value.param_value),
            _ => None,
        })
    }

    /// Sends a piece of the monitor's model; the pieces that the chip then has, and whether it took (1) or refused (−1) it.
    pub fn upload(&mut self, piece: &DEBUG_FLOAT_ARRAY_DATA) -> (u8, i8) {
        self.send(piece);
        self.answer(piece)
    }

    /// The answer to a piece that was sent.
    pub fn answer(&mut self, piece: &DEBUG_FLOAT_ARRAY_DATA) -> (u8, i8) {
        self.wait_for(|message| match message {
            MavMessage::DEBUG_FLOAT_ARRAY(answer) if answer.name == piece.name => {
                let [have, state, ..] = answer.data;
                (answer.array_id == piece.array_id).then_some((have as u8, state as i8))
            }
            _ => None,
        })
    }

    /// The next text that begins so.
    pub fn text(&mut self, begin: &str) -> String {
        self.wait_for(|message| match message {
            MavMessage::STATUSTEXT(text) => {
                text.text.to_str().ok().filter(|text| text.starts_with(begin)).map(str::to_owned)
            }
            _ => None,
        })
    }
}
