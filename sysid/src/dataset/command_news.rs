//! What is new in the command of a closed loop: a further reading of the motion.
//!
//! A controller answers to readings of its own. Where those are not in the log (taken more often, before a filter, by another
//! sensor), what it commands tells of the motion what the log does not; a predictor that takes the command for a mere cause then
//! finds that small commands do not act, for they are the answer to what acts against them. What is new in the command,
//!
//! ```text
//! n(k) = u(k) − Σ_{i=1..p} a_i u(k−i) − Σ_{i=0..p} bᵢᵀ y(k−i) − c_s,      least squares,
//! ```
//!
//! corrects the state as an innovation does, x̂ += g n, and leaves it the less uncertain, P − g gᵀ for n of unit variance. Steps of the
//! set-point are no reading: each begins a stretch s with a level of its own, and the rows that remember it are left out. (What is
//! not white of n, as where a level has to be learnt again after each step, is known already, and bends the plant.)
//!
//! Sources: Forssell, Ljung, Automatica 35, 1999, section 4 (joint input–output identification).

use super::{Dataset, Run, median_size};
use crate::linalg::least_squares::least_squares;
use nalgebra::DVector;

/// Memory of the command and of the motion, rows at most, and the rows that each unknown needs.
const MOST_ROWS: usize = 20;
const ROWS_EACH: usize = 20;
/// Standard deviations (by the median) beyond which something else moves the command, regression by regression.
const ELSEWHERE: [f64; 5] = [12.0, 9.0, 6.0, 4.0, 4.0];
/// Least share of the rows in which nothing else moves it.
const LEAST_KEPT: f64 = 0.4;

impl Dataset {
    /// Whether what is new in the command is there.
    pub fn has_command_news(&self) -> bool {
        self.runs.iter().any(|run| run.command_news.is_some())
    }

    /// The same with what is new in the command, in standard deviations times `noise`, that of the first sensor: in its units the
    /// noise model has all variances. `None` where too little is there to tell.
    pub(crate) fn with_command_news(&self, noise: f64) -> Option<Self> {
        let channels = usize::from(self.has_rate) + usize::from(self.has_angle);
        let memory = MOST_ROWS.min(self.samples() / (ROWS_EACH * (1 + channels)));
        if memory == 0 || self.runs.iter().any(|run| run.measured_every() > 1) {
            return None;
        }
        let mut rows = Rows::new(self, memory);
        let mut new = Vec::new();
        let mut size = 0.0;
        for limit in ELSEWHERE {
            (new, size) = rows.regression(memory + channels * (memory + 1))?;
            rows.leave_out(&new, limit * size);
        }
        let kept = rows.kept.iter().filter(|kept| **kept).count();
        if size == 0.0 || (kept as f64) < LEAST_KEPT * self.samples() as f64 {
            return None;
        }
        let mut data = self.clone();
        for run in &mut data.runs {
            run.command_news = Some(vec![0.0; run.len()]);
        }
        for (n, &(run, k)) in rows.places.iter().enumerate().filter(|(n, _)| rows.kept[*n]) {
            if let Some(news) = &mut data.runs[run].command_news {
                news[k] = noise * new[n] / size;
            }
        }
        Some(data)
    }
}

/// The rows of a regression.
struct Rows<'d> {
    data: &'d Dataset,
    memory: usize,
    /// Run and row of each.
    places: Vec<(usize, usize)>,
    /// Which begin a stretch.
    begins: Vec<bool>,
    kept: Vec<bool>,
}

impl<'d> Rows<'d> {
    fn new(data: &'d Dataset, memory: usize) -> Self {
        let of_run = |(index, run): (usize, &Run)| (memory..run.len()).map(move |k| (index, k));
        let places: Vec<(usize, usize)> = data.runs.iter().enumerate().flat_map(of_run).collect();
        let begins = places.iter().map(|(_, k)| *k == memory).collect();
        let usable = |&(run, k): &(usize, usize)| {
            let run: &Run = &data.runs[run];
            !run.supervised[k - memory..=k].contains(&true) && run.is_measured(k)
        };
        let kept = places.iter().map(usable).collect();
        Self { data, memory, places, begins, kept }
    }

    /// What is known of the command without it, the `memory` commands before and the motion up to its row; and the command.
    fn row(&self, n: usize) -> DVector<f64> {
        let (run, k) = self.places[n];
        let run = &self.data.runs[run];
        let before = k - self.memory;
        let motion = [&run.rate, &run.angle].into_iter().flatten().flat_map(|y| &y[before..=k]);
        let all: Vec<f64> = run.u[before..k].iter().chain(motion).chain([&run.u[k]]).copied().collect();
        DVector::from_vec(all)
    }

    /// What a regression with `unknowns` and a level of each stretch leaves of the command, and its standard deviation by the median
    /// over the rows that are kept.
    fn regression(&mut self, unknowns: usize) -> Option<(Vec<f64>, f64)> {
        let starts: Vec<usize> = (0..self.places.len()).filter(|&n| self.begins[n]).collect();
        let ends = starts.iter().skip(1).copied().chain([self.places.len()]);
        let mut means = Vec::with_capacity(starts.len());
        let mut stretch_of = vec![0; self.places.len()];
        for (stretch, (&start, end)) in starts.iter().zip(ends).enumerate() {
            let (mut sum, mut count) = (DVector::zeros(unknowns + 1), 0);
            for n in (start..end).filter(|&n| self.kept[n]) {
                sum += self.row(n);
                count += 1;
            }
            if count < self.memory {
                self.kept[start..end].fill(false);
            }
            means.push(sum / f64::from(count.max(1) as u32));
            stretch_of[start..end].fill(stretch);
        }
        let apart = |n: usize| {
            let row = self.row(n) - &means[stretch_of[n]];
            (row.rows(0, unknowns).into_owned(), row[unknowns])
        };
        let weights = least_squares(unknowns, (0..self.places.len()).filter(|&n| self.kept[n]).map(apart))?;
        let new: Vec<f64> = (0..self.places.len())
            .map(|n| {
                let (known, command) = apart(n);
                command - weights.dot(&known)
            })
            .collect();
        let size = median_size(&new, &self.kept);
        Some((new, size))
    }

    /// Begins a stretch at each row that is kept and beyond `limit`, and leaves out those that remember it.
    fn leave_out(&mut self, new: &[f64], limit: f64) {
        let beyond: Vec<usize> = (0..new.len()).filter(|&n| self.kept[n] && new[n].abs() > limit).collect();
        for n in beyond {
            self.begins[n] = true;
            let remember = (n..(n + self.memory + 1).min(new.len()))
                .take_while(|&m| self.places[m].0 == self.places[n].0);
            remember.for_each(|m| self.kept[m] = false);
        }
    }
}
