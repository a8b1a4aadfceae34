//! The ground's end: everything heard goes to the recording and the screen first, then to whoever waits for it.

use super::link::{Link, News};
use super::texts::Texts;
use super::upload::{self, Answer};
use super::{CycleReport, Key, Log, Port, Stop};
use crate::failure::Failure;
use crate::output;
use estimator_core::monitor::MonitorModel;
use messages::board::{
    COMMAND_LONG_DATA, DEBUG_FLOAT_ARRAY_DATA, MavCmd, MavMessage, MavResult, PARAM_REQUEST_LIST_DATA,
    PARAM_SET_DATA,
};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// System and component of the board.
const BOARD: u8 = 1;
/// Pause before a question is asked again.
const AGAIN: Duration = Duration::from_millis(700);
/// How long a question is asked.
const PATIENCE: Duration = Duration::from_secs(15);

/// What was heard.
#[derive(Debug)]
pub enum Heard {
    /// A cycle.
    Cycle(CycleReport),
    /// A parameter's value and how many there are.
    Parameter { name: String, value: f32, count: u16 },
    /// The answer to a command.
    Answer(MavCmd, MavResult),
    /// The answer to a piece of the monitor's model.
    Piece(u16, Answer),
    /// The board lives.
    Alive,
    /// Anything else.
    Other,
}

/// A board, its recording, and what it last said.
pub struct Station {
    link: Link,
    texts: Texts,
    port: Port,
    log: Option<Log>,
    /// Only cycles of a test go to the recording.
    tests_only: bool,
    /// The last text.
    pub said: String,
    /// w as it last came, piece by piece.
    taps: BTreeMap<u16, (u64, [f32; 58])>,
}

impl Station {
    /// Opens the line.
    pub fn open(port: &Port, baud: u32, key: Option<&Key>) -> Result<Self, Failure> {
        Ok(Self {
            link: Link::open(port.clone(), baud, key.map(Key::signing))?,
            texts: Texts::default(),
            port: port.clone(),
            log: None,
            tests_only: false,
            said: String::new(),
            taps: BTreeMap::new(),
        })
    }

    /// From now on what is heard is recorded.
    pub fn record(&mut self, log: Log, tests_only: bool) {
        (self.log, self.tests_only) = (Some(log), tests_only);
    }

    /// The recording.
    pub fn log(&mut self) -> Option<&mut Log> {
        self.log.as_mut()
    }

    /// Ends the recording, which is then at its place.
    pub fn finish(&mut self) -> Result<Option<&mut Log>, Failure> {
        self.log.as_mut().map(|log| log.finish().map(|()| log)).transpose()
    }

    /// The next thing heard, if one comes in time. What has come is on its way to the disk before the wait.
    pub fn hear(&mut self, patience: Duration) -> Result<Option<Heard>, Failure> {
        let news = match self.link.hear(Duration::ZERO) {
            Some(news) => news,
            None => {
                if let Some(log) = &mut self.log {
                    log.flush()?;
                }
                let Some(news) = self.link.hear(patience) else { return Ok(None) };
                news
            }
        };
        Ok(Some(match news {
            News::Up => {
                output::print(&format!("{}: line open\n", self.port))?;
                Heard::Other
            }
            News::Down(why) => {
                self.note(&format!("line lost: {why}"))?;
                output::print(&format!("{}: line lost ({why}); trying again\n", self.port))?;
                Heard::Other
            }
            News::Message(message) => self.take(*message)?,
        }))
    }

    fn take(&mut self, message: MavMessage) -> Result<Heard, Failure> {
        Ok(match message {
            MavMessage::DEBUG_FLOAT_ARRAY(array) => match CycleReport::read(&array) {
                Some(report) => {
                    if let Some(log) = self.log.as_mut().filter(|_| !self.tests_only || report.phase.runs()) {
                        log.cycle(&report)?;
                    }
                    Heard::Cycle(report)
                }
                None => {
                    self.take_taps(&array);
                    upload::read(&array).map_or(Heard::Other, |(piece, answer)| Heard::Piece(piece, answer))
                }
            },
            MavMessage::STATUSTEXT(piece) => {
                if let Some(text) = self.texts.take(&piece) {
                    self.note(&text)?;
                    output::print(&format!("  board: {text}\n"))?;
                    self.said = text;
                }
                Heard::Other
            }
            MavMessage::PARAM_VALUE(value) => Heard::Parameter {
                name: value.param_id.to_str().unwrap_or_default().to_owned(),
                value: value.param_value,
                count: value.param_count,
            },
            MavMessage::COMMAND_ACK(ack) => Heard::Answer(ack.command, ack.result),
            MavMessage::HEARTBEAT(_) => Heard::Alive,
            _ => Heard::Other,
        })
    }

    fn note(&mut self, text: &str) -> Result<(), Failure> {
        self.log.as_mut().map_or(Ok(()), |log| log.note(text))
    }

    fn take_taps(&mut self, array: &DEBUG_FLOAT_ARRAY_DATA) {
        if array.name.to_str() == Ok("taps") {
            self.taps.insert(array.array_id, (array.time_usec, array.data));
        }
    }

