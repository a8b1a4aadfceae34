//! Logs that are much faster than the motion, averaged to fewer rows.

use super::{Beside, Dataset, Run, decorrelation};
use crate::moving_mean::MovingMean;
use core::ops::Range;

/// Longest sample period after thinning, s.
const THINNED_STEP: f64 = 0.02;
/// Samples kept within the time over which the rate's autocorrelation falls to 0.8.
const SAMPLES_PER_DECORRELATION: usize = 3;
/// Share of the rows without a measurement beyond which none are averaged.
const MOST_STALE: f64 = 0.3;
/// Delay in rows from which on the input between them is taken as it was: of what a controller makes of the motion within a row,
/// hardly anything then acts in that row.
const LEADING_ROWS: f64 = 0.75;

impl Dataset {
    /// Averages blocks of samples where they are much denser than the motion is fast, down to [`THINNED_STEP`] at the
    /// most, or where [smoothing](super::smoothed) has left no news in each of them: at a high rate the one-step prediction sees the sensors' filters and clocks instead of the dynamics.
    /// Averaging is linear and the same for input and outputs, so it leaves a linear model as it is.
    pub(super) fn thin(&mut self) {
        let factor = self.rows_to_one();
        self.average(factor);
    }

    /// Rows that make one, and leaves out what was smoothed.
    pub(super) fn rows_to_one(&mut self) -> usize {
        let Some(step) = self.runs.first().map(|run| run.step) else { return 1 };
        let rates: Vec<Vec<f64>> = self.runs.iter().map(Run::rate_or_slope).collect();
        // between readings that come once in several rows nothing can be averaged
        let few_are_new = self.runs.iter().any(|run| {
            (run.unmeasured.iter().filter(|unmeasured| **unmeasured).count() as f64)
                > MOST_STALE * run.len() as f64
        });
        let most = if few_are_new { 1 } else { (THINNED_STEP / step + 1e-6) as usize };
        let enough = (decorrelation(&rates) / SAMPLES_PER_DECORRELATION).min(most).max(1);
        let rows = self.leave_out_smoothed(enough);
        enough * rows
    }

    /// Every `factor`-th reading, as a board has it that runs so much more slowly; the input is the mean over the rows to the next.
    pub(super) fn sample(&mut self, factor: usize) {
        if factor >= 2 {
            self.runs = self.runs.iter().map(|run| run.sampled(factor)).filter(|run| run.len() > 1).collect();
            self.thinned = factor;
        }
    }

    pub(super) fn average(&mut self, factor: usize) {
        if factor >= 2 {
            self.runs =
                self.runs.iter().map(|run| run.averaged(factor)).filter(|run| run.len() > 1).collect();
            self.thinned = factor;
        }
    }

    /// Whether the input between the rows is news for a craft that answers it `delay` s later.
    pub(crate) fn has_news_between(&self, delay: f64) -> bool {
        self.runs.iter().any(|run| run.has_news_between(delay))
    }

    /// The same with the input between the rows as it was, where that is news.
    pub(crate) fn with_input_between(&self, delay: f64) -> Option<Self> {
        if !self.has_news_between(delay) {
            return None;
        }
        let mut data = self.clone();
        for run in &mut data.runs {
            run.leads |= run.has_news_between(delay);
        }
        Some(data)
    }
}

impl Run {
    fn has_news_between(&self, delay: f64) -> bool {
        self.between.is_some() && !self.leads && delay >= LEADING_ROWS * self.step
    }

    /// What the input does between the rows, where it comes before what the rows show: it keeps a value for longer than a row, or the
    /// craft answers a row later. Otherwise a controller may have made it of the motion, and the noise, within that row.
    pub(crate) fn known_between(&self) -> Option<&MovingMean> {
        self.between.as_ref().filter(|_| self.leads)
    }

    /// Whether the input keeps a value for `samples` or more in the mean. One that changes faster may answer the motion within a
    /// row, and is no cause of what it answers.
    pub(crate) fn holds_longer_than(&self, samples: usize) -> bool {
        let changes = self.u.windows(2).filter(|pair| pair[0] != pair[1]).count();
        changes * samples <= self.len()
    }

    /// Every `factor`-th reading, and the means of the commands over the rows to the next.
    fn sampled(&self, factor: usize) -> Self {
        let blocks = self.len().saturating_sub(1) / factor;
        let picked = |x: &[f64]| -> Vec<f64> { x.iter().copied().step_by(factor).take(blocks).collect() };
        let averaged = self.averaged(factor);
        Self {
            start: self.start,
            held: true,
            between: None,
            leads: false,
            rate: self.rate.as_deref().map(picked),
            angle: self.angle.as_deref().map(picked),
            rate_limit: self.rate_limit,
            unmeasured: self.unmeasured.iter().copied().step_by(factor).take(blocks).collect(),
            beside: Beside {
                roll_and_yaw: self
                    .beside
                    .roll_and_yaw
                    .as_ref()
                    .map(|rows| rows.iter().copied().step_by(factor).take(blocks).collect()),
                roll_rate: self.beside.roll_rate.as_deref().map(picked),
                voltage: self.beside.voltage.as_deref().map(picked),
                ..averaged.beside
            },
            ..averaged
        }
    }

