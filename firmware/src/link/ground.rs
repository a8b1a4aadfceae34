//! What the ground asks, and the answers.
//!
//! ```text
//!   disarmed ── arm ──> armed ── start ──> a test runs ── finished, aborted ──> armed
//!      ^ │                │                    │
//!      │ └─ HIL on/off    └────── disarm ──────┴──> disarmed
//! ```
//!
//! With a key set, everything that comes in unsigned, replayed or signed with another key is passed over. What says that it comes from
//! this very vehicle always is: its own frames, thrown back.

use core::fmt::Write as _;

use estimator_core::constants::MAX_TAPS;
use estimator_core::monitor::{MonitorReport, Verdict};
use estimator_core::{Config, ConfigError, Cycle, Event, Phase, Telemetry};
use heapless::String;
use messages::MavlinkVersion::V2;
use messages::MessageData;
use messages::board::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, DEBUG_FLOAT_ARRAY_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA,
    MANUAL_CONTROL_DATA, MavAutopilot, MavCmd, MavModeFlag, MavParamType, MavResult, MavSeverity, MavState,
    MavType, PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, PARAM_VALUE_DATA,
    SETUP_SIGNING_DATA,
};

use crate::hil::{HilClock, HilTick};
use crate::link::decoder::Frame;
use crate::link::frame::{Header, encode, sign};
use crate::link::signing::{Gate, Key};
use crate::link::telemetry::{
    actuators, attitude, cycle_array, monitor_value, phase_code, taps_arrays, texts,
};
use crate::link::upload::{self, Progress, Refused, Upload};
use crate::parameters::{self, PARAMETERS, Refusal};
use crate::settings::Settings;
use crate::watch::Watch;

/// System and component of this vehicle.
pub const SYSTEM: u8 = 1;
const COMPONENT: u8 = 1;
/// Ticks between two of `ATTITUDE`.
const ATTITUDE_EVERY: u32 = 5;
/// Ticks between two of `HEARTBEAT` and of the taps.
const SECOND: u32 = 50;
/// θref at full stick, rad.
pub const FULL_STICK_RAD: f32 = 0.3;

/// What the board is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// The servos may move.
    Arm,
    /// Servos to neutral, whatever runs.
    Disarm,
    /// Begin a test with the configuration as it is now.
    Start,
    /// Break the test off.
    Abort,
    /// Sensors and servos are simulated from now on, or real again.
    Hil(bool),
    /// One simulated cycle.
    Tick(HilTick),
    /// Pitch reference of section IV, rad.
    Reference(f32),
    /// A model of the monitor has come: keep it.
    Model,
}

/// The ground's view of the vehicle, and the parameters.
#[derive(Clone)]
pub struct Ground {
    config: Config,
    test: Cycle<MAX_TAPS>,
    armed: bool,
    hil: bool,
    /// True when real sensors answer, so the vehicle may be armed without HIL.
    pub sensors: bool,
    running: bool,
    phase: Phase,
    clock: HilClock,
    /// Length of the estimate that is being flown or was flown last.
    taps: usize,
    taps_wanted: bool,
    /// Ticks until a change is to be kept.
    unsaved: Option<u32>,
    gate: Option<Gate>,
    upload: Upload,
    /// What the monitor said last; none before it has said anything since the vehicle was armed.
    verdict: Option<Verdict>,
    sequence: u8,
    text: u16,
}

/// Seed of the checksum of every message that [`Ground`] understands.
#[must_use]
pub fn extra_crc(id: u32) -> Option<u8> {
    Some(match id {
        COMMAND_LONG_DATA::ID => COMMAND_LONG_DATA::EXTRA_CRC,
        DEBUG_FLOAT_ARRAY_DATA::ID => DEBUG_FLOAT_ARRAY_DATA::EXTRA_CRC,
        HIL_SENSOR_DATA::ID => HIL_SENSOR_DATA::EXTRA_CRC,
        MANUAL_CONTROL_DATA::ID => MANUAL_CONTROL_DATA::EXTRA_CRC,
        PARAM_REQUEST_LIST_DATA::ID => PARAM_REQUEST_LIST_DATA::EXTRA_CRC,
        PARAM_REQUEST_READ_DATA::ID => PARAM_REQUEST_READ_DATA::EXTRA_CRC,
        PARAM_SET_DATA::ID => PARAM_SET_DATA::EXTRA_CRC,
        SETUP_SIGNING_DATA::ID => SETUP_SIGNING_DATA::EXTRA_CRC,
        _ => return None,
    })
}

