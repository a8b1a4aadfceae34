//! The noise model: the output errors as an autoregression, e\[k\] = Σ_j a_j e\[k−j\] + white, by the recursion of
//! Levinson and Durbin over all sections together.
//!
//! BIC decides whether there is colour at all; the order is then that of the least AIC, for an autoregression that is
//! too short for a slow disturbance overstates its power at rest, and with it the bounds.

/// Highest order, and least number of samples for each of its coefficients.
const HIGHEST_ORDER: usize = 25;
const SAMPLES_EACH: usize = 25;

/// Coefficients a_1.. of the autoregression of `sections`; none where the errors are white.
pub(in crate::identify) fn autoregression(sections: &[Vec<f64>]) -> Vec<f64> {
    let count: usize = sections.iter().map(Vec::len).sum();
    let shortest = sections.iter().map(Vec::len).min().unwrap_or(0);
    let highest = HIGHEST_ORDER.min(count / SAMPLES_EACH).min(shortest / 4);
    let n = count as f64;
    let correlation: Vec<f64> = (0..=highest).map(|lag| autocovariance(sections, lag)).collect();
    let (mut a, mut variance) = (Vec::<f64>::new(), correlation[0]);
    let white = n * variance.ln();
    let (mut best, mut least, mut coloured) = (Vec::new(), white, false);
    for order in 1..=highest {
        if variance <= 0.0 {
            break;
        }
        let predicted: f64 = a.iter().enumerate().map(|(j, a)| a * correlation[order - 1 - j]).sum();
        let reflection = (correlation[order] - predicted) / variance;
        let mirrored: Vec<f64> = a.iter().rev().copied().collect();
        for (a, mirrored) in a.iter_mut().zip(mirrored) {
            *a -= reflection * mirrored;
        }
        a.push(reflection);
        variance *= 1.0 - reflection * reflection;
        let deviance = n * variance.ln();
        coloured |= deviance + order as f64 * n.ln() < white;
        if deviance + 2.0 * (order as f64) < least {
            (best, least) = (a.clone(), deviance + 2.0 * order as f64);
        }
    }
    if coloured { best } else { Vec::new() }
}

/// 1/N Σ e\[k\] e\[k−lag\], no product across a joint.
pub(super) fn autocovariance(sections: &[Vec<f64>], lag: usize) -> f64 {
    let products = |e: &Vec<f64>| e.iter().zip(e.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>();
    let count: usize = sections.iter().map(Vec::len).sum();
    sections.iter().map(products).sum::<f64>() / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn white(seed: u64, n: usize) -> Vec<f64> {
        let mut generator = Pcg64::seed_from_u64(seed);
        // sum of uniforms: normal enough, and no further dependency
        (0..n).map(|_| (0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn known_coefficients_are_found_and_white_errors_have_none() {
        let mut e = white(1, 20_000);
        for k in 2..e.len() {
            e[k] += 1.2 * e[k - 1] - 0.5 * e[k - 2];
        }
        let found = autoregression(&[e[..9000].to_vec(), e[9000..].to_vec()]);
        assert!((2..6).contains(&found.len()), "{found:?}");
        assert!((found[0] - 1.2).abs() < 0.03 && (found[1] + 0.5).abs() < 0.04, "{found:?}");
        assert!(autoregression(&[white(2, 20_000)]).is_empty());
        assert!(autoregression(&[vec![0.0; 100]]).is_empty());
        assert!(autoregression(&[vec![1.0; 3]]).is_empty());
    }
}
