//! The monitor: whether the craft still is what was identified, and if not, what changed.
//!
//! ```text
//! u, q, θ ──> predictor ──> e ──┬──> κ, the background's strength
//!               │               │
//!               └─> ψ of every cause ──> z = ψᵀe/κ, i = ψᵀψ/κ ──> cumulative sums ──> verdict
//! ```
//!
//! Every cycle the innovations e of the identified model and, for every cause, the trace ψ that a unit of it would leave in them.
//! Every ten cycles the sums of each cause move by one block ([`Evidence`]), in a turn that gives each cycle one cause, so that no
//! cycle is dear. The monitor only looks: it is given what was sent and sends nothing.
//!
//! Innovations are limited to four deviations; κ is the larger of their variance over half a second and over 20 s, so that a gust
//! raises it before it adds up to evidence.
//!
//! After Willsky and Jones (1976) and Basseville and Nikiforov (1993).

mod evidence;
mod filter;
mod model;
mod predictor;
mod verdict;

pub use evidence::{Evidence, Finding};
pub use filter::{BLOCKS, Bank, Column, Drive, Rows, STATES, Transition};
pub use model::{CAUSES, Cause, MonitorModel, NUMBERS, Refusal, SIZES, Test};
pub use predictor::{Predictor, Shown};
pub use verdict::{Change, Unable, Verdict};

use crate::config_error::{ConfigError, within};
use crate::constants::{SAMPLE_PERIOD_S, TICKS_PER_S};
use verdict::Judge;

/// Cycles of a block.
pub const BLOCK: u32 = 10;
/// Time constant with which old evidence fades, s.
const MEMORY_S: f32 = 30.0;
const BLOCK_S: f32 = BLOCK as f32 * SAMPLE_PERIOD_S;
/// What a block leaves of the evidence before it.
const KEPT: f32 = 1.0 - BLOCK_S / MEMORY_S;
/// Share of a block in the fast and in the slow strength of the background.
const FAST: f32 = BLOCK_S / 0.6;
const SLOW: f32 = BLOCK_S / 20.0;
/// Innovations count up to so many deviations.
const LIMIT: f32 = 4.0;
/// Least and largest κ.
const STRENGTH: [f32; 2] = [0.5, 1e6];
/// Cycles that the predictor is given to settle.
const SETTLING: u32 = 3 * TICKS_PER_S as u32;
/// Identical samples in a row that are a frozen sensor.
const FROZEN: u32 = 25;
/// Readings and commands beyond are no measurement, rad/s, rad, rad.
const BEYOND: f32 = 100.0;

/// What is watched for, and how seldom a false alarm may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorConfig {
    /// Mean time between false alarms, h, 0.1 to 10⁴: a bound from below.
    pub run_length_h: f32,
    /// The causes watched for, a bit for each of [`Cause::ALL`].
    pub watched: u8,
}

impl Default for MonitorConfig {
    fn default() -> Self {
        Self { run_length_h: 10.0, watched: u8::MAX }
    }
}

/// A monitor, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitor {
    model: MonitorModel,
    watched: u8,
    threshold: f32,
}

/// What a cycle gives the monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Number of the cycle.
    pub tick: u32,
    /// Measured q in rad/s and θ in rad; none where there is no usable sample.
    pub measured: Option<[f32; 2]>,
    /// Command sent in this cycle, rad.
    pub u_rad: f32,
}

/// Everything that changes from cycle to cycle. Its default is the state before the first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MonitorState {
    predictor: Predictor,
    blocks: [Block; CAUSES],
    evidence: [Evidence; CAUSES],
    motion: [f32; CAUSES],
    energy: f32,
    background: Background,
    phase: u32,
    settled: u32,
    last: [f32; 2],
    repeats: u32,
    innovation: [f32; 2],
    judge: Judge,
}

/// How strong the air is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Background {
    /// Mean square of the innovations over half a second and over 20 s.
    fast: f32,
    slow: f32,
    /// κ: the larger of them.
    strength: f32,
    /// √ of that.
    deviation: f32,
}

impl Default for Background {
    fn default() -> Self {
        Self { fast: 1.0, slow: 1.0, strength: 1.0, deviation: 1.0 }
    }
}

impl Background {
    fn take(&mut self, mean: f32) {
        self.fast += FAST * (mean - self.fast);
        self.slow += SLOW * (mean - self.slow);
        let [least, largest] = STRENGTH;
        self.strength = smaller(larger(larger(self.fast, self.slow), least), largest);
        self.deviation = libm::sqrtf(self.strength);
    }
}

/// Score and information of a block on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Block {
    z: f32,
    i: f32,
}

/// What the monitor says of a cycle. Numbers are finite throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorReport {
    /// The verdict as it stands.
    pub verdict: Verdict,
    /// Whether it changed in this cycle.
    pub changed: bool,
    /// Innovations of q and of θ in their identified deviations.
    pub innovation: [f32; 2],
    /// Largest sum of each cause over the threshold: 1 is an alarm.
    pub evidence: [f32; CAUSES],
    /// Deviation of the background over that of the identification.
    pub background: f32,
}

