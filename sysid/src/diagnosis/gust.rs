//! A gust: a disturbance that is more than the ordinary background.
//!
//! Background is a band-passed moment: it has no power at rest. A gust, T ẇ = −w + noise, has most of its power at low
//! frequencies. Both are fitted side by side, and it is a gust if both moments together have clearly more power at low frequencies
//! than backgrounds have, and the likelihood needs it beside a band-passed one, or there is more than any background has. A
//! background of another colour, or of a strength that wanders, is a fact about the day, and no gust.

use super::excerpt::excerpt;
use super::posterior::chance;
use super::prior::{FURTHER_TERM, NAMED};
use crate::catalogue::CATALOGUE;
use crate::catalogue::command_tells::CommandTells;
use crate::catalogue::roll_off::RollOff;
use crate::catalogue::slow_moment::SlowMoment;
use crate::dataset::Amplitudes;
use crate::estimate::Estimate;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{FINISH, Fit};
use crate::likelihood::problem::Problem;
use crate::likelihood::sensor_noise::sensor_noise;
use crate::model::effect::Effect;
use crate::model::noise::{Disturbance, Third};
use crate::optim::levenberg_marquardt::{Coordinate, minimize};
use rayon::prelude::*;

/// Bands that tell a gust from the background, rad/s.
const LOW_BAND: [f64; 2] = [0.3, 0.8];
const HIGH_BAND: [f64; 2] = [3.0, 6.0];
/// Power in the low band relative to the high band from which on a disturbance is a gust, whatever its poles. Band-passed
/// backgrounds lie below 0.35, gusts above 2.
const LEAST_RATIO: f64 = 0.7;
/// Standard errors by which the logarithm of the ratio must exceed that of a background. What the likelihood needs and has no
/// more slow power is air of uneven strength, or another colour.
const LEAST_SCORE: f64 = 2.0;
/// Largest ratio that an ordinary background has.
const BACKGROUND_RATIO: f64 = 0.35;
/// A gust whose ln σ is known no better than this is not told from the background's own spectrum.
const WIDEST: f64 = 1.0;
/// A moment slower than this (twice the range of the catalogue), or than a tenth of the data, is a drift of which no spectrum
/// is seen.
const LONGEST: f64 = 6.0;
const LONGEST_SHARE: f64 = 0.1;
/// A moment faster than this is the background's own fall towards high frequencies, s.
const SHORTEST: f64 = 0.1;
/// In less than two periods of the slowest frequency that is looked at no spectrum is seen, s.
const LEAST_DATA: f64 = 4.0 * std::f64::consts::PI / LOW_BAND[0];
/// A gust weaker than this share of the control moment is an ordinary background.
const MILD: f64 = 0.05;
/// A gust fitted beside a background may come out stronger than both were as one, by this factor at the most.
const OVER: f64 = 3.0;
/// Zero of a background without slow parts, rad/s, and the width of the prior that holds it there.
const NO_SLOW_PART: (f64, f64) = (0.03, 0.01);
/// A zero below this share of the background's frequency, and a ratio below this, are those of a background.
const WORTH_A_LOOK: (f64, f64) = (0.1, 0.5);
/// Time constants of a third pole of the background to start from, s.
const ROLL_OFFS: [f64; 2] = [0.1, 0.3];
/// Time constants to start from, s.
const TIMES: [f64; 2] = [0.4, 2.0];

/// A disturbance that is a finding.
pub struct Gust {
    /// σ in N m and T in s.
    pub parameters: Vec<Estimate>,
    /// Gain of the log posterior over a background without slow parts, or what the low frequencies alone amount to.
    pub log_evidence: f64,
    /// Odds of as much by chance if the disturbance were an ordinary background.
    pub p_value: f64,
}

/// Whether a disturbance is a moment so slow that the data see no spectrum of it.
pub fn is_drift(third: &Third, sizes: &Amplitudes) -> bool {
    matches!(third, Third::Gust(gust) if gust.time_constant > slowest(sizes))
}

/// Time constant beyond which a slow moment is a drift, s.
fn slowest(sizes: &Amplitudes) -> f64 {
    LONGEST.min(LONGEST_SHARE * sizes.duration)
}

