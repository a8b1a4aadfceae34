//! What a cycle is given, as plain data.

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
