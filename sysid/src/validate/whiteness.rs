//! Are the errors white? Ljung's and Box's test, and a band for each lag.
//!
//! ```text
//! ρ(τ) = r(τ)/r(0),   Q = N (N+2) Σ_τ ρ(τ)²/(N−τ) ~ χ²_M,   τ = 1..M
//! |ρ(τ)| < z_M/√N:  white errors leave the band at any of the M lags in at most one set in a hundred
//! ```
//!
//! A free run's errors hold the disturbance too, and are white only where there is none: failing this test speaks
//! against intervals that assume white errors, not against the model; [`super::cross_correlation`] does.
//!
//! Source: Ljung, Box, Biometrika 65, 1978.

use super::ODDS;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// The verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Whiteness {
    /// ρ(1), ρ(2), …
    pub correlation: Vec<f64>,
    /// Half-width of the band.
    pub band: f64,
    /// Probability of a larger Q with white errors.
    pub p_value: f64,
    /// Whether the p-value is above one in a hundred.
    pub white: bool,
}

/// Tests `errors` (about their mean) at the lags 1 to `lags`.
#[must_use]
pub fn whiteness(errors: &[f64], lags: usize) -> Whiteness {
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n.max(1.0);
    let e: Vec<f64> = errors.iter().map(|e| e - mean).collect();
    let at = |lag: usize| e.iter().zip(&e[lag..]).map(|(a, b)| a * b).sum::<f64>();
    let lags = lags.min(errors.len() / 4);
    let power = at(0).max(f64::MIN_POSITIVE);
    let correlation: Vec<f64> = (1..=lags).map(|lag| at(lag) / power).collect();
    let statistic: f64 =
        correlation.iter().enumerate().map(|(k, r)| n * (n + 2.0) * r * r / (n - 1.0 - k as f64)).sum();
    let p_value = ChiSquared::new(lags.max(1) as f64).map_or(1.0, |chi| chi.sf(statistic));
    Whiteness { correlation, band: family_quantile(lags) / n.sqrt().max(1.0), p_value, white: p_value > ODDS }
}

/// Quantile that a standard normal variable exceeds in size at any of `count` lags in at most one case in a hundred
/// (Bonferroni).
pub(super) fn family_quantile(count: usize) -> f64 {
    let tail = ODDS / (2.0 * count.max(1) as f64);
    Normal::new(0.0, 1.0).map_or(2.6, |normal| normal.inverse_cdf(1.0 - tail))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn draws(seed: u64, n: usize) -> Vec<f64> {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(seed);
        (0..n).map(|_| (0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn white_errors_fail_as_seldom_as_stated() {
        let tests: Vec<Whiteness> = (0..600).map(|seed| whiteness(&draws(seed, 1000), 25)).collect();
        let failed = tests.iter().filter(|t| !t.white).count();
        let outside = tests.iter().filter(|t| t.correlation.iter().any(|r| r.abs() > t.band)).count();
        // 6 expected of each; 16 is four standard deviations
        assert!(failed <= 16 && outside <= 16, "{failed} {outside}");
        assert!(tests.iter().filter(|t| t.p_value < 0.2).count() > 60, "the p-values are not all large");
    }

    #[test]
    fn a_slow_disturbance_is_seen() {
        let mut e = draws(1, 1000);
        for k in 1..e.len() {
            e[k] += 0.3 * e[k - 1];
        }
        let found = whiteness(&e, 25);
        assert!(!found.white && found.correlation[0] > found.band, "{found:?}");
        assert!(whiteness(&[], 10).white);
    }
}
