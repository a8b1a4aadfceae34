//! A recording at its full rate, its input made finer for the simulation.

use sysid::dataset::{Beside, Run};
use sysid::recording::{InputHold, Recording};

/// Half the width of the interpolating kernel, samples.
const REACH: isize = 24;

/// Signals to simulate and to compare with.
pub struct Piece {
    /// The input, `finer` rows for every sample; no output.
    pub run: Run,
    /// Rows of `run` in one sample.
    pub finer: usize,
    /// The measured position, sample by sample.
    pub y: Vec<f64>,
}

impl Piece {
    /// Of samples `rows` of a recording without gaps, every sample cut into `finer`.
    pub fn new(recording: &Recording, rows: core::ops::Range<usize>, finer: usize) -> Self {
        let held = recording.input_hold == InputHold::Held;
        let u = &recording.u;
        let fine = |i: usize| {
            let (k, part) = (rows.start + i / finer, (i % finer) as f64 / finer as f64);
            if held || part == 0.0 { u[k] } else { between(u, k, part) }
        };
        let all = rows.len() * finer;
        let run = Run {
            recording: 0,
            origin: recording.t[0],
            start: recording.t[rows.start],
            step: recording.step / finer as f64,
            held,
            between: None,
            command_news: None,
            leads: false,
            u: (0..all).map(fine).collect(),
            rate: None,
            angle: None,
            rate_limit: f64::INFINITY,
            beside: Beside::default(),
            supervised: vec![false; all],
            unmeasured: Vec::new(),
            sections: Vec::new(),
        };
        let y = recording.theta.as_deref().unwrap_or_default();
        Self { run, finer, y: y.get(rows).unwrap_or_default().to_vec() }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.y.len()
    }
}

/// A band-limited signal `part` of a sample after row `k`: Whittaker's series (1915) under a Hann window; beyond its ends the
/// signal stays as it is there.
fn between(u: &[f64], k: usize, part: f64) -> f64 {
    let at = |i: isize| u[usize::try_from(i).unwrap_or(0).min(u.len() - 1)];
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in 1 - REACH..=REACH {
        let x = std::f64::consts::PI * (part - i as f64);
        let window = 0.5 * (1.0 + (x / REACH as f64).cos());
        let weight = window * x.sin() / x;
        sum += weight * at(k as isize + i);
        weights += weight;
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_limited_signal_is_found_between_its_samples() {
        let wave = |t: f64| (1.3 * t).sin() + 0.3 * (2.0 * t + 1.0).cos();
        let u: Vec<f64> = (0..200).map(|k| wave(f64::from(k))).collect();
        for part in [0.1, 0.25, 0.5, 0.9] {
            let error = between(&u, 100, part) - wave(100.0 + part);
            assert!(error.abs() < 3e-3, "{part} {error}");
        }
    }
}