impl Ground {
    /// A disarmed vehicle.
    ///
    /// # Errors
    /// A configuration that the core refuses.
    pub fn new(config: Config) -> Result<Self, ConfigError> {
        let test = config.build()?;
        Ok(Self {
            config,
            test,
            armed: false,
            hil: false,
            sensors: false,
            running: false,
            phase: Phase::Idle,
            clock: HilClock::default(),
            taps: usize::from(config.lms.taps),
            taps_wanted: false,
            unsaved: None,
            gate: None,
            upload: Upload::default(),
            verdict: None,
            sequence: 0,
            text: 0,
        })
    }

    /// Takes up what was kept; false where it is not legal and everything stays as it was.
    pub fn restore(&mut self, settings: &Settings) -> bool {
        let Some(config) = parameters::restore(&settings.values) else { return false };
        let Ok(test) = config.build() else { return false };
        (self.config, self.test, self.taps) = (config, test, usize::from(config.lms.taps));
        self.gate = settings.signing.map(|(key, timestamp)| Gate::new(key, timestamp));
        true
    }

    /// The monitor's model, and what has come of it.
    pub const fn upload(&mut self) -> &mut Upload {
        &mut self.upload
    }

    /// Begins `watch` anew, with the model and the configuration as they are now.
    #[inline(never)]
    pub fn begin(&self, watch: &mut Watch) {
        watch.begin(&self.config.monitor, self.upload.model().as_ref());
    }

    /// What is to be kept, a second after the last change.
    pub fn take_unsaved(&mut self) -> Option<Settings> {
        self.unsaved.take_if(|ticks| *ticks == 0)?;
        Some(self.settings())
    }

    /// What is to be kept before the frame that was taken last is obeyed, where its timestamp has passed the one in flash.
    pub fn take_reserved(&mut self) -> Option<Settings> {
        self.gate.as_mut()?.reserve()?;
        self.unsaved = None;
        Some(self.settings())
    }

    fn settings(&self) -> Settings {
        let values = PARAMETERS.map(|parameter| parameter.value(&self.config));
        Settings { values, signing: self.gate.as_ref().map(Gate::kept) }
    }

    /// The test that a start would begin.
    #[must_use]
    pub const fn test(&self) -> &Cycle<MAX_TAPS> {
        &self.test
    }

    /// Answers one frame.
    #[inline(never)]
    pub fn receive(&mut self, frame: &Frame<'_>, out: &mut impl FnMut(&[u8])) -> Option<Action> {
        let thrown_back = frame.sender() == [SYSTEM, COMPONENT];
        if thrown_back || self.gate.as_mut().is_some_and(|gate| !gate.admits(frame)) {
            return None;
        }
        let payload = frame.payload();
        match frame.id() {
            COMMAND_LONG_DATA::ID => self.command(&COMMAND_LONG_DATA::deser(V2, payload).ok()?, out),
            DEBUG_FLOAT_ARRAY_DATA::ID => {
                self.take_piece(&DEBUG_FLOAT_ARRAY_DATA::deser(V2, payload).ok()?, out)
            }
            HIL_SENSOR_DATA::ID => {
                let sensor = HIL_SENSOR_DATA::deser(V2, payload).ok()?;
                self.hil.then(|| Action::Tick(self.clock.step(&sensor)))
            }
            MANUAL_CONTROL_DATA::ID => {
                let stick = MANUAL_CONTROL_DATA::deser(V2, payload).ok()?;
                let share = f32::from(stick.x.clamp(-1000, 1000)) / 1000.0;
                (stick.target == SYSTEM).then_some(Action::Reference(FULL_STICK_RAD * share))
            }
            SETUP_SIGNING_DATA::ID => {
                let setup = SETUP_SIGNING_DATA::deser(V2, payload).ok()?;
                if !self.armed && setup.target_system == SYSTEM {
                    let off = setup.secret_key == [0; 32];
                    self.unsaved = Some(SECOND);
                    self.gate = (!off).then(|| Gate::new(Key(setup.secret_key), setup.initial_timestamp));
                }
                None
            }
            _ => {
                self.parameter(frame, out);
                None
            }
        }
    }