/// Whether the disturbance that `fit` found is a gust.
///
/// A background that falls off with a third pole is the other explanation of what two poles leave: the gust must be better
/// than either.
pub fn gust(problem: &Problem<'_>, fit: &Fit) -> Option<Gust> {
    let disturbance = problem.unpack(&fit.effects, &fit.minimum.values).disturbance;
    let fit = &without_background(problem, fit);
    let (least_zero, least_ratio) = WORTH_A_LOOK;
    let like_background = !matches!(disturbance.third, Some(Third::Gust(_)))
        && disturbance.zero < least_zero * disturbance.frequency
        && log_ratio(&disturbance) < least_ratio.ln();
    if like_background || problem.sizes.duration < LEAST_DATA {
        return None;
    }
    // No part of a disturbance is stronger than the whole.
    if OVER * strength(&disturbance) * sensor_noise(problem, fit)? < MILD * problem.sizes.moment {
        return None;
    }
    let alone = band_passes(problem, fit);
    let without = fit;
    let fit = with_gust(problem, without, &alone, &disturbance)?;
    let own = fit.own_range(problem, fit.effects.len() - 1);
    let [relative, time] = [fit.minimum.values[own.start], fit.minimum.values[own.start + 1]];
    let sigma = relative * sensor_noise(problem, &fit)?;
    let slow = (SHORTEST..slowest(&problem.sizes)).contains(&time);
    if !slow || sigma < MILD * problem.sizes.moment {
        return None;
    }
    let information = Information::with(problem, &fit, band_passed(problem, &fit.effects), &[])?;
    let deviations = information.deviations(&fit.minimum.values);
    let deviation = |i: usize| deviations[i] / fit.minimum.values[i];
    let (log_sigma, log_time) = (deviation(own.start), deviation(own.start + 1));
    let ratio = log_ratio(&problem.unpack(&fit.effects, &fit.minimum.values).disturbance);
    if log_sigma > WIDEST || ratio < BACKGROUND_RATIO.ln() {
        return None;
    }

    let score = (ratio - BACKGROUND_RATIO.ln()) / error_of_ratio(problem, &fit, &information);
    if score < LEAST_SCORE {
        return None;
    }
    let background = without_gust(problem, without, &alone)?;
    let gain = (background.criterion() - fit.criterion()) / information.divisor(own.clone());
    let penalty = own.len() as f64 * (problem.count() as f64).ln();
    let by_likelihood = 0.5 * (gain - penalty) + (FURTHER_TERM * NAMED / CATALOGUE.len() as f64).ln();
    let by_ratio = ratio > LEAST_RATIO.ln();
    let (log_evidence, p_value) = if by_likelihood > 0.0 {
        (by_likelihood, chance(gain, own.len()))
    } else if by_ratio {
        let by_chance = 0.5 * statrs::function::erf::erfc(score / std::f64::consts::SQRT_2);
        (0.5 * score * score, by_chance)
    } else {
        return None;
    };
    let estimate = |name: &str, unit: &str, value: f64, error: f64, bounds: [f64; 2]| {
        let mut estimate = Estimate::new(name, unit, value, value * error, bounds);
        let times = |sign: f64| (value * (sign * 1.96 * error).exp()).clamp(bounds[0], bounds[1]);
        estimate.ci95 = [times(-1.0), times(1.0)];
        estimate
    };
    let largest = problem.sizes.moment.max(sigma);
    Some(Gust {
        parameters: vec![
            estimate("sigma", "N m", sigma, log_sigma, [0.0, largest]),
            estimate("T", "s", time, log_time, [problem.sizes.step, problem.sizes.duration]),
        ],
        log_evidence,
        p_value,
    })
}

/// The fit's terms and values without the third pole of the background; its criterion is not that of these values.
fn without_background(problem: &Problem<'_>, fit: &Fit) -> Fit {
    let mut fit = fit.clone();
    let is_third =
        |effect: &&'static dyn Effect| effect.is_background() && effect.about().id != CommandTells.about().id;
    while let Some(i) = fit.effects.iter().position(is_third) {
        fit.minimum.values.drain(fit.own_range(problem, i));
        fit.effects.remove(i);
    }
    fit
}

/// The values of `fit` with backgrounds that have no slow part: its own without it, and one that resonates.
fn band_passes(problem: &Problem<'_>, fit: &Fit) -> [Vec<f64>; 2] {
    let noise = problem.noise_range();
    let mut own = fit.minimum.values.clone();
    own[noise.start + 3] = NO_SLOW_PART.0;
    let mut resonant = own.clone();
    resonant[noise][1..4].copy_from_slice(&problem.resonance());
    [own, resonant]
}

/// `fit` with a gust beside a background without a slow part, from each of `alone`.
fn with_gust(problem: &Problem<'_>, fit: &Fit, alone: &[Vec<f64>], disturbance: &Disturbance) -> Option<Fit> {
    let slow = disturbance.spectrum(LOW_BAND[0]).sqrt();
    let beside =
        |start: &Vec<f64>| TIMES.map(|time| [&start[..], &[slow / (2.0 * time).sqrt(), time]].concat());
    let starts: Vec<Vec<f64>> = alone.iter().flat_map(beside).collect();
    lowest_of_band_passed(problem, &[&fit.effects[..], &[&SlowMoment]].concat(), &starts)
}

/// `fit` with a background of two poles or of three that has no slow part, whichever is more likely, from each of `alone`.
fn without_gust(problem: &Problem<'_>, fit: &Fit, alone: &[Vec<f64>]) -> Option<Fit> {
    let rolled: Vec<Vec<f64>> =
        alone.iter().flat_map(|start| ROLL_OFFS.map(|time| [&start[..], &[time]].concat())).collect();
    let (two, three) = rayon::join(
        || lowest_of_band_passed(problem, &fit.effects, alone),
        || lowest_of_band_passed(problem, &[&fit.effects[..], &[&RollOff]].concat(), &rolled),
    );
    let better = |a: Fit, b: Fit| if b.criterion() < a.criterion() { b } else { a };
    match (two, three) {
        (Some(two), Some(three)) => Some(better(two, three)),
        (two, three) => two.or(three),
    }
}

