//! The estimator that flies, run over a recording: the core's normalised LMS in f32, and its own convergence verdict.
//!
//! Equation and symbols: [`estimator_core::lms`]. Each run is fed whole and in order of time up to the end of its last
//! chosen section, so the regressor always holds the inputs truly applied; the taps move only on rows of chosen
//! sections, where the supervisor left the excitation alone and where the window of N + d inputs is known. A new run
//! empties the regressor and keeps the taps. Where a recording begins N + d samples or more before its first section,
//! the taps are those that the autopilot had.

use crate::error::{Error, ErrorKind};
use crate::identify::fir::{Fir, Piece, common_step};
use estimator_core::constants::MAX_INPUT_DELAY;
use estimator_core::convergence::{Convergence, ConvergenceConfig, ConvergenceMeter, ConvergenceState};
use estimator_core::lms::{LmsConfig, LmsState, NormalizedLms};

/// What the replay found.
#[derive(Clone, Debug, PartialEq)]
pub struct LmsFit {
    /// The taps at the end, the first at lag 1 + d.
    pub fir: Fir,
    /// The core's verdict and the figures behind it.
    pub convergence: Convergence,
    /// Rows on which the taps moved.
    pub updates: usize,
    /// Rows of the chosen sections left out, because the supervisor acted or the window was not filled.
    pub left_out: usize,
}

/// What the autopilot's own estimator came to in flight, and how it was set.
#[derive(Clone, Debug, PartialEq)]
pub struct OnBoard {
    /// The taps, the first at lag 1 + d.
    pub fir: Fir,
    /// Its own verdict.
    pub verdict: String,
    /// Its settings.
    pub lms: LmsConfig,
}

/// Replays `pieces` through the core's estimator of `lms.taps` taps, at most N. Pieces of one run may come in any order, the runs are taken
/// in the order in which they first appear.
///
/// Where the input is not in rad, `lms.regularisation_rad2` and `convergence.min_input_rms_rad` are in its unit.
///
/// # Errors
/// A configuration out of its legal range, no section, sample periods that differ, signals too large for f32.
pub fn replay<const N: usize>(
    pieces: &[Piece],
    lms: &LmsConfig,
    convergence: &ConvergenceConfig,
) -> Result<LmsFit, Error> {
    let step = common_step(pieces)?;
    let refuse = |error: estimator_core::ConfigError| {
        Error::new(ErrorKind::Options, error.to_string(), "correct the estimator's configuration")
    };
    let lms = LmsConfig { taps: lms.taps.min(N as u16), ..*lms };
    let count = usize::from(lms.taps);
    let window = count + usize::from(lms.input_delay);
    let mut replay = Replay {
        lms: lms.build::<N>().map_err(refuse)?,
        meter: convergence.build().map_err(refuse)?,
        state: LmsState::default(),
        figures: ConvergenceState::default(),
        updates: 0,
        left_out: 0,
    };
    let beyond = |values: &[f64]| values.iter().any(|&value| (value as f32).is_infinite());
    if pieces.iter().any(|piece| beyond(piece.u) || beyond(piece.y)) {
        let found = "a value of the input or the pitch rate is beyond the range of single precision";
        let advice = "convert the input and the pitch rate to units in which they are near 1";
        return Err(Error::new(ErrorKind::Numerical, found, advice));
    }
    let mut done: Vec<usize> = Vec::new();
    for first in pieces {
        if done.contains(&first.run) {
            continue;
        }
        done.push(first.run);
        let own: Vec<&Piece> = pieces.iter().filter(|piece| piece.run == first.run).collect();
        replay.feed(&own, window);
    }
    let Replay { state, meter, figures, updates, left_out, .. } = replay;
    let taps = state.taps().iter().take(count).map(|&w| f64::from(w)).collect();
    let fir = Fir { taps, first_lag: 1 + usize::from(lms.input_delay), step };
    Ok(LmsFit { fir, convergence: meter.figures(&figures), updates, left_out })
}

struct Replay<const N: usize> {
    lms: NormalizedLms<N>,
    meter: ConvergenceMeter,
    state: LmsState<N>,
    figures: ConvergenceState,
    updates: usize,
    left_out: usize,
}

impl<const N: usize> Replay<N> {
    /// One run: all of `pieces` belong to it.
    fn feed(&mut self, pieces: &[&Piece], window: usize) {
        for _ in 0..N + usize::from(MAX_INPUT_DELAY) {
            self.lms.push(&mut self.state, 0.0);
        }
        let Some(&&Piece { u, y, supervised, .. }) = pieces.first() else { return };
        let end = pieces.iter().map(|piece| piece.rows.end).max().unwrap_or(0);
        for (k, ((&u, &q), &supervised)) in u.iter().zip(y).zip(supervised).enumerate().take(end) {
            let chosen = pieces.iter().any(|piece| piece.rows.contains(&k));
            let adapt = chosen && !supervised && k >= window;
            if adapt {
                self.learn(q as f32);
            }
            self.updates += usize::from(adapt);
            self.left_out += usize::from(chosen && !adapt);
            self.lms.push(&mut self.state, u as f32);
        }
    }

    fn learn(&mut self, q: f32) {
        let line = [self.state.line().energy(), self.state.line().sum()];
        let update = self.lms.observe(&mut self.state, q, true);
        self.meter.step(&mut self.figures, &self.lms, update, q, line);
    }
}
