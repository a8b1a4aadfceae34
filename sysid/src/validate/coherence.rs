//! Response and coherence from input to output, without a model: averaged over overlapping segments (Welch).
//!
//! ```text
//! Ĝ = S_uy / S_uu,    γ² = |S_uy|² / (S_uu S_yy),    σ(ln|Ĝ|) = σ(arg Ĝ) = √((1 − γ²)/(2 K γ²))
//! ```
//!
//! K: segments, less what their overlap of a half under Hann's window costs (5 %). 1 − γ² is the share of the output at
//! that frequency that no linear model of the input explains. In closed loop Ĝ is biased towards the inverse of the
//! controller.
//!
//! Source: Bendat, Piersol, Random Data, 4th ed., section 9.2; Welch, IEEE Transactions on Audio 15, 1967.

use super::cross_spectrum::cross_spectrum;
use serde::Serialize;

/// Frequencies at most.
const LINES: usize = 48;
/// Share of the segments that overlapping leaves independent.
const OVERLAP: f64 = 0.947;

/// The estimate at one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Line {
    /// ω, rad/s.
    pub omega_rad_s: f64,
    /// |Ĝ|, output per unit of the input.
    pub gain: f64,
    /// arg Ĝ, rad.
    pub phase_rad: f64,
    /// γ².
    pub coherence: f64,
    /// σ of ln|Ĝ| and of the phase.
    pub deviation: f64,
    /// S_yy over all lines, normalised to a sum of 1: where the motion is.
    pub output_share: f64,
}

/// The estimate over `sections` of input and output, sampled every `step` s; empty where they are too short.
#[must_use]
pub fn coherence(sections: &[[&[f64]; 2]], step: f64) -> Vec<Line> {
    let spectrum = cross_spectrum(sections, step);
    let bins = bins(spectrum.bins.len());
    let k = (OVERLAP * spectrum.segments as f64).max(1.0);
    let lines = || bins.iter().map(|bin| &spectrum.bins[bin - 1]);
    let whole: f64 = lines().map(|line| line.output).sum::<f64>().max(f64::MIN_POSITIVE);
    lines()
        .filter(|line| line.input > 0.0 && line.output > 0.0)
        .map(|line| {
            let response = line.cross / line.input;
            let coherence = (line.cross.norm_sqr() / (line.input * line.output)).min(1.0);
            Line {
                omega_rad_s: line.omega_rad_s,
                gain: response.norm(),
                phase_rad: response.arg(),
                coherence,
                deviation: ((1.0 - coherence) / (2.0 * k * coherence.max(1e-12))).sqrt(),
                output_share: line.output / whole,
            }
        })
        .collect()
}

/// Bins from 1 to `last`, thinned on the logarithm.
fn bins(last: usize) -> Vec<usize> {
    if last == 0 {
        return Vec::new();
    }
    let mut bins: Vec<usize> =
        (0..LINES).map(|k| (last as f64).powf(k as f64 / (LINES - 1) as f64).round() as usize).collect();
    bins.dedup();
    bins
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rustfft::num_complex::Complex;

    #[test]
    fn a_known_filter_is_found_within_its_deviations() {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(3);
        let mut noise = || (0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0;
        let u: Vec<f64> = (0..20_000).map(|_| noise()).collect();
        let (mut state, mut y) = (0.0, Vec::new());
        for u in &u {
            y.push(state + 0.5 * noise());
            state = 0.9 * state + 0.2 * u;
        }
        let lines = coherence(&[[&u[..9000], &y[..9000]], [&u[9000..], &y[9000..]]], 0.02);
        assert!(lines.len() > 30);
        let z: Vec<f64> = lines
            .iter()
            .map(|line| {
                let z = Complex::cis(line.omega_rad_s * 0.02);
                let truth = Complex::from(0.2) / (z - 0.9);
                let share = truth.norm_sqr() / (truth.norm_sqr() + 0.25);
                assert!((line.coherence - share).abs() < 0.2, "{line:?} {share}");
                (line.gain / truth.norm()).ln() / line.deviation
            })
            .collect();
        let spread = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
        assert!((0.6..1.5).contains(&spread), "{spread}");
        assert!((lines.iter().map(|l| l.output_share).sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn too_little_gives_nothing() {
        assert!(coherence(&[[&[0.0; 20], &[0.0; 20]]], 0.02).is_empty());
        assert!(coherence(&[], 0.02).is_empty());
        assert!(coherence(&[[&[0.0; 2000], &[0.0; 2000]]], 0.02).is_empty());
    }
}
