//! The control cycle: read, estimate the attitude, step the core, move the servos, report.

use estimator_core::constants::{MAX_TAPS, TICK_US};
use estimator_core::monitor::MonitorReport;
use estimator_core::{Command, Cycle, CycleState, Input, Sample, Telemetry};
use firmware::deadline::{Deadline, Verdict};
use firmware::hil::HilTick;
use firmware::pitch_filter::{Motion, PitchFilter};
use firmware::reset_record::Cause;
use firmware::watch::Watch;
use heapless::spsc::Producer;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::timer::Flag;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::{BoardImu, BoardServos, Timer, failsafe};

/// The test and how far it has got, and the monitor beside it.
pub struct Test {
    pub cycle: Cycle<MAX_TAPS>,
    pub state: CycleState<MAX_TAPS>,
    pub watch: &'static mut Watch,
}

/// What a cycle reports.
pub struct Report {
    pub telemetry: Telemetry,
    pub monitor: Option<MonitorReport>,
}

/// What the link leaves for the cycle.
#[derive(Default)]
pub struct Desk {
    pub armed: bool,
    pub hil: bool,
    pub command: Command,
    pub reference_rad: f32,
    /// The simulated cycle that is due.
    pub due: Option<HilTick>,
    /// Begin with a new attitude estimate.
    pub forget: bool,
}

/// What belongs to the cycle alone.
pub struct Control {
    timer: Timer,
    watchdog: IndependentWatchdog,
    imu: Option<BoardImu>,
    servos: BoardServos,
    filter: PitchFilter,
    tick: u32,
    now_us: u64,
    deadline: Deadline,
}

impl Control {
    pub fn new(
        timer: Timer,
        watchdog: IndependentWatchdog,
        imu: Option<BoardImu>,
        servos: BoardServos,
    ) -> Self {
        Self {
            timer,
            watchdog,
            imu,
            servos,
            filter: PitchFilter::default(),
            tick: 0,
            now_us: 0,
            deadline: Deadline::default(),
        }
    }

    /// True when a real IMU answered.
    pub const fn sensors(&self) -> bool {
        self.imu.is_some()
    }

    /// One interrupt.
    pub fn step(&mut self, test: &mut Test, desk: &mut Desk, reports: &mut Producer<'static, Report>) {
        self.timer.clear_flags(Flag::Update);
        #[cfg(feature = "provoked-faults")]
        self.provoke(desk.reference_rad);
        if core::mem::take(&mut desk.forget) {
            self.filter = PitchFilter::default();
        }
        if let Some(input) = self.input(desk) {
            let telemetry = test.cycle.step(&mut test.state, &input);
            let u_rad = if desk.armed && !desk.hil { telemetry.u_rad } else { 0.0 };
            // the timer's channels refuse nothing
            let _ = self.servos.set(u_rad);
            let monitor = if desk.armed { test.watch.step(&telemetry) } else { None };
            // a full queue costs the ground a report and the cycle nothing
            let _ = reports.enqueue(Report { telemetry, monitor });
        }
        self.meet_deadline(desk.hil);
    }

    /// The cycle that is due; none in the loop until the simulator asks for one.
    fn input(&mut self, desk: &mut Desk) -> Option<Input> {
        let (tick, now_us, time_us, motion) = if desk.hil {
            let HilTick { tick, now_us, sampled_us, motion } = desk.due.take()?;
            (tick, now_us, sampled_us, motion)
        } else {
            self.tick = self.tick.wrapping_add(1);
            self.now_us = self.now_us.wrapping_add(u64::from(TICK_US));
            let motion = self.imu.as_mut().and_then(|imu| imu.read().ok());
            (self.tick, self.now_us, self.now_us, motion)
        };
        let sample = motion.map(|motion: Motion| Sample {
            time_us,
            q_rad_s: motion.q_rad_s,
            theta_rad: self.filter.step(&motion),
        });
        let command = core::mem::take(&mut desk.command);
        Some(Input { tick, now_us, sample, theta_ref_rad: desk.reference_rad, command })
    }

    /// Stick full forward panics, full back takes until the timer has come round again.
    #[cfg(feature = "provoked-faults")]
    fn provoke(&self, reference_rad: f32) {
        assert!(reference_rad < 0.25, "provoked");
        while reference_rad < -0.25 && !self.timer.flags().contains(Flag::Update) {}
    }

    /// Feeds the watchdog if the timer has not come round again meanwhile. In the loop the simulator sets the pace.
    fn meet_deadline(&mut self, hil: bool) {
        match self.deadline.close(!hil && self.timer.flags().contains(Flag::Update)) {
            Verdict::Feed => self.watchdog.feed(),
            Verdict::Hold => {}
            Verdict::GiveUp { count } => failsafe::give_up(Cause::MissedDeadlines { count }),
        }
    }
}
