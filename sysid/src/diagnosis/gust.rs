//! A disturbance that is more than the ordinary background: told by its spectrum.
//!
//! The moment that the input does not cause has the fitted spectrum (a < b)
//!
//! ```text
//! S(ω) = K (z² + ω²) / ((a² + ω²)(b² + ω²)) = A / (a² + ω²) + (K − A) ω² / ((a² + ω²)(b² + ω²)),    A = K z²/b²
//! ```
//!
//! whose first part is a gust, T ẇ = −w + noise with T = 1/a and σ² = A/(2a), and whose second part is a band-passed
//! background. Background has little power at low frequencies; a gust has most of its power there.

use super::problem::Problem;
use super::search::Fit;
use crate::estimate::Estimate;
use crate::identify::levenberg_marquardt::covariance;
use crate::model::grey_box::Disturbance;
use nalgebra::DVector;

/// Bands that tell a gust from the background, rad/s.
const LOW_BAND: [f64; 2] = [0.3, 0.8];
const HIGH_BAND: [f64; 2] = [3.0, 6.0];
/// Power in the low band relative to the high band from which on a disturbance is a gust. Band-passed backgrounds lie
/// below 0.35, gusts above 2.
const LEAST_RATIO: f64 = 0.7;
/// Standard errors by which the logarithm of the ratio must exceed that of a background.
const LEAST_SCORE: f64 = 2.0;
/// Largest ratio that an ordinary background has.
const BACKGROUND_RATIO: f64 = 0.35;
/// A gust whose ln σ is known no better than this is not told from the background's own spectrum.
const WIDEST: f64 = 1.0;
/// A moment slower than this share of the data is a drift, of which no spectrum is seen.
const LONGEST_SHARE: f64 = 0.1;
/// A gust weaker than this share of the control moment is an ordinary background.
const MILD: f64 = 0.05;

/// A disturbance that is a finding.
#[derive(Clone, Debug)]
pub struct Gust {
    /// σ in N m and T in s.
    pub parameters: Vec<Estimate>,
    /// Standard errors by which the logarithm of the ratio exceeds that of a background.
    pub score: f64,
    /// Odds of so large a ratio if the disturbance were an ordinary background.
    pub p_value: f64,
}

/// Whether the disturbance that `fit` found is a gust.
pub fn gust(problem: &Problem<'_>, fit: &Fit) -> Option<Gust> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let told = Told::of(&unpacked.disturbance);
    let time = (-told.log_pole).exp();
    let slow = told.log_ratio > LEAST_RATIO.ln() && time < LONGEST_SHARE * problem.sizes.duration;
    if !slow {
        return None;
    }
    let sigma = told.log_sigma.exp() * sensor_noise(problem, fit)?;
    if sigma < MILD * problem.sizes.moment {
        return None;
    }
    let errors = standard_errors(problem, fit)?;
    let score = (told.log_ratio - BACKGROUND_RATIO.ln()) / errors.log_ratio;
    let sure = score > LEAST_SCORE && errors.log_sigma <= WIDEST;
    if !sure {
        return None;
    }
    let estimate = |name: &str, unit: &str, value: f64, error: f64, bounds: [f64; 2]| {
        let mut estimate = Estimate::new(name, unit, value, value * error, bounds);
        let times = |sign: f64| (value * (sign * 1.96 * error).exp()).clamp(bounds[0], bounds[1]);
        estimate.ci95 = [times(-1.0), times(1.0)];
        estimate
    };
    let largest = problem.sizes.moment.max(sigma);
    Some(Gust {
        parameters: vec![
            estimate("sigma", "N m", sigma, errors.log_sigma, [0.0, largest]),
            estimate("T", "s", time, errors.log_pole, [problem.sizes.step, problem.sizes.duration]),
        ],
        score,
        p_value: 0.5 * statrs::function::erf::erfc(score / std::f64::consts::SQRT_2),
    })
}

/// What a disturbance model says of its slow part, in logarithms.
#[derive(Clone, Copy)]
struct Told {
    log_ratio: f64,
    /// ln σ, up to the sensor's noise.
    log_sigma: f64,
    /// ln a.
    log_pole: f64,
}

