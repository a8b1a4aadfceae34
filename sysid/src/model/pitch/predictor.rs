//! The model as a predictor: its gains, its innovations, and how what it lacks shows in them.

use super::{Drive, Gains, Output, PitchModel, Point};
use crate::dataset::Run;
use crate::model::innovation_filter::InnovationFilter;
use crate::model::kalman::{Channel, steady_gain};
use crate::model::noise::{Disturbance, Third};
use crate::model::plant::{DISTURBANCE, GUST, Plant, Q, STATES, State, StateMatrix, THETA, THETA_IMU};

/// Leak of an angle that nothing observes, 1/s.
const LEAK: f64 = 0.1;

impl PitchModel<'_> {
    /// Kalman gains for the outputs that `run` has, under the noise model `disturbance`.
    pub fn gain(&self, disturbance: &Disturbance, run: &Run) -> Option<Gains> {
        let begin = self.steady(disturbance, run)?;
        if !self.inertia_changes {
            return Some(Gains { begin, changed: None, corrects: by_news(disturbance) });
        }
        let factor = self.inertia_at(f64::MAX);
        let plant = Plant { inertia: factor * self.plant.inertia, ..self.plant };
        let later = PitchModel::new(&plant, &[], disturbance, self.step, &self.sizes)?;
        let changed = Some(later.steady(disturbance, run)?);
        Some(Gains { begin, changed, corrects: by_news(disturbance) })
    }

    /// How a moment or an addition to a measurement that the model lacks shows in the innovations of the predictor with
    /// `gains` over `run`; the terms by their linear part.
    pub fn innovation_filter(&self, gains: &Gains, run: &Run) -> InnovationFilter {
        let (rate, angle) = self.measured;
        let channels = [(run.rate.is_some(), rate), (run.angle.is_some(), angle)];
        let measured: Vec<usize> = channels.iter().filter(|c| c.0).map(|c| c.1).collect();
        let per_addition: Vec<State> = gains.begin.iter().map(|k| self.linearised * k).collect();
        let mut transition = self.linearised;
        for (&state, addition) in measured.iter().zip(&per_addition) {
            let less = transition.column(state) - addition;
            transition.set_column(state, &less);
        }
        InnovationFilter {
            transition,
            uncorrected: self.linearised,
            per_moment: self.per_moment_of_substep.iter().sum(),
            per_addition,
            measured,
            delay: self.delay,
        }
    }

    fn steady(&self, disturbance: &Disturbance, run: &Run) -> Option<Vec<State>> {
        let mut over_sample = self.linearised;
        let mut process = StateMatrix::zeros();
        let mut driven = |state: usize, intensity: f64| {
            let mut drive = State::zeros();
            drive[state] = intensity * (self.step / 2.0).sqrt();
            let later = self.linearised * drive;
            process += drive * drive.transpose() + later * later.transpose();
        };
        driven(DISTURBANCE + 1, disturbance.intensity);
        if let Some(Third::Gust(gust)) = disturbance.third {
            driven(GUST, gust.sigma * (2.0 / gust.time_constant).sqrt());
        }
        if let Some(known) = by_news(disturbance).filter(|_| run.command_news.is_some()) {
            let later = self.linearised * known;
            process -= later * later.transpose();
        }
        let (rate, angle) = self.measured;
        let mut channels = Vec::with_capacity(2);
        if run.rate.is_some() {
            channels.push(Channel { state: rate, variance: 1.0 });
        }
        if run.angle.is_some() {
            let noise = if run.rate.is_some() { disturbance.angle_noise } else { 1.0 };
            channels.push(Channel { state: angle, variance: noise * noise });
        } else {
            // The angle is a pure integrator that nothing observes: a slow leak keeps its variance finite.
            for i in [THETA, THETA_IMU] {
                for j in 0..STATES {
                    over_sample[(i, j)] *= 1.0 - LEAK * self.step;
                }
            }
        }
        // one reading in several rows is taken for one in so many rows each
        let (mut between, mut gathered) = (over_sample, process);
        for _ in 1..run.measured_every() {
            gathered = over_sample * gathered * over_sample.transpose() + process;
            between = over_sample * between;
        }
        steady_gain(&between, &gathered, &channels)
    }

    /// Innovations e = y − ŷ of the predictor with `gains` over the first `rows` of `run`; channels and rows without a measurement
    /// give zero. `visit` sees the corrected state of every row.
    pub fn innovations(
        &self,
        run: &Run,
        gains: &Gains,
        rows: usize,
        mut visit: impl FnMut(usize, &Point),
    ) -> Option<Vec<Output>> {
        let driven = self.driven(run);
        let next = |point: &mut Point, k: usize| {
            visit(k, point);
            driven.advance(point, k)
        };
        self.predicted(run, gains, rows, next)
    }

    /// The same over as many rows as there are `drives` for.
    pub fn innovations_under(&self, run: &Run, gains: &Gains, drives: &[Drive]) -> Option<Vec<Output>> {
        let mut at = self.conditions;
        let next = |point: &mut Point, k: usize| {
            self.moved(point, run, k, &mut at, &drives[k * self.substeps..][..self.substeps])
        };
        self.predicted(run, gains, drives.len() / self.substeps, next)
    }

    /// Innovations of `rows` rows; `next` takes the corrected state of row k to row k+1, `false` where it diverges.
    fn predicted(
        &self,
        run: &Run,
        gains: &Gains,
        rows: usize,
        mut next: impl FnMut(&mut Point, usize) -> bool,
    ) -> Option<Vec<Output>> {
        let mut point = self.start(run);
        let mut innovations = Vec::with_capacity(rows);
        let mut censored = Vec::new();
        for k in 0..rows {
            let sensed = self.sensed(&point);
            let expected = self.limited(sensed);
            let gain = match &gains.changed {
                Some(later) if self.inertia_at(run.elapsed(k)) != 1.0 => later,
                _ => &gains.begin,
            };
            let mut e = [0.0; 2];
            let mut column = 0;
            for (channel, signal) in [&run.rate, &run.angle].into_iter().enumerate() {
                if let Some(signal) = signal.as_ref().filter(|_| run.is_measured(k)) {
                    e[channel] = signal[k] - expected[channel];
                    point.x += gain[column] * e[channel];
                    column += 1;
                }
            }
            if let Some((news, corrects)) = run.command_news.as_ref().zip(gains.corrects) {
                point.x += corrects * news[k];
            }
            let at_limit = run.rate.as_ref().is_some_and(|rate| rate[k].abs() >= run.rate_limit);
            if at_limit && sensed[0] != expected[0] {
                censored.push(k);
            }
            innovations.push(e);
            if !next(&mut point, k) {
                return None;
            }
        }
        impute(&mut innovations, &censored);
        Some(innovations)
    }
}