/// The unknowns, the background's zero held at that of a band pass.
fn band_passed(problem: &Problem<'_>, effects: &[&'static dyn Effect]) -> Vec<Coordinate> {
    let mut coordinates = problem.coordinates(effects);
    coordinates[problem.noise_range().start + 3].prior = Some(NO_SLOW_PART);
    coordinates
}

/// The lowest of the fits from `starts`; which start leads there, an excerpt of long data says.
fn lowest_of_band_passed(
    problem: &Problem<'_>,
    effects: &[&'static dyn Effect],
    starts: &[Vec<f64>],
) -> Option<Fit> {
    if let Some(excerpt) = excerpt(problem.data) {
        let lowest = lowest_of(&problem.in_part(&excerpt), effects, starts)?;
        return lowest_of(problem, effects, &[lowest.minimum.values]);
    }
    lowest_of(problem, effects, starts)
}

fn lowest_of(problem: &Problem<'_>, effects: &[&'static dyn Effect], starts: &[Vec<f64>]) -> Option<Fit> {
    let coordinates = band_passed(problem, effects);
    let residuals = problem.prediction_errors(effects);
    let fit = |start: &Vec<f64>| {
        let minimum = minimize(&residuals, problem.channels(), &coordinates, start, FINISH)?;
        Some(Fit { effects: effects.to_vec(), minimum })
    };
    let fits = starts.par_iter().filter_map(fit);
    fits.min_by(|a, b| a.criterion().total_cmp(&b.criterion()))
}

/// ln of the power in the low band relative to the high band.
fn log_ratio(disturbance: &Disturbance) -> f64 {
    (mean_power(disturbance, LOW_BAND) / mean_power(disturbance, HIGH_BAND)).ln()
}

fn mean_power(disturbance: &Disturbance, band: [f64; 2]) -> f64 {
    const POINTS: usize = 16;
    let at = |i: usize| band[0] + (band[1] - band[0]) * (i as f64 + 0.5) / POINTS as f64;
    (0..POINTS).map(|i| disturbance.spectrum(at(i))).sum::<f64>() / POINTS as f64
}

/// Standard deviation of the disturbance: √(∫ S dω / π), by the logarithm of ω.
fn strength(disturbance: &Disturbance) -> f64 {
    const PER_OCTAVE: i32 = 8;
    let width = std::f64::consts::LN_2 / f64::from(PER_OCTAVE);
    let octaves = -7 * PER_OCTAVE..=10 * PER_OCTAVE;
    let power = octaves.map(|i| {
        let omega = (f64::from(i) * width).exp();
        omega * disturbance.spectrum(omega)
    });
    (power.sum::<f64>() * width / std::f64::consts::PI).sqrt()
}

/// Standard error of ln of the ratio.
fn error_of_ratio(problem: &Problem<'_>, fit: &Fit, information: &Information) -> f64 {
    let values = &fit.minimum.values;
    let described = |v: &[f64]| log_ratio(&problem.unpack(&fit.effects, v).disturbance);
    let at = described(values);
    let slope = |i: usize| {
        let h = 1e-4 * values[i];
        let mut moved = values.clone();
        moved[i] += h;
        if h == 0.0 { 0.0 } else { (described(&moved) - at) / h }
    };
    let gradient: Vec<f64> = (0..values.len()).map(slope).collect();
    information.deviation_along(values, &gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::noise;

    const BAND: Disturbance = Disturbance {
        intensity: 1.0,
        frequency: 3.8,
        damping: 1.7,
        zero: 0.01,
        angle_noise: 1.0,
        third: None,
        corrects: None,
    };

    #[test]
    fn a_background_has_little_power_at_low_frequencies() {
        assert!(log_ratio(&BAND) < BACKGROUND_RATIO.ln());
        assert!(log_ratio(&Disturbance { zero: 2.2, ..BAND }) > LEAST_RATIO.ln());
        assert!(log_ratio(&Disturbance { damping: 0.4, ..BAND }) < 0.05_f64.ln());
    }

    #[test]
    fn the_strength_of_a_disturbance_is_its_deviation() {
        let gust = noise::Gust { sigma: 0.3, time_constant: 0.8 };
        let squared = |third| strength(&Disturbance { third, ..BAND }).powi(2);
        let added = squared(Some(Third::Gust(gust))) - squared(None);
        assert!((added / 0.09 - 1.0).abs() < 0.02, "{added}");
    }

    #[test]
    fn a_gust_adds_the_spectrum_of_its_variance() {
        let gust = noise::Gust { sigma: 0.3, time_constant: 0.8 };
        let added = |omega: f64| {
            Disturbance { third: Some(Third::Gust(gust)), ..BAND }.spectrum(omega) - BAND.spectrum(omega)
        };
        let power: f64 = (0..200_000).map(|i| added(0.01 * (f64::from(i) + 0.5)) * 0.01).sum();
        assert!((power / std::f64::consts::PI - 0.09).abs() < 1e-4, "{power}");
    }
}
