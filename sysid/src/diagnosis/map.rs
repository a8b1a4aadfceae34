//! Where free runs leave more than the background would: a map of time and frequency.
//!
//! ```text
//! cell = mean over a window of time and a band of |X(ω)|² Δ/(π Σ w²) / S_left(ω),   X: of measured less simulated
//! ```
//!
//! S_left is what the model's own disturbance and noise leave ([`super::spectra`]): where nothing is missing, cells are about 1.

use super::traces::Trace;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::{PI, TAU};

/// Length of a window, s, half of which it shares with the next.
const WINDOW_S: f64 = 5.0;
/// Windows of a section at most: those of a longer one are longer.
const MOST_WINDOWS: f64 = 60.0;
/// Bands, evenly spaced on the logarithm.
const BANDS: usize = 12;
/// Noise alone is as strong as a cell's `chance` in one of so many cells.
const ONE_OF: f64 = 100.0;
/// Neighbouring lines under Hann's window count as this much less.
const INDEPENDENT: f64 = 0.66;

/// What is left in a window of time and a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Index of the recording.
    pub recording: usize,
    /// Window, s by the clock of the file.
    pub time_s: [f64; 2],
    /// Band, rad/s.
    pub band_rad_s: [f64; 2],
    /// Power of what is left over that of the background.
    pub power: f64,
    /// The power that the background alone reaches in one of a hundred cells.
    pub chance: f64,
}

/// The map of `simulated` less measured over `traces`; `background` by frequency in rad/s. Empty where sections are shorter
/// than a window or a simulation diverges.
pub fn map(traces: &[Trace], simulated: fn(&Trace) -> &Vec<f64>, background: &[[f64; 2]]) -> Vec<Cell> {
    traces.iter().flat_map(|trace| of_section(trace, simulated(trace), background)).collect()
}

fn of_section(trace: &Trace, simulated: &[f64], background: &[[f64; 2]]) -> Vec<Cell> {
    let (Some(&first), Some(&second)) = (trace.t.first(), trace.t.get(1)) else { return Vec::new() };
    if simulated.len() != trace.measured.len() || background.is_empty() {
        return Vec::new();
    }
    let step = second - first;
    let left: Vec<f64> = trace.measured.iter().zip(simulated).map(|(m, s)| m - s).collect();
    let seconds = (left.len() as f64 * step * 2.0 / MOST_WINDOWS).max(WINDOW_S);
    let length = (seconds / step) as usize;
    if length < 16 || left.len() < length {
        return Vec::new();
    }
    let starts = (0..=left.len() - length).step_by(length / 2);
    let window = |from: usize| {
        let middle = first + (from as f64 + 0.5 * length as f64) * step;
        let shown = [middle - 0.25 * length as f64 * step, middle + 0.25 * length as f64 * step];
        of_window(trace.recording, shown, &left[from..from + length], step, background)
    };
    starts.flat_map(window).collect()
}

fn of_window(
    recording: usize,
    time_s: [f64; 2],
    left: &[f64],
    step: f64,
    background: &[[f64; 2]],
) -> Vec<Cell> {
    let n = left.len();
    let mean = left.iter().sum::<f64>() / n as f64;
    let hann = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / n as f64).cos();
    let mut lines: Vec<Complex<f64>> =
        left.iter().enumerate().map(|(k, x)| Complex::from(hann(k) * (x - mean))).collect();
    FftPlanner::new().plan_fft_forward(n).process(&mut lines);
    let width = TAU / (n as f64 * step);
    // the squares of Hann's window add up to 3n/8
    let scale = step / (PI * 0.375 * n as f64);
    let power = |k: usize| lines[k].norm_sqr() * scale / at(background, k as f64 * width);
    let [low, high] = [1, n / 2].map(|k| k as f64);
    let edge = |b: usize| low * (high / low).powf(b as f64 / BANDS as f64);
    let cell = |b: usize| {
        let [from, to] = [edge(b), edge(b + 1)].map(|line| line.round() as usize);
        let count = to.saturating_sub(from);
        (count > 0).then(|| Cell {
            recording,
            time_s,
            band_rad_s: [(from as f64 - 0.5) * width, (to as f64 - 0.5) * width],
            power: (from..to).map(power).sum::<f64>() / count as f64,
            chance: quantile(2.0 * (1.0 + INDEPENDENT * (count - 1) as f64)),
        })
    };
    (0..BANDS).filter_map(cell).collect()
}

/// The density at `omega`, by its neighbours on the logarithm of the frequency; beyond the ends that of the end.
fn at(density: &[[f64; 2]], omega: f64) -> f64 {
    let after = density.partition_point(|[known, _]| *known < omega);
    match (after.checked_sub(1).and_then(|k| density.get(k)), density.get(after)) {
        (Some([a, low]), Some([b, high])) => {
            let share = (omega / a).ln() / (b / a).ln();
            low.powf(1.0 - share) * high.powf(share)
        }
        (Some([_, only]), None) | (None, Some([_, only])) => *only,
        (None, None) => f64::NAN,
    }
}

/// What a mean of squares of `freedom` exceeds in one of [`ONE_OF`] cases, in units of its mean.
fn quantile(freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(f64::INFINITY, |chi| chi.inverse_cdf(1.0 - 1.0 / ONE_OF) / freedom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// White noise of variance 1/3 for a minute, with a wave of 15 rad/s from 20 to 30 s.
    fn trace(strength: f64) -> Trace {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(1);
        let t: Vec<f64> = (0..3000).map(|k| 0.02 * f64::from(k)).collect();
        let wave = |t: f64| if (20.0..30.0).contains(&t) { strength * (15.0 * t).sin() } else { 0.0 };
        Trace {
            label: "I".into(),
            recording: 0,
            input: Vec::new(),
            measured: t.iter().map(|t| generator.random_range(-1.0..1.0) + wave(*t)).collect(),
            baseline: vec![0.0; t.len()],
            extended: Vec::new(),
            unit: "rad/s",
            angle: None,
            t,
        }
    }

    fn of(strength: f64) -> Vec<Cell> {
        map(&[trace(strength)], |trace| &trace.baseline, &[[1.0, 0.02 / (3.0 * PI)]])
    }

    #[test]
    fn noise_is_as_strong_as_it_is_expected() {
        let cells = of(0.0);
        let mean = cells.iter().map(|cell| cell.power).sum::<f64>() / cells.len() as f64;
        assert!((0.85..1.15).contains(&mean), "{mean}");
        let by_chance = cells.iter().filter(|cell| cell.power > cell.chance).count();
        assert!(by_chance <= 6, "{by_chance} of {}", cells.len());
    }

    #[test]
    fn what_is_left_is_seen_where_it_is() {
        let cells = of(0.5);
        let strongest = cells.iter().max_by(|a, b| a.power.total_cmp(&b.power)).unwrap();
        assert!(strongest.power > 3.0 * strongest.chance);
        assert!(strongest.time_s[0] >= 20.0 && strongest.time_s[1] <= 30.0, "{strongest:?}");
        assert!(strongest.band_rad_s[0] < 15.0 && strongest.band_rad_s[1] > 15.0, "{strongest:?}");
    }

    #[test]
    fn a_simulation_that_diverged_has_no_map() {
        assert!(map(&[trace(0.0)], |trace| &trace.extended, &[[1.0, 1.0]]).is_empty());
    }
}