/// Adds to the rate's innovation of each of the `censored` rows that of another row, drawn by its number, with a sign drawn
/// alike: a reading at the limit says where the limit is and that the rate is at least that, and neither that the model is right
/// nor how strong the noise is (hot-deck imputation: Andridge and Little, Int. Stat. Rev. 78, 2010).
fn impute(innovations: &mut [Output], censored: &[usize]) {
    if censored.is_empty() {
        return;
    }
    let mut is_censored = vec![false; innovations.len()];
    censored.iter().for_each(|&k| is_censored[k] = true);
    let donors: Vec<usize> = (0..innovations.len()).filter(|&k| !is_censored[k]).collect();
    if donors.is_empty() {
        return;
    }
    for &k in censored {
        // Knuth's multiplicative hash
        let drawn = (k as u32).wrapping_add(1).wrapping_mul(2_654_435_769);
        let sign = if drawn & 0x8000 == 0 { 1.0 } else { -1.0 };
        innovations[k][0] += sign * innovations[donors[(drawn >> 16) as usize % donors.len()]][0];
    }
}

/// By how much the state is corrected by what is new in the command.
fn by_news(disturbance: &Disturbance) -> Option<State> {
    let [rate, first, second] = disturbance.corrects?;
    let mut state = State::zeros();
    (state[Q], state[DISTURBANCE], state[DISTURBANCE + 1]) = (rate, first, second);
    Some(state)
}
