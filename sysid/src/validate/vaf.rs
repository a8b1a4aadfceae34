//! Variance accounted for.

/// VAF = 100·max(0, 1 − var(y − ŷ)/var(y)), in per cent. Zero where the measurement does not move.
///
/// Both slices have the same length; what one has beyond the other is ignored.
pub fn vaf(measured: &[f64], simulated: &[f64]) -> f64 {
    let errors: Vec<f64> = measured.iter().zip(simulated).map(|(y, s)| y - s).collect();
    let total = variance(&measured[..errors.len()]);
    let left = variance(&errors);
    if total > 0.0 && left.is_finite() { 100.0 * (1.0 - left / total).max(0.0) } else { 0.0 }
}

/// Variance about the mean.
pub fn variance(x: &[f64]) -> f64 {
    let n = x.len().max(1) as f64;
    let mean = x.iter().sum::<f64>() / n;
    x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        let y = [1.0, -1.0, 1.0, -1.0];
        assert_eq!(vaf(&y, &y), 100.0);
        assert_eq!(vaf(&y, &[0.0; 4]), 0.0);
        assert_eq!(vaf(&y, &[0.5, -0.5, 0.5, -0.5]), 75.0);
        assert_eq!(vaf(&y, &[11.0, 9.0, 11.0, 9.0]), 100.0, "an offset does not count");
        assert_eq!(vaf(&y, &[-9.0, 9.0, -9.0, 9.0]), 0.0, "never negative");
        assert_eq!(vaf(&[0.3; 4], &y), 0.0);
        assert_eq!(vaf(&y, &[f64::NAN; 4]), 0.0);
    }
}
