//! Lines that stand out of a spectrum.

use crate::model::effect::{Parameter, Scale};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Lines on each side of a frequency among which its power is compared.
const AROUND: usize = 40;
/// Zeros behind the data, as multiples of their length: the grid of frequencies is as much finer.
const FINER: usize = 4;
/// Lines this far apart, in units of one over the data's length, are not of one peak.
const APART: usize = 3;

/// A phase: over two turns, so that none stands at a bound.
pub const PHASE: Parameter =
    Parameter { name: "phase", unit: "rad", lower: 0.0, upper: 2.0 * TAU, scale: Scale::Linear(0.5) };

/// `phase` within the turn in the middle of these two, to begin with.
pub fn amid(phase: f64) -> f64 {
    (phase - 0.5 * TAU).rem_euclid(TAU) + 0.5 * TAU
}

/// A line.
pub struct Line {
    /// In periods per unit of the step.
    pub frequency: f64,
    /// Of cos ωx and −sin ωx, x from the first value on.
    pub amplitude: Complex<f64>,
    /// Its power over the median of its surroundings.
    pub prominence: f64,
}

/// The two lines of `values`, which lie `step` apart, above the frequency `lowest` that stand out most from the median of their
/// surroundings; none of fewer than 80 values.
pub fn lines(values: &[f64], step: f64, lowest: f64) -> Vec<Line> {
    let n = values.len();
    if n < 2 * AROUND {
        return Vec::new();
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let window = |k: usize| 1.0 - (TAU * (k as f64 + 0.5) / n as f64).cos();
    let mut buffer: Vec<Complex<f64>> =
        values.iter().enumerate().map(|(k, m)| Complex::from((m - mean) * window(k))).collect();
    buffer.resize((FINER * n).next_power_of_two(), Complex::default());
    FftPlanner::new().plan_fft_forward(buffer.len()).process(&mut buffer);
    let spacing = 1.0 / (step * buffer.len() as f64);
    let power: Vec<f64> =
        buffer.iter().take((0.9 * buffer.len() as f64 / 2.0) as usize).map(Complex::norm_sqr).collect();
    // Every line of the unpadded grid, then the finer one beside the highest.
    let stride = buffer.len() / n;
    let coarse: Vec<usize> = ((lowest / spacing).ceil() as usize..power.len()).step_by(stride).collect();
    let prominence = |place: usize| {
        let (from, to) = (place.saturating_sub(AROUND), (place + AROUND + 1).min(coarse.len()));
        let mut around: Vec<f64> = coarse[from..to].iter().map(|&j| power[j]).collect();
        let middle = around.len() / 2;
        power[coarse[place]] / around.select_nth_unstable_by(middle, f64::total_cmp).1.max(f64::MIN_POSITIVE)
    };
    let mut ranked: Vec<(f64, usize)> = (0..coarse.len()).map(|place| (prominence(place), place)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut peaks: Vec<(f64, usize)> = Vec::new();
    for (prominence, place) in ranked {
        if peaks.len() < 2 && peaks.iter().all(|&(_, other)| place.abs_diff(other) > APART) {
            peaks.push((prominence, place));
        }
    }
    let finest = |place: usize| {
        let (from, to) =
            (coarse[place].saturating_sub(stride), (coarse[place] + stride + 1).min(power.len()));
        (from..to).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap_or(coarse[place])
    };
    let line = |(prominence, place)| {
        let j = finest(place);
        Line { frequency: spacing * j as f64, amplitude: buffer[j] * (2.0 / n as f64), prominence }
    };
    peaks.into_iter().map(line).collect()
}
