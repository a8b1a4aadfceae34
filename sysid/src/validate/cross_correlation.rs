//! Is anything of the input left in the errors? What is, is dynamics that the model lacks.
//!
//! ```text
//! ρ(τ) = Σ_k u[k−τ] e[k] / √(Σu² Σe²),    N var ρ(τ) = Σ_l ρ_e(l) ρ_u(l)
//! |ρ(τ)| < z_M √(var ρ):  errors of any colour that do not depend on the input leave the band at any of the M lags
//!                         in at most one set in a hundred
//! ```
//!
//! In closed loop the input answers to earlier errors, so negative lags are not tested, and even positive ones can
//! leave the band without a fault of the model.
//!
//! Source: Ljung, System Identification, 2nd ed., section 16.6.

use super::whiteness::family_quantile;
use serde::Serialize;

/// Lags of both correlations that make up the variance: this share of the samples, but not more than that many.
const REACH: f64 = 0.1;
const MOST_LAGS: usize = 500;

/// The verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrossCorrelation {
    /// ρ(0), ρ(1), …
    pub correlation: Vec<f64>,
    /// Half-width of the band.
    pub band: f64,
    /// Lags outside the band.
    pub outside: usize,
    /// Whether no lag is.
    pub independent: bool,
}

/// Tests `errors` against `input` at the lags 0 to `lags`, both about their means and of one length.
#[must_use]
pub fn cross_correlation(input: &[f64], errors: &[f64], lags: usize) -> CrossCorrelation {
    let n = input.len().min(errors.len());
    let [u, e] = [&input[..n], &errors[..n]].map(|x| {
        let mean = x.iter().sum::<f64>() / n.max(1) as f64;
        x.iter().map(|x| x - mean).collect::<Vec<f64>>()
    });
    let product = |a: &[f64], b: &[f64], lag: usize| a.iter().zip(&b[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let size = (product(&u, &u, 0) * product(&e, &e, 0)).sqrt().max(f64::MIN_POSITIVE);
    let lags = lags.min(n / 4);
    let correlation: Vec<f64> = (0..=lags).map(|lag| product(&u, &e, lag) / size).collect();
    let reach = ((REACH * n as f64) as usize).min(MOST_LAGS);
    // Bartlett's weights keep the sum positive
    let both = |lag: usize| product(&u, &u, lag) * product(&e, &e, lag) / (size * size);
    let sum = both(0)
        + 2.0 * (1..=reach).map(|lag| (1.0 - lag as f64 / (reach + 1) as f64) * both(lag)).sum::<f64>();
    let band = family_quantile(lags + 1) * (sum.max(0.0) / n.max(1) as f64).sqrt();
    let outside = correlation.iter().filter(|r| r.abs() > band).count();
    CrossCorrelation { correlation, band, outside, independent: outside == 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// A two-level input, and errors of a colour of their own.
    fn draw(seed: u64) -> [Vec<f64>; 2] {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(seed);
        let (mut level, mut left, mut state) = (1.0, 0, 0.0);
        let mut input = Vec::new();
        let errors = (0..1250)
            .map(|_| {
                if left == 0 {
                    (level, left) = (-level, generator.random_range(10..30));
                }
                left -= 1;
                input.push(level);
                state = 0.9 * state + (0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0;
                state
            })
            .collect();
        [input, errors]
    }

    #[test]
    fn independent_errors_fail_as_seldom_as_stated() {
        let failed = (0..400)
            .filter(|seed| {
                let [u, e] = draw(*seed);
                !cross_correlation(&u, &e, 50).independent
            })
            .count();
        // at most 4 expected; 12 is four standard deviations
        assert!(failed <= 12, "{failed}");
    }

    #[test]
    fn missing_dynamics_are_seen_at_their_lag() {
        let [u, mut e] = draw(1);
        for k in 7..e.len() {
            e[k] += 2.0 * u[k - 7];
        }
        let found = cross_correlation(&u, &e, 50);
        let at = |lag: usize| found.correlation[lag].abs();
        assert!(!found.independent && at(7) > found.band);
        assert!((0..=50).all(|lag| at(lag) <= at(7)), "{found:?}");
    }
}