    fn command(&mut self, command: &COMMAND_LONG_DATA, out: &mut impl FnMut(&[u8])) -> Option<Action> {
        if ![0, SYSTEM].contains(&command.target_system) {
            return None;
        }
        let on = command.param1 == 1.0;
        let hil = command.param1 as u8 & MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED.bits() != 0;
        let answer = match command.command {
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM if on && (self.sensors || self.hil) => Ok(Action::Arm),
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM if on => Err("arming refused: the IMU does not answer"),
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => Ok(Action::Disarm),
            MavCmd::MAV_CMD_DO_SET_MODE if self.armed => Err("mode refused: disarm first"),
            MavCmd::MAV_CMD_DO_SET_MODE => Ok(Action::Hil(hil)),
            MavCmd::MAV_CMD_USER_1 if !on => Ok(Action::Abort),
            MavCmd::MAV_CMD_USER_1 if !self.armed => Err("start refused: arm first"),
            MavCmd::MAV_CMD_USER_1 if self.running => Err("start refused: a test runs"),
            MavCmd::MAV_CMD_USER_1 => Ok(Action::Start),
            MavCmd::MAV_CMD_REQUEST_MESSAGE if command.param1 == DEBUG_FLOAT_ARRAY_DATA::ID as f32 => {
                self.taps_wanted = true;
                self.send(&ack(command, MavResult::MAV_RESULT_ACCEPTED), out);
                return None;
            }
            _ => {
                self.send(&ack(command, MavResult::MAV_RESULT_UNSUPPORTED), out);
                return None;
            }
        };
        match answer {
            Ok(action) => {
                self.note(action);
                self.send(&ack(command, MavResult::MAV_RESULT_ACCEPTED), out);
                Some(action)
            }
            Err(why) => {
                self.send(&ack(command, MavResult::MAV_RESULT_DENIED), out);
                self.say(MavSeverity::MAV_SEVERITY_WARNING, why, out);
                None
            }
        }
    }

    /// A piece of the monitor's model.
    #[inline(never)]
    fn take_piece(&mut self, piece: &DEBUG_FLOAT_ARRAY_DATA, out: &mut impl FnMut(&[u8])) -> Option<Action> {
        if piece.name.to_str() != Ok(upload::NAME) {
            return None;
        }
        let taken = if self.armed { Err(Refused::Armed) } else { self.upload.take(piece) };
        if let Err(why) = &taken {
            let mut text = String::<120>::new();
            // what does not fit is left off
            let _ = write!(text, "{why}");
            self.say(MavSeverity::MAV_SEVERITY_WARNING, &text, out);
        }
        self.send(&self.upload.answer(piece, taken.is_err()), out);
        (taken == Ok(Progress::Whole)).then_some(Action::Model)
    }

    fn note(&mut self, action: Action) {
        match action {
            Action::Arm => {
                self.verdict = self.verdict.filter(|_| self.armed);
                self.armed = true;
            }
            Action::Disarm => (self.armed, self.running) = (false, false),
            Action::Start => (self.running, self.taps) = (true, usize::from(self.config.lms.taps)),
            Action::Hil(on) => (self.hil, self.clock) = (on, HilClock::default()),
            Action::Abort | Action::Tick(_) | Action::Reference(_) | Action::Model => {}
        }
    }

    fn parameter(&mut self, frame: &Frame<'_>, out: &mut impl FnMut(&[u8])) {
        let payload = frame.payload();
        match frame.id() {
            PARAM_REQUEST_LIST_DATA::ID => {
                (0..PARAMETERS.len()).for_each(|index| self.send_parameter(index, out));
            }
            PARAM_REQUEST_READ_DATA::ID => {
                let Ok(request) = PARAM_REQUEST_READ_DATA::deser(V2, payload) else { return };
                let named = request.param_id.to_str().ok().and_then(parameters::find).map(|(index, _)| index);
                let index = usize::try_from(request.param_index).ok().or(named);
                index.into_iter().for_each(|index| self.send_parameter(index, out));
            }
            PARAM_SET_DATA::ID => {
                let Ok(wish) = PARAM_SET_DATA::deser(V2, payload) else { return };
                self.set_parameter(wish.param_id.to_str().unwrap_or_default(), wish.param_value, out);
            }
            _ => {}
        }
    }

    fn set_parameter(&mut self, name: &str, value: f32, out: &mut impl FnMut(&[u8])) {
        let index = if self.running {
            self.say(MavSeverity::MAV_SEVERITY_WARNING, "parameter refused: a test runs", out);
            parameters::find(name).map(|(index, _)| index)
        } else {
            match parameters::set(&mut self.config, name, value) {
                Ok((index, test)) => {
                    self.test = test;
                    self.unsaved = Some(SECOND);
                    Some(index)
                }
                Err(Refusal::Unknown) => None,
                Err(Refusal::Range(error)) => {
                    let mut text = String::<120>::new();
                    // what does not fit is left off
                    let _ = write!(text, "refused: {error}");
                    self.say(MavSeverity::MAV_SEVERITY_WARNING, &text, out);
                    parameters::find(name).map(|(index, _)| index)
                }
            }
        };
        // the value as it stands is the answer, whether it was taken or not
        index.into_iter().for_each(|index| self.send_parameter(index, out));
    }

    fn send_parameter(&mut self, index: usize, out: &mut impl FnMut(&[u8])) {
        let Some(parameter) = PARAMETERS.get(index) else { return };
        let value = PARAM_VALUE_DATA {
            param_value: parameter.value(&self.config),
            param_count: PARAMETERS.len() as u16,
            param_index: index as u16,
            param_id: parameter.name.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        };
        self.send(&value, out);
    }

