//! The link's loop: bytes in, answers and reports out. It runs below everything else.

use core::fmt::Write as _;
use estimator_core::constants::MAX_TAPS;
use estimator_core::{Command, Config};
use firmware::link::decoder::Decoder;
use firmware::link::ground::extra_crc;
use firmware::link::{Action, Ground};
use firmware::reset_record::Cause;
use firmware::settings::{Memory, Settings};
use firmware::store::NotKept;
use firmware::watch::Watch;
use heapless::String;
use heapless::spsc::{Consumer, Producer};
use messages::board::MavSeverity;
use stm32f4xx_hal::pac::Interrupt;

use super::control::{Desk, Report, Test};
use super::failsafe;
use super::flash::Sectors;

/// The ground's side of the board.
pub struct Link {
    ground: Ground,
    decoder: Decoder,
    incoming: Consumer<'static, u8>,
    outgoing: Outgoing,
    reported: Consumer<'static, Report>,
    cause: Option<Cause>,
    clock_hz: u32,
    memory: Memory<Sectors>,
    /// A model has come that the flash does not hold yet.
    model_unkept: bool,
}

/// Frames on their way to the USART.
struct Outgoing {
    queue: Producer<'static, u8>,
    lost: u32,
}

impl Outgoing {
    /// Whole frames only: one for which there is no room is dropped and counted.
    fn send(&mut self, frame: &[u8]) {
        if self.queue.capacity() - self.queue.len() < frame.len() {
            self.lost = self.lost.saturating_add(1);
            defmt::warn!("{} frames lost for want of room", self.lost);
            return;
        }
        for &byte in frame {
            let _ = self.queue.enqueue(byte);
        }
        rtic::pend(Interrupt::USART2);
    }
}

impl Link {
    pub fn new(
        incoming: Consumer<'static, u8>,
        queue: Producer<'static, u8>,
        reported: Consumer<'static, Report>,
        sensors: bool,
        cause: Option<Cause>,
        clock_hz: u32,
        memory: Memory<Sectors>,
    ) -> Self {
        let Ok(mut ground) = Ground::new(Config::default()) else {
            failsafe::give_up(Cause::Panic { line: line!() })
        };
        ground.sensors = sensors;
        let outgoing = Outgoing { queue, lost: 0 };
        Self {
            ground,
            decoder: Decoder::new(extra_crc),
            incoming,
            outgoing,
            reported,
            cause,
            clock_hz,
            memory,
            model_unkept: false,
        }
    }

    /// A test as it is configured now, not yet begun, and no monitor.
    pub fn test(&self, watch: &'static mut Watch) -> Test {
        let cycle = *self.ground.test();
        Test { cycle, state: cycle.initial_state(), watch }
    }

    /// Takes up what was kept.
    #[inline(never)]
    pub fn recall(&mut self) {
        let Self { ground, memory, .. } = self;
        if memory.settings().is_some_and(|settings| !ground.restore(&settings)) {
            defmt::warn!("the settings in flash are not legal; the defaults stand");
        }
        ground.upload().restore(|numbers| memory.recall_model(numbers));
    }

    /// Says that the board is up, on what clock, and why it was reset.
    #[inline(never)]
    pub fn greet(&mut self) {
        let Self { ground, outgoing, cause, clock_hz, .. } = self;
        let mut text = String::<80>::new();
        let _ = write!(text, "pitchid: up at {} MHz", *clock_hz / 1_000_000);
        defmt::info!("{}", text.as_str());
        ground.say(MavSeverity::MAV_SEVERITY_INFO, &text, &mut |frame| outgoing.send(frame));
        if let Some(cause) = cause {
            text.clear();
            let _ = write!(text, "{cause}");
            defmt::error!("{}", text.as_str());
            ground.say(MavSeverity::MAV_SEVERITY_CRITICAL, &text, &mut |frame| outgoing.send(frame));
        }
    }

    /// Takes bytes up to the next thing to do.
    pub fn listen(&mut self) -> Option<Action> {
        let Self { ground, decoder, incoming, outgoing, memory, .. } = self;
        let mut action = None;
        while let Some(byte) = incoming.dequeue() {
            decoder.push(byte, |frame| action = ground.receive(&frame, &mut |frame| outgoing.send(frame)));
            keep(ground.take_reserved(), ground, memory, outgoing);
            if action.is_some() {
                break;
            }
        }
        action
    }

    /// Does it, with the control cycle held off.
    #[inline(never)]
    pub fn act(&mut self, action: Action, test: &mut Test, desk: &mut Desk) {
        match action {
            Action::Arm => {
                if !desk.armed {
                    self.ground.begin(test.watch);
                }
                desk.armed = true;
            }
            Action::Disarm => (desk.armed, desk.command) = (false, Command::Abort),
            Action::Start => {
                test.cycle = *self.ground.test();
                test.state = test.cycle.initial_state();
                desk.command = Command::Start;
            }
            Action::Abort => desk.command = Command::Abort,
            Action::Hil(on) => (desk.hil, desk.due, desk.forget) = (on, None, true),
            Action::Tick(tick) => {
                desk.due = Some(tick);
                rtic::pend(Interrupt::TIM2);
            }
            Action::Reference(reference_rad) => desk.reference_rad = reference_rad,
            Action::Model => self.model_unkept = true,
        }
    }

    /// Sends what the cycles have reported.
    #[inline(never)]
    pub fn tell(&mut self, mut taps: impl FnMut() -> [f32; MAX_TAPS]) {
        let Self { ground, outgoing, reported, memory, model_unkept, .. } = self;
        while let Some(Report { telemetry, monitor }) = reported.dequeue() {
            if let Some(event) = telemetry.event {
                defmt::info!("{}", defmt::Display2Format(&event));
            }
            ground.report(&telemetry, monitor.as_ref(), &mut taps, &mut |frame| outgoing.send(frame));
        }
        keep(ground.take_unsaved(), ground, memory, outgoing);
        let mut said = |ground: &mut Ground, severity, text: &str| {
            ground.say(severity, text, &mut |frame| outgoing.send(frame));
        };
        if core::mem::take(model_unkept)
            && let Some(kept) = ground.upload().numbers().map(|numbers| memory.keep_model(numbers))
        {
            match kept {
                Ok(()) => said(ground, MavSeverity::MAV_SEVERITY_INFO, "monitor: model taken and kept"),
                Err(NotKept) => {
                    let why = "monitor: model taken, but not kept: flash full or failing";
                    said(ground, MavSeverity::MAV_SEVERITY_WARNING, why);
                }
            }
        }
    }

    /// True when nothing waits.
    pub fn quiet(&self) -> bool {
        self.incoming.is_empty() && self.reported.is_empty()
    }
}

/// Keeps the settings, if there are any to be kept; says so where that fails.
fn keep(
    settings: Option<Settings>,
    ground: &mut Ground,
    memory: &mut Memory<Sectors>,
    outgoing: &mut Outgoing,
) {
    if settings.is_some_and(|settings| memory.keep(&settings).is_err()) {
        let why = "settings not kept: flash full or failing, restart";
        ground.say(MavSeverity::MAV_SEVERITY_WARNING, why, &mut |frame| outgoing.send(frame));
    }
}
