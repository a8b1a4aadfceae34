//! Probabilities that more than one of the tests needs.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Probability with which blocks that are what the model takes them for give no divisor above one (as for evidence).
const NO_DIVISOR: f64 = 0.9;

/// Probability that the least of `count` independent p-values is `p` or less: 1 − (1 − p)^count (Šidák, 1967).
pub fn least_of(p: f64, count: usize) -> f64 {
    -f64::exp_m1(count as f64 * f64::ln_1p(-p.clamp(0.0, 1.0 - f64::EPSILON)))
}

/// P(χ²(freedom) > x).
pub fn chi_squared_tail(x: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |chi| chi.sf(x.max(0.0)))
}

/// P(|N(0, 1)| > |z|).
pub fn two_sided(z: f64) -> f64 {
    2.0 * normal_tail(z.abs())
}

/// P(N(0, 1) > z).
pub fn normal_tail(z: f64) -> f64 {
    Normal::standard().sf(z)
}

/// P(Σ λ_j χ²_j(1) > q) by the gamma distribution with the same mean, variance and skewness, from the sums
/// c_k = Σ λ_j^k (Pearson, 1959; Liu, Tang and Zhang, Computational Statistics & Data Analysis 53, 2009):
///
/// ```text
/// l = c₂³/c₃²,    P(χ²_l > l + √(2l) (q − c₁)/√(2c₂))
/// ```
pub fn mixture_tail(q: f64, [c1, c2, c3]: [f64; 3]) -> f64 {
    let freedom = c2.powi(3) / (c3 * c3);
    chi_squared_tail(freedom + (2.0 * freedom).sqrt() * (q - c1) / (2.0 * c2).sqrt(), freedom)
}

/// By what a variance is divided that blocks show to be `ratio` times what the model says, where chance leaves that ratio
/// `freedom` degrees of freedom: one where the blocks are no more uneven than chance makes them.
pub fn divisor(ratio: f64, freedom: f64) -> f64 {
    let chance = ChiSquared::new(freedom).map_or(1.0, |chi| chi.inverse_cdf(NO_DIVISOR) / freedom);
    if ratio.is_finite() { (ratio / chance).max(1.0) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64) -> bool {
        (found / expected - 1.0).abs() < 1e-5
    }

    #[test]
    fn tails_are_those_of_the_tables() {
        assert!(near(chi_squared_tail(7.0, 2.5), 0.048_333_6) && chi_squared_tail(-1.0, 3.0) == 1.0);
        assert!(near(normal_tail(1.3), 0.096_800_5) && near(normal_tail(-1.3), 0.903_199_5));
        assert!(near(two_sided(-1.3), 0.193_601) && near(two_sided(1.3), 0.193_601));
        assert!(near(least_of(0.2, 4), 0.5904) && near(least_of(0.3, 1), 0.3));
        // what rounding takes beyond one is one
        assert!(near(least_of(1.0, 2), 1.0) && near(least_of(1.0 + 1e-9, 2), 1.0));
    }

    #[test]
    fn a_divisor_is_what_chance_does_not_make() {
        // the 90 % point of χ²(30) is 40.256
        assert!(near(divisor(4.0, 30.0), 2.980_920_3));
        assert_eq!(
            (divisor(1.3, 30.0), divisor(f64::INFINITY, 30.0), divisor(f64::NAN, 30.0)),
            (1.0, 1.0, 1.0)
        );
    }

    #[test]
    fn a_mixture_of_weights_is_near_what_many_draws_show() {
        // χ²(1) + χ²(1)/2 > 4 in 7.30 % of ten million draws; of equal weights it is that of χ²
        let found = mixture_tail(4.0, [1.5, 1.25, 1.125]);
        assert!(near(found, 0.074_815_4) && (found - 0.073).abs() < 0.002, "{found}");
    }

    #[test]
    fn a_mixture_of_equal_weights_is_chi_squared() {
        // three weights of 2: 2 χ²(3); its 5 % point is 2 · 7.815
        assert!((mixture_tail(15.63, [6.0, 12.0, 24.0]) - 0.05).abs() < 1e-4);
        assert!((least_of(0.01, 3) - 0.029_701).abs() < 1e-9);
        assert!((least_of(1e-30, 100) / 1e-28 - 1.0).abs() < 1e-9);
        assert!(divisor(1.1, 30.0) == 1.0 && divisor(4.0, 30.0) > 2.0);
    }
}