    /// The run with blocks of `factor` samples averaged; outputs by the trapezoidal rule, so that they and the held input
    /// are averaged over the same time. The averaged input changes in ramps: it is interpolated.
    fn averaged(&self, factor: usize) -> Self {
        let blocks = self.len().saturating_sub(1) / factor;
        let held = |x: &[f64]| -> Vec<f64> {
            (0..blocks).map(|b| x[b * factor..(b + 1) * factor].iter().sum::<f64>() / factor as f64).collect()
        };
        let sampled = |x: &[f64]| -> Vec<f64> {
            let half_ends = |b: usize| 0.5 * (x[(b + 1) * factor] - x[b * factor]);
            held(x).iter().enumerate().map(|(b, mean)| mean + half_ends(b) / factor as f64).collect()
        };
        let command = |x: &[f64]| if self.held { held(x) } else { sampled(x) };
        let rows = |r: &Range<usize>| r.start.div_ceil(factor)..(r.end / factor).min(blocks);
        Self {
            recording: self.recording,
            origin: self.origin,
            start: self.start + 0.5 * factor as f64 * self.step,
            step: factor as f64 * self.step,
            held: false,
            u: command(&self.u),
            between: Some(MovingMean::new(&self.u, factor, self.held)),
            leads: self.holds_longer_than(factor),
            command_news: None,
            rate: self.rate.as_deref().map(sampled),
            angle: self.angle.as_deref().map(sampled),
            rate_limit: f64::INFINITY,
            beside: Beside {
                roll_and_yaw: self
                    .beside
                    .roll_and_yaw
                    .as_ref()
                    .map(|rows| (0..blocks).map(|b| rows[b * factor + factor / 2]).collect()),
                roll_rate: self.beside.roll_rate.as_deref().map(sampled),
                roll_command: self.beside.roll_command.as_deref().map(command),
                thrust: self.beside.thrust.as_deref().map(command),
                voltage: self.beside.voltage.as_deref().map(sampled),
            },
            supervised: (0..blocks)
                .map(|b| self.supervised[b * factor..(b + 1) * factor].contains(&true))
                .collect(),
            unmeasured: if self.unmeasured.contains(&true) {
                self.unmeasured.chunks_exact(factor).take(blocks).map(|rows| !rows.contains(&false)).collect()
            } else {
                Vec::new()
            },
            sections: self
                .sections
                .iter()
                .map(|(label, r)| (label.clone(), rows(r)))
                .filter(|(_, r)| r.start < r.end)
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, parse};

    /// Averaged by four to rows of 20 ms; the input changes every `hold` samples.
    fn averaged(hold: usize) -> Dataset {
        let row = |k: usize| format!("{:.3},{},0\n", 0.005 * k as f64, (k / hold * 7919) % 101);
        let text = "t_s,u_N_m,q_rad_s\n".to_owned() + &(0..800).map(row).collect::<String>();
        let recording = parse("flight.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let mut data = Dataset::as_it_is(&[recording]).unwrap();
        data.average(4);
        data
    }

    #[test]
    fn a_board_that_runs_more_slowly_has_every_so_many_th_reading() {
        let row = |k: usize| format!("{:.3},{},{}\n", 0.005 * k as f64, k % 8, k);
        let text = "t_s,u_N_m,q_rad_s\n".to_owned() + &(0..400).map(row).collect::<String>();
        let recording = parse("flight.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let data = Dataset::on_board(&[recording], Some(0.02)).unwrap();
        let run = &data.runs[0];
        assert_eq!((run.step, run.start, run.held), (0.02, 0.0, true));
        assert_eq!(run.rate.as_ref().unwrap()[..3], [0.0, 4.0, 8.0]);
        assert_eq!(run.u[..3], [1.5, 5.5, 1.5]);
    }

    #[test]
    fn the_input_between_the_rows_is_known_where_it_cannot_answer_them() {
        let [quick, slow] = [1, 40].map(averaged);
        let known = |data: &Dataset| data.runs.iter().all(|run| run.known_between().is_some());
        assert!(!known(&quick) && known(&slow));
        assert!(quick.with_input_between(0.01).is_none(), "the craft answers within the row");
        assert!(known(&quick.with_input_between(0.02).expect("it answers later")));
        assert!(slow.with_input_between(0.02).is_none(), "no news");
    }
}
