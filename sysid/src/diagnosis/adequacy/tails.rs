//! Errors larger than those of Gaussian noise: the kurtosis of the innovations.
//!
//! Its distribution under the null by the transformation of Anscombe and Glynn (Biometrika 70, 1983), good from twenty
//! values on. One-sided: tails lighter than Gaussian are rounding, and harm nothing.

use super::Test;
use super::left::Left;
use super::p_values::{least_of, normal_tail};
use crate::estimate::digits;

/// Tests every channel.
pub fn test(left: &Left) -> Test {
    let kurtoses = (0..left.channels).map(|channel| kurtosis(&left.channel(channel)));
    let worst = kurtoses.max_by(f64::total_cmp).unwrap_or(3.0);
    Test {
        name: "tails",
        statistic: worst,
        p_value: least_of(p_value(worst, left.errors.len()), left.channels),
        closes: 0.0,
        of_physics: false,
        windows: Vec::new(),
        words: format!(
            "errors with tails heavier than Gaussian (kurtosis {}; 3 for Gaussian)",
            digits(worst)
        ),
    }
}

/// Fourth moment over the square of the second, about the mean.
pub fn kurtosis(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let moment = |power: i32| values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / n;
    moment(4) / moment(2).powi(2).max(f64::MIN_POSITIVE)
}

/// Probability that `count` Gaussian values have that kurtosis or more.
pub fn p_value(kurtosis: f64, count: usize) -> f64 {
    let n = count as f64;
    if n < 20.0 {
        return 1.0;
    }
    let mean = 3.0 * (n - 1.0) / (n + 1.0);
    let variance = 24.0 * n * (n - 2.0) * (n - 3.0) / ((n + 1.0) * (n + 1.0) * (n + 3.0) * (n + 5.0));
    let x = (kurtosis - mean) / variance.sqrt();
    let skewness = 6.0 * (n * n - 5.0 * n + 2.0) / ((n + 7.0) * (n + 9.0))
        * (6.0 * (n + 3.0) * (n + 5.0) / (n * (n - 2.0) * (n - 3.0))).sqrt();
    let a = 6.0 + 8.0 / skewness * (2.0 / skewness + (1.0 + 4.0 / (skewness * skewness)).sqrt());
    let part = 2.0 / (9.0 * a);
    let below = 1.0 + x * (2.0 / (a - 4.0)).sqrt();
    if below <= 0.0 {
        return 1.0;
    }
    normal_tail((1.0 - part - ((1.0 - 2.0 / a) / below).cbrt()) / part.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::normal;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn one_large_error_in_a_hundred_shows() {
        let mut random = Pcg64::seed_from_u64(3);
        let mut values: Vec<f64> = (0..4000).map(|_| normal(&mut random)).collect();
        assert!(p_value(kurtosis(&values), 4000) > 0.5);
        values.iter_mut().step_by(100).for_each(|v| *v *= 6.0);
        assert!(p_value(kurtosis(&values), 4000) < 1e-9);
    }
}