    /// The first `count` taps (rad/s per rad), if all of them came of one cycle.
    pub fn taps(&self, count: usize) -> Option<Vec<f32>> {
        let newest = self.taps.values().map(|&(time_us, _)| time_us).max()?;
        let pieces = (0..).map_while(|id| self.taps.get(&id)).take_while(|(time_us, _)| *time_us == newest);
        let taps: Vec<f32> = pieces.flat_map(|(_, data)| data).copied().take(count).collect();
        (taps.len() == count).then_some(taps)
    }

    /// Waits for the board's first sign of life.
    pub fn greet(&mut self, stop: &Stop) -> Result<(), Failure> {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE && !stop.wanted() {
            if let Some(Heard::Alive | Heard::Cycle(_)) = self.hear(AGAIN)? {
                return Ok(());
            }
        }
        let message = format!("{}: no board answers", self.port);
        Err(Failure::new(
            message,
            "look at its power, at receive and transmit, and at the baud rate (--baud)",
        ))
    }

    /// Sends a command until it is answered.
    pub fn command(&mut self, command: MavCmd, param1: f32) -> Result<MavResult, Failure> {
        let order =
            COMMAND_LONG_DATA { command, param1, target_system: BOARD, ..COMMAND_LONG_DATA::default() };
        let answer = self.ask(&MavMessage::COMMAND_LONG(order), |heard| match heard {
            Heard::Answer(of, result) if *of == command => Some(*result),
            _ => None,
        })?;
        if answer == MavResult::MAV_RESULT_DENIED {
            // the reason follows the refusal
            let begin = Instant::now();
            self.said.clear();
            while self.said.is_empty() && begin.elapsed() < AGAIN {
                self.hear(AGAIN)?;
            }
        }
        Ok(answer)
    }

    /// Sends a command that must be taken.
    pub fn order(&mut self, command: MavCmd, param1: f32) -> Result<(), Failure> {
        match self.command(command, param1)? {
            MavResult::MAV_RESULT_ACCEPTED => Ok(()),
            _ => Err(Failure::new(
                format!("{}: {}", self.port, self.said),
                "do what the board asks for, then try again",
            )),
        }
    }

    /// Sets one parameter; the value that stands afterwards.
    pub fn set(&mut self, name: &str, param_value: f32) -> Result<f32, Failure> {
        let wish = PARAM_SET_DATA {
            param_value,
            target_system: BOARD,
            param_id: name.into(),
            ..PARAM_SET_DATA::default()
        };
        self.ask(&MavMessage::PARAM_SET(wish), |heard| match heard {
            Heard::Parameter { name: of, value, .. } if of == name => Some(*value),
            _ => None,
        })
    }

    /// All parameters by name.
    pub fn parameters(&mut self) -> Result<BTreeMap<String, f32>, Failure> {
        let mut found = BTreeMap::new();
        let request = PARAM_REQUEST_LIST_DATA { target_system: BOARD, target_component: 0 };
        self.ask(&MavMessage::PARAM_REQUEST_LIST(request), |heard| {
            let Heard::Parameter { name, value, count } = heard else { return None };
            found.insert(name.clone(), *value);
            (found.len() >= usize::from(*count)).then_some(())
        })?;
        Ok(found)
    }

    /// Gives the board a model of the monitor.
    pub fn upload(&mut self, model: &MonitorModel) -> Result<(), Failure> {
        let mut last = Answer::Partly;
        for piece in upload::pieces(model) {
            let number = piece.array_id;
            last = self.ask(&MavMessage::DEBUG_FLOAT_ARRAY(piece), |heard| match heard {
                Heard::Piece(of, answer) if *of == number => Some(*answer),
                _ => None,
            })?;
            if last == Answer::Refused {
                break;
            }
        }
        if last == Answer::Taken {
            return Ok(());
        }
        let found = format!("{}: {}", self.port, self.said);
        Err(Failure::new(
            found,
            "disarm the board, and make the monitor again with pitchid identify --monitor-out",
        ))
    }

    /// Sends a message without waiting for anything.
    pub fn send(&mut self, command: MavCmd, param1: f32) {
        let order =
            COMMAND_LONG_DATA { command, param1, target_system: BOARD, ..COMMAND_LONG_DATA::default() };
        self.link.send(&MavMessage::COMMAND_LONG(order));
    }

    /// Asks again and again until `pick` takes an answer.
    fn ask<T>(
        &mut self,
        question: &MavMessage,
        mut pick: impl FnMut(&Heard) -> Option<T>,
    ) -> Result<T, Failure> {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            self.link.send(question);
            let asked = Instant::now();
            while asked.elapsed() < AGAIN {
                if let Some(answer) = self.hear(AGAIN)?.as_ref().and_then(&mut pick) {
                    return Ok(answer);
                }
            }
        }
        let message = format!("{}: the board does not answer", self.port);
        Err(Failure::new(
            message,
            "if it has a signing key, name the key's file with --key; else look at the line",
        ))
    }
}