impl Told {
    fn of(disturbance: &Disturbance) -> Self {
        let Disturbance { intensity, slow, fast, zero, .. } = *disturbance;
        let (a, b) = (slow.min(fast), slow.max(fast));
        Self {
            log_ratio: (mean_power(disturbance, LOW_BAND) / mean_power(disturbance, HIGH_BAND)).ln(),
            log_sigma: (intensity * zero / b).ln() - 0.5 * (2.0 * a).ln(),
            log_pole: a.ln(),
        }
    }
}

fn mean_power(disturbance: &Disturbance, band: [f64; 2]) -> f64 {
    const POINTS: usize = 16;
    let at = |i: usize| band[0] + (band[1] - band[0]) * (i as f64 + 0.5) / POINTS as f64;
    (0..POINTS).map(|i| disturbance.spectrum(at(i))).sum::<f64>() / POINTS as f64
}

/// Standard errors of what is told, from those of the noise model's unknowns.
fn standard_errors(problem: &Problem<'_>, fit: &Fit) -> Option<Told> {
    let values = &fit.minimum.values;
    let residuals = |v: &[f64]| problem.prediction_errors(&fit.effects, v);
    let all = covariance(&residuals, problem.channels(), &problem.coordinates(&fit.effects), values, 0)?;
    let range = problem.noise_range();
    let noise = all.view((range.start, range.start), (range.len(), range.len()));
    let told = |v: &[f64]| Told::of(&problem.unpack(&fit.effects, v).disturbance);
    let at = told(values);
    let mut slopes: Vec<[f64; 3]> = Vec::new();
    for i in range {
        let h = 1e-4 * values[i];
        let mut moved = values.clone();
        moved[i] += h;
        let next = told(&moved);
        slopes.push([
            (next.log_ratio - at.log_ratio) / h,
            (next.log_sigma - at.log_sigma) / h,
            (next.log_pole - at.log_pole) / h,
        ]);
    }
    let error = |which: usize| {
        let slope = DVector::from_iterator(slopes.len(), slopes.iter().map(|s| s[which]));
        slope.dot(&(noise * &slope)).max(0.0).sqrt()
    };
    Some(Told { log_ratio: error(0), log_sigma: error(1), log_pole: error(2) })
}

/// Standard deviation of the first channel's white noise: that of its innovations, less what the state's uncertainty
/// adds to it.
fn sensor_noise(problem: &Problem<'_>, fit: &Fit) -> Option<f64> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let run = problem.data.runs.first()?;
    let model = problem.model(&unpacked, run.step)?;
    let gain = model.gain(&unpacked.disturbance, run)?;
    let (rate, angle) = model.measured();
    let first = if problem.data.has_rate { rate } else { angle };
    let residuals = &fit.minimum.residuals;
    let variance = residuals.iter().map(|e| e[0] * e[0]).sum::<f64>() / residuals.len().max(1) as f64;
    Some((variance * (1.0 - gain.begin.first()?[first]).max(0.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spectrum_is_the_sum_of_its_gust_and_its_background() {
        let disturbance = Disturbance { intensity: 3.0, slow: 0.8, fast: 6.6, zero: 2.2, angle_noise: 1.0 };
        let Told { log_sigma, log_pole, .. } = Told::of(&disturbance);
        let a = log_pole.exp();
        let gust = 2.0 * a * (2.0 * log_sigma).exp();
        for omega in [0.1_f64, 0.5, 2.0, 10.0] {
            let square = omega * omega;
            let (slow, fast) = (a * a + square, 6.6 * 6.6 + square);
            let whole = gust / slow + (9.0 - gust) * square / (slow * fast);
            assert!((whole / disturbance.spectrum(omega) - 1.0).abs() < 1e-12, "{omega}");
        }
    }

    #[test]
    fn the_order_of_the_poles_does_not_matter() {
        let one = Disturbance { intensity: 3.0, slow: 0.8, fast: 6.6, zero: 2.2, angle_noise: 1.0 };
        let other = Disturbance { slow: 6.6, fast: 0.8, ..one };
        let (one, other) = (Told::of(&one), Told::of(&other));
        assert_eq!((one.log_sigma, one.log_pole), (other.log_sigma, other.log_pole));
    }

    #[test]
    fn a_background_has_little_power_at_low_frequencies() {
        let band = Disturbance { intensity: 1.0, slow: 1.2, fast: 12.0, zero: 0.01, angle_noise: 1.0 };
        assert!(Told::of(&band).log_ratio < BACKGROUND_RATIO.ln());
        assert!(Told::of(&Disturbance { zero: 2.2, ..band }).log_ratio > LEAST_RATIO.ln());
    }
}
