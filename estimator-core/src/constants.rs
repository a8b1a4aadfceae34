//! Constants of the core, each with its source.
//!
//! "Paper" is Riccardi, Panizza, Lovera, *Identification of the attitude dynamics for a variable-pitch
//! quadrotor UAV*, ERF 2014.

/// Sample period Ts of the control cycle, s (paper: 50 Hz).
pub const SAMPLE_PERIOD_S: f32 = 0.02;

/// The same period in microseconds, the unit in which the excitation keeps its time.
pub const TICK_US: u32 = 20_000;

/// Ticks in one second.
pub const TICKS_PER_S: f32 = 50.0;

/// Duration in whole ticks, rounded to the nearest.
pub(crate) fn ticks(seconds: f32) -> u32 {
    libm::roundf(seconds * TICKS_PER_S) as u32
}

/// FIR length unless another is asked for: 60 taps are 1.2 s, about two time constants Iyy / |∂M/∂q| = 0.63 s of the airframe.
pub const TAPS: usize = 60;

/// Most taps that the flight image can be told to use: 2.56 s, four time constants. More would not fit its 16 KiB of RAM.
pub const MAX_TAPS: usize = 128;

/// Dwell ranges [min, max] of the paper's campaigns 1 to 4, s.
pub const CAMPAIGN_DWELL_S: [[f32; 2]; 4] = [[0.05, 0.1], [0.1, 0.2], [0.2, 0.4], [0.4, 0.8]];

/// Excitation amplitudes of the paper, rad.
pub const AMPLITUDES_RAD: [f32; 3] = [0.012, 0.015, 0.019];

/// Longest input delay that the regressor can carry, in samples (0.3 s; the paper finds 0.05 to 0.1 s).
pub const MAX_INPUT_DELAY: u8 = 15;
