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
pub use filter::{BLOCKS, Column, Filter, Rows, STATES, Transition};
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

/// Everything that changes from cycle to cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorState {
    predictor: Predictor,
    blocks: [Block; CAUSES],
    evidence: [Evidence; CAUSES],
    motion: [f32; CAUSES],
    energy: f32,
    fast: f32,
    slow: f32,
    strength: f32,
    limit: f32,
    phase: u32,
    settled: u32,
    last: [f32; 2],
    repeats: u32,
    innovation: [f32; 2],
    judge: Judge,
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

impl MonitorConfig {
    /// Checks the configuration and the model.
    ///
    /// The threshold is h = ln(m A), A the run length in blocks and m the number of sums.
    ///
    /// # Errors
    /// The field out of its range.
    pub fn build(&self, model: &MonitorModel) -> Result<Monitor, ConfigError> {
        within("monitor.run_length", "h", self.run_length_h, [0.1, 1e4])?;
        let blocks = self.run_length_h * 3600.0 / BLOCK_S;
        let threshold = libm::logf(blocks * (CAUSES * SIZES) as f32);
        Ok(Monitor { model: *model, watched: self.watched, threshold })
    }
}

impl Monitor {
    /// The state before the first cycle. Assign it to reset.
    #[must_use]
    pub fn initial_state(&self) -> MonitorState {
        MonitorState {
            predictor: Predictor::default(),
            blocks: [Block::default(); CAUSES],
            evidence: [Evidence::default(); CAUSES],
            motion: [0.0; CAUSES],
            energy: 0.0,
            fast: 1.0,
            slow: 1.0,
            strength: 1.0,
            limit: LIMIT,
            phase: 0,
            settled: 0,
            last: [0.0; 2],
            repeats: 0,
            innovation: [0.0; 2],
            judge: Judge::default(),
        }
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
                let judge = core::mem::take(&mut state.judge);
                *state =
                    MonitorState { last: state.last, repeats: state.repeats, judge, ..self.initial_state() };
                state.judge.unable(why)
            }
        };
        let threshold = self.threshold;
        MonitorReport {
            verdict: state.judge.verdict(),
            changed,
            innovation: state.innovation,
            evidence: state.evidence.each_ref().map(|evidence| evidence.best().sum / threshold),
            background: libm::sqrtf(state.fast.max(state.slow)),
        }
    }

    /// Adds what the cycle shows to the blocks.
    fn observe(&self, state: &mut MonitorState, y: [f32; 2], u: f32) {
        let shown = state.predictor.step(&self.model, y, u, state.limit);
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
        let strength = state.strength;
        let causes = state.blocks.iter_mut().zip(&mut state.evidence).zip(&mut state.motion);
        if let Some((((block, evidence), motion), test)) = causes.zip(&self.model.tests).nth(phase as usize) {
            let Block { z, i } = core::mem::take(block);
            if settled && self.watched & (1 << phase) != 0 {
                *motion = KEPT * *motion + evidence.take(test, z, i, strength, KEPT, tick);
            }
            return false;
        }
        if phase + 1 < BLOCK {
            return false;
        }
        let energy = core::mem::take(&mut state.energy);
        if !settled {
            return state.judge.unable(Unable::Settling);
        }
        let [_, w_tq, w_tt] = self.model.whitening;
        let channels = if w_tq == 0.0 && w_tt == 0.0 { 1.0 } else { 2.0 };
        let mean = energy / (channels * BLOCK as f32);
        state.fast += FAST * (mean - state.fast);
        state.slow += SLOW * (mean - state.slow);
        let [least, largest] = STRENGTH;
        let strength = state.fast.max(state.slow).max(least).min(largest);
        state.strength = strength;
        state.limit = LIMIT * libm::sqrtf(strength);
        state.judge.step(&state.evidence, &state.motion, &self.model.tests, self.threshold)
    }
}

impl MonitorState {
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
