//! What goes into a cycle and what it reports, as plain data.

use crate::cause::Event;
use crate::convergence::Convergence;
use crate::plan::Section;
use crate::supervisor::Phase;

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When it was taken, µs on the caller's clock.
    pub time_us: u64,
    /// Pitch rate q, rad/s.
    pub q_rad_s: f32,
    /// Pitch angle θ, rad.
    pub theta_rad: f32,
}

/// What the operator wants.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Command {
    /// Nothing new.
    #[default]
    None,
    /// Begin the test; obeyed when no test has been begun yet.
    Start,
    /// Break the test off.
    Abort,
}

/// All that a cycle is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Number of the cycle; one more than the last, unless deadlines were missed.
    pub tick: u32,
    /// The caller's clock, µs.
    pub now_us: u64,
    /// The newest measurement, none if there is none.
    pub sample: Option<Sample>,
    /// Manual attitude reference of section IV, rad.
    pub theta_ref_rad: f32,
    /// The operator's command.
    pub command: Command,
}

/// All that a cycle reports. Numbers are finite throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Telemetry {
    /// Number of the cycle.
    pub tick: u32,
    /// The caller's clock, µs.
    pub now_us: u64,
    /// The measurement acted on; none if it was missing, late or not finite.
    pub sample: Option<Sample>,
    /// Command u to the servo, held until the next cycle, rad.
    pub u_rad: f32,
    /// Share of the excitation in it, rad; 0 where the controller or nobody moves the servo.
    pub excitation_rad: f32,
    /// Reference that the controller follows, rad; 0 where it is level or off.
    pub theta_ref_rad: f32,
    /// Part of the test.
    pub section: Section,
    /// True where the supervisor overrode the test.
    pub supervised: bool,
    /// Where the supervisor stands.
    pub phase: Phase,
    /// Its transition in this cycle.
    pub event: Option<Event>,
    /// Recoveries so far.
    pub recoveries: u32,
    /// q − q̂, rad/s; 0 without a measurement.
    pub prediction_error_rad_s: f32,
    /// How far the estimate has got.
    pub convergence: Convergence,
}