/// The larger of two numbers: `f32::max` is a call on the chip.
const fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers.
const fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl MonitorConfig {
    /// Whether every field lies in its range.
    ///
    /// # Errors
    /// The field out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        within("monitor.run_length", "h", self.run_length_h, [0.1, 1e4])
    }

    /// The monitor of a model that has been checked.
    ///
    /// The threshold is h = ln(m A), A the run length in blocks and m the number of sums.
    ///
    /// # Errors
    /// The field out of its range.
    pub fn build(&self, model: &MonitorModel) -> Result<Monitor, ConfigError> {
        self.check()?;
        let blocks = self.run_length_h * 3600.0 / BLOCK_S;
        let threshold = libm::logf(blocks * (CAUSES * SIZES) as f32);
        Ok(Monitor { model: *model, watched: self.watched, threshold })
    }
}

impl Monitor {
    /// The state before the first cycle.
    #[must_use]
    pub fn initial_state(&self) -> MonitorState {
        MonitorState::default()
    }

    /// h: the sum at which a cause is told.
    #[must_use]
    pub const fn threshold(&self) -> f32 {
        self.threshold
    }

    /// One cycle.
    pub fn step(&self, state: &mut MonitorState, observation: &Observation) -> MonitorReport {
        let Observation { tick, measured, u_rad } = *observation;
        let changed = match state.usable(measured, u_rad) {
            Ok(y) => {
                self.observe(state, y, u_rad);
                self.turn(state, tick)
            }
            Err(why) => {
                state.forget();
                state.judge.unable(why)
            }
        };
        let threshold = self.threshold;
        MonitorReport {
            verdict: state.judge.verdict(),
            changed,
            innovation: state.innovation,
            evidence: state.evidence.each_ref().map(|evidence| evidence.best().sum / threshold),
            background: state.background.deviation,
        }
    }

    /// Adds what the cycle shows to the blocks.
    fn observe(&self, state: &mut MonitorState, y: [f32; 2], u: f32) {
        let shown = state.predictor.step(&self.model, y, u, LIMIT * state.background.deviation);
        state.innovation = shown.innovation;
        let [e_q, e_t] = shown.limited;
        state.energy += e_q * e_q + e_t * e_t;
        for (block, [p_q, p_t]) in state.blocks.iter_mut().zip(shown.traces) {
            block.z += p_q * e_q + p_t * e_t;
            block.i += p_q * p_q + p_t * p_t;
        }
    }

    /// The work of this cycle's turn; true where the verdict changed.
    fn turn(&self, state: &mut MonitorState, tick: u32) -> bool {
        let phase = state.phase;
        state.phase = if phase + 1 >= BLOCK { 0 } else { phase + 1 };
        state.settled = state.settled.saturating_add(1);
        let settled = state.settled > SETTLING;
        let strength = state.background.strength;
        let causes = state.blocks.iter_mut().zip(&mut state.evidence).zip(&mut state.motion);
        if let Some((((block, evidence), motion), test)) = causes.zip(&self.model.tests).nth(phase as usize) {
            let Block { z, i } = core::mem::take(block);
            if settled && self.watched & (1 << phase) != 0 {
                *motion = KEPT * *motion + evidence.take(test, z, i, strength, KEPT, tick);
            }
            return false;
        }
        if phase + 1 < BLOCK {
            if phase as usize == CAUSES {
                let [_, w_tq, w_tt] = self.model.whitening;
                let channels = if w_tq == 0.0 && w_tt == 0.0 { 1.0 } else { 2.0 };
                let mean = core::mem::take(&mut state.energy) / (channels * BLOCK as f32);
                if settled {
                    state.background.take(mean);
                }
            }
            return false;
        }
        if !settled {
            return state.judge.unable(Unable::Settling);
        }
        state.judge.step(&state.evidence, &state.motion, &self.model, self.threshold)
    }
}

impl MonitorState {
    /// Back to the state before the first cycle.
    pub fn reset(&mut self) {
        self.forget();
        (self.last, self.repeats, self.judge) = ([0.0; 2], 0, Judge::default());
    }

    /// Back to the beginning, but for the verdict and the sensors. Part by part: a whole state on the way would stand on the stack.
    fn forget(&mut self) {
        self.predictor = Predictor::default();
        self.blocks = [Block::default(); CAUSES];
        self.evidence.iter_mut().for_each(|evidence| *evidence = Evidence::default());
        self.motion = [0.0; CAUSES];
        self.background = Background::default();
        (self.energy, self.phase, self.settled, self.innovation) = (0.0, 0, 0, [0.0; 2]);
    }

    /// The sample, if it can be used.
    fn usable(&mut self, measured: Option<[f32; 2]>, u: f32) -> Result<[f32; 2], Unable> {
        let y = measured.ok_or(Unable::NoSample)?;
        // written so that NaN fails
        if !(y.iter().all(|value| value.abs() <= BEYOND) && u.abs() <= BEYOND) {
            return Err(Unable::NotFinite);
        }
        let same = y.map(f32::to_bits) == self.last.map(f32::to_bits);
        self.repeats = if same { self.repeats.saturating_add(1) } else { 0 };
        self.last = y;
        if self.repeats >= FROZEN { Err(Unable::Frozen) } else { Ok(y) }
    }
}
