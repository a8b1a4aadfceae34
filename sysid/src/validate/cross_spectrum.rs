//! Spectra of input and output and the cross-spectrum between them, averaged over overlapping segments under Hann's window.
//!
//! ```text
//! S_xy(ω) = Δ/(π Σ w²) · mean over segments of Y(ω) X*(ω),   X(ω) = Σ_k w_k x_k e^{−iωkΔ}
//! ```
//!
//! One-sided: ∫ S_xx dω over 0 < ω < π/Δ is the variance of x.
//!
//! Source: Welch, IEEE Transactions on Audio 15, 1967.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::{PI, TAU};

/// Length of a segment, s, and least number of them.
const SEGMENT_S: f64 = 8.0;
const LEAST_SEGMENTS: usize = 4;

/// The spectra.
pub struct CrossSpectrum {
    /// Frequencies below half the sampling rate, evenly spaced; none where the sections are too short.
    pub bins: Vec<Bin>,
    /// Number of segments.
    pub segments: usize,
    /// Samples of a segment.
    pub length: usize,
}

/// One frequency.
#[derive(Clone, Copy, Debug)]
pub struct Bin {
    /// ω, rad/s.
    pub omega_rad_s: f64,
    /// S_uu, unit of the input squared per rad/s.
    pub input: f64,
    /// S_yy, unit of the output squared per rad/s.
    pub output: f64,
    /// S_uy.
    pub cross: Complex<f64>,
}

/// The spectra over `sections` of input and output, sampled every `step` s, each segment about its mean.
#[must_use]
pub fn cross_spectrum(sections: &[[&[f64]; 2]], step: f64) -> CrossSpectrum {
    let longest = sections.iter().map(|[u, y]| u.len().min(y.len())).max().unwrap_or(0);
    let length = ((SEGMENT_S / step) as usize).min(2 * longest / (LEAST_SEGMENTS + 1));
    if length < 16 {
        return CrossSpectrum { bins: Vec::new(), segments: 0, length };
    }
    let window: Vec<f64> =
        (0..length).map(|k| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / length as f64).cos()).collect();
    let transform = FftPlanner::new().plan_fft_forward(length);
    let mut sums = vec![(0.0, 0.0, Complex::from(0.0)); length / 2 - 1];
    let mut segments = 0;
    for [u, y] in sections {
        let count = u.len().min(y.len());
        let mut from = 0;
        while from + length <= count {
            let [a, b] = [u, y].map(|x| {
                let mut lines = windowed(&x[from..from + length], &window);
                transform.process(&mut lines);
                lines
            });
            for (k, sum) in sums.iter_mut().enumerate() {
                sum.0 += a[k + 1].norm_sqr();
                sum.1 += b[k + 1].norm_sqr();
                sum.2 += b[k + 1] * a[k + 1].conj();
            }
            segments += 1;
            from += length / 2;
        }
    }
    let power = window.iter().map(|w| w * w).sum::<f64>();
    let scale = step / (PI * power * f64::from(segments.max(1)));
    let bin = |(k, (input, output, cross)): (usize, &(f64, f64, Complex<f64>))| Bin {
        omega_rad_s: TAU * (k + 1) as f64 / (length as f64 * step),
        input: input * scale,
        output: output * scale,
        cross: cross * scale,
    };
    CrossSpectrum { bins: sums.iter().enumerate().map(bin).collect(), segments: segments as usize, length }
}

/// The segment about its mean, windowed.
fn windowed(x: &[f64], window: &[f64]) -> Vec<Complex<f64>> {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    x.iter().zip(window).map(|(x, w)| Complex::from((x - mean) * w)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn a_spectrum_holds_the_variance() {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(1);
        let white: Vec<f64> = (0..20_000).map(|_| generator.random_range(-1.0..1.0)).collect();
        let half: Vec<f64> = white.iter().map(|x| 0.5 * x).collect();
        let found = cross_spectrum(&[[&white, &half]], 0.02);
        let width = TAU / (found.length as f64 * 0.02);
        let sum = |of: fn(&Bin) -> f64| found.bins.iter().map(of).sum::<f64>() * width;
        assert!((sum(|b| b.input) * 3.0 - 1.0).abs() < 0.05, "{}", sum(|b| b.input));
        assert!(
            (sum(|b| b.output) * 12.0 - 1.0).abs() < 0.05 && (sum(|b| b.cross.re) * 6.0 - 1.0).abs() < 0.05
        );
    }

    #[test]
    fn too_little_has_no_spectrum() {
        assert!(cross_spectrum(&[[&[1.0; 20], &[1.0; 20]]], 0.02).bins.is_empty());
    }
}
