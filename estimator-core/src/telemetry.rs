//! What a cycle reports, as plain data, beside what it is given.

use crate::cause::Event;
use crate::convergence::Convergence;
use crate::plan::Section;
use crate::supervisor::Phase;

pub use crate::input::{Command, Input, Sample};

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