    /// Tells the ground what a cycle did; `taps` are fetched once a second, at the end of a test, and on request.
    #[inline(never)]
    pub fn report(
        &mut self,
        telemetry: &Telemetry,
        monitor: Option<&MonitorReport>,
        taps: impl FnOnce() -> [f32; MAX_TAPS],
        out: &mut impl FnMut(&[u8]),
    ) {
        self.phase = telemetry.phase;
        self.running = telemetry.phase.runs();
        self.unsaved = self.unsaved.map(|ticks| ticks.saturating_sub(1));
        if self.hil {
            self.send(&actuators(telemetry, self.mode()), out);
        }
        if let Some(event) = &telemetry.event {
            let mut text = String::<160>::new();
            let _ = write!(text, "{event}");
            self.say(severity(event), &text, out);
        }
        if let Some(report) = monitor {
            self.tell(&report.verdict, out);
            self.send(&monitor_value(report, telemetry), out);
        }
        let second = telemetry.tick.is_multiple_of(SECOND);
        if second {
            self.heartbeat(out);
        }
        if telemetry.tick.is_multiple_of(ATTITUDE_EVERY) {
            self.send(&attitude(telemetry), out);
        }
        let ended = matches!(telemetry.event, Some(Event::Finished { .. } | Event::Aborted(_)));
        if core::mem::take(&mut self.taps_wanted) || ended || (second && self.running) {
            let taps = taps();
            let used = taps.get(..self.taps).unwrap_or(&taps);
            taps_arrays(used, telemetry.now_us).for_each(|piece| self.send(&piece, out));
        }
        // last, so that in lockstep it tells that all of the tick has been said
        self.send(&cycle_array(telemetry), out);
    }

    /// Tells a verdict that is new.
    fn tell(&mut self, verdict: &Verdict, out: &mut impl FnMut(&[u8])) {
        if self.verdict.as_ref().is_some_and(|last| last.is_like(verdict)) {
            return;
        }
        self.verdict = Some(*verdict);
        let severity = match verdict {
            Verdict::Changed(_) | Verdict::OneOf(..) | Verdict::SomethingElse { .. } => {
                MavSeverity::MAV_SEVERITY_WARNING
            }
            Verdict::AsIdentified | Verdict::CannotTell(_) => MavSeverity::MAV_SEVERITY_INFO,
        };
        let mut text = String::<160>::new();
        let _ = write!(text, "monitor: {verdict}");
        self.say(severity, &text, out);
    }

    /// Sends the state of the vehicle.
    pub fn heartbeat(&mut self, out: &mut impl FnMut(&[u8])) {
        let system_status = match self.phase {
            Phase::Aborted { .. } => MavState::MAV_STATE_CRITICAL,
            _ if self.armed => MavState::MAV_STATE_ACTIVE,
            _ => MavState::MAV_STATE_STANDBY,
        };
        let heartbeat = HEARTBEAT_DATA {
            custom_mode: u32::from(phase_code(&self.phase)),
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
            base_mode: self.mode(),
            system_status,
            mavlink_version: 3,
        };
        self.send(&heartbeat, out);
    }

    fn mode(&self) -> MavModeFlag {
        let mut mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        mode.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, self.armed);
        mode.set(MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED, self.hil);
        mode
    }

    /// Sends a text.
    pub fn say(&mut self, severity: MavSeverity, text: &str, out: &mut impl FnMut(&[u8])) {
        self.text = self.text.wrapping_add(1);
        texts(severity, text, self.text).for_each(|message| self.send(&message, out));
    }

    // its own frame: inlined, the buffers of every message add up in that of the caller
    #[inline(never)]
    fn send<M: MessageData>(&mut self, message: &M, out: &mut impl FnMut(&[u8])) {
        let mut frame =
            encode(Header { sequence: self.sequence, system: SYSTEM, component: COMPONENT }, message);
        self.sequence = self.sequence.wrapping_add(1);
        if let Some(gate) = &mut self.gate {
            gate.timestamp = gate.timestamp.wrapping_add(1);
            sign(&mut frame, M::EXTRA_CRC, gate.key(), 0, gate.timestamp);
        }
        out(&frame);
    }
}

const fn severity(event: &Event) -> MavSeverity {
    match event {
        Event::Aborted(_) => MavSeverity::MAV_SEVERITY_ERROR,
        Event::Tripped(_) => MavSeverity::MAV_SEVERITY_WARNING,
        Event::Started | Event::Resumed { .. } | Event::Finished { .. } => MavSeverity::MAV_SEVERITY_INFO,
    }
}

fn ack(command: &COMMAND_LONG_DATA, result: MavResult) -> COMMAND_ACK_DATA {
    COMMAND_ACK_DATA { command: command.command, result, ..COMMAND_ACK_DATA::default() }
}
