//! Whether what a model leaves is noise: a spectral line in it, bursts of it, tails heavier than Gaussian.

use crate::estimate::digits;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Length of the windows whose power is compared, s.
const WINDOW_S: f64 = 3.0;
/// The disturbance's estimate is the predictor's own transient for this time after the start of a run, s.
const SETTLED_S: f64 = 4.0;
/// Frequencies between which a line is looked for, rad/s.
const LINES: [f64; 2] = [0.8, 40.0];

/// Odds of a burst by chance in one recording.
const ODDS: f64 = 1e-3;
/// Power of a burst relative to the median window below which it may be the background's own unevenness.
const STRONG: f64 = 4.0;
/// Ordinates at least and at most so far away make the noise around a line: a resonance is wider, and stands in it.
const AROUND: [usize; 2] = [3, 20];
/// Height of a spectral line that neither chance nor a resonant background reaches.
const LINE: f64 = 20.0;
/// Kurtosis that innovations of Gaussian noise never reach in a recording of usual length.
const HEAVY: f64 = 3.6;
/// Kurtosis that they seldom reach.
const UNLIKELY: f64 = 3.3;

/// Figures of what a model leaves.
#[derive(Clone, Debug)]
pub struct Goodness {
    /// Kurtosis of the first channel's innovations; 3 for Gaussian noise.
    pub kurtosis: f64,
    /// Highest ordinate of the innovations' periodogram relative to those around it, and its frequency in rad/s.
    pub line: (f64, f64),
    /// Where the disturbance's moment is stronger than elsewhere.
    pub burst: Burst,
}

/// The disturbance's moment in its strongest window.
#[derive(Clone, Debug)]
pub struct Burst {
    /// Its power relative to the median window's.
    pub ratio: f64,
    /// That ratio relative to the largest that chance gives.
    pub score: f64,
    /// Windows of time in which the moment is strong, s.
    pub windows: Vec<[f64; 2]>,
}

/// A departure from noise: what it is, where it is, in words.
#[derive(Clone, Debug)]
pub struct Departure {
    /// As the end of "what the model leaves is ...".
    pub words: String,
    /// Windows of time, s; empty for the whole recording.
    pub windows: Vec<[f64; 2]>,
}

impl Goodness {
    /// What speaks against a random moment that is the same at all times, as a gust is: windows in which it is far stronger
    /// than in others, or errors that noise does not make.
    pub fn unevenness(&self) -> Option<Departure> {
        let uneven = self.burst.ratio > STRONG || self.kurtosis > UNLIKELY;
        uneven.then(|| Departure {
            words: format!(
                "a random moment that comes and goes: up to {} times the power of the median window (kurtosis of what is \
                 left: {}; 3 for noise)",
                digits(self.burst.ratio),
                digits(self.kurtosis)
            ),
            windows: if self.burst.ratio > STRONG { self.burst.windows.clone() } else { Vec::new() },
        })
    }

    /// Whether the tails are heavier than those of noise.
    pub fn heavy_tails(&self) -> bool {
        self.kurtosis > HEAVY
    }

    /// A moment in a window of time or of one frequency, if there is one.
    pub fn departure(&self) -> Option<Departure> {
        let Burst { ratio, score, windows } = &self.burst;
        if *score > 1.0 && *ratio > STRONG {
            let told: Vec<String> = windows.iter().map(|[a, b]| format!("{a:.0} to {b:.0} s")).collect();
            return Some(Departure {
                words: format!(
                    "a moment in a window of time ({}), whose power there is {} times that of the median window",
                    told.join(", "),
                    digits(*ratio)
                ),
                windows: windows.clone(),
            });
        }
        let (height, omega) = self.line;
        (height > LINE).then(|| Departure {
            words: format!(
                "a periodic moment at {} rad/s, {} times above the noise around it",
                digits(omega),
                digits(height)
            ),
            windows: Vec::new(),
        })
    }
}

/// The figures for `fit`.
pub fn goodness(problem: &Problem<'_>, fit: &Fit) -> Option<Goodness> {
    let innovations: Vec<f64> = fit.minimum.residuals.iter().map(|e| e[0]).collect();
    Some(Goodness {
        kurtosis: kurtosis(&innovations),
        line: line_of(&innovations, problem.sizes.step),
        burst: burst(problem, fit)?,
    })
}

fn kurtosis(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let moment = |power: i32| values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / n;
    moment(4) / moment(2).powi(2).max(f64::MIN_POSITIVE)
}

/// Fisher's statistic (Fisher, 1929) over the ordinates between [`LINES`].
fn line_of(innovations: &[f64], step: f64) -> (f64, f64) {
    let resolution = std::f64::consts::TAU / (innovations.len() as f64 * step);
    let count = ((LINES[1].min(0.8 * std::f64::consts::PI / step) - LINES[0]) / resolution).max(1.0) as usize;
    let power = |omega: f64| {
        let rotation = nalgebra::Complex::from_polar(1.0, -omega * step);
        let mut phase = nalgebra::Complex::new(1.0, 0.0);
        let mut sum = nalgebra::Complex::new(0.0, 0.0);
        for e in innovations {
            sum += phase * *e;
            phase *= rotation;
        }
        sum.norm_sqr()
    };
    let ordinates: Vec<(f64, f64)> =
        (0..count).map(|i| LINES[0] + i as f64 * resolution).map(|omega| (power(omega), omega)).collect();
    let height = |i: usize| {
        let around = i.saturating_sub(AROUND[1])..(i + AROUND[1] + 1).min(count);
        let noise: Vec<f64> = around.filter(|j| j.abs_diff(i) >= AROUND[0]).map(|j| ordinates[j].0).collect();
        let mean = noise.iter().sum::<f64>() / noise.len().max(1) as f64;
        (ordinates[i].0 / mean.max(f64::MIN_POSITIVE), ordinates[i].1)
    };
    (0..count).map(height).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0.0))
}

/// Power by window relative to the median window, and relative to the ratio that chance exceeds once in
/// 1/[`ODDS`] recordings: a window holds as many independent values as the moment's own correlation leaves in it.
fn burst(problem: &Problem<'_>, fit: &Fit) -> Option<Burst> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let mut moments: Vec<(f64, f64)> = Vec::new();
    problem.track(
        &unpacked,
        |run, k, point| {
            let data = &problem.data.runs[run];
            if problem.counted[run][k] && data.time(k) > data.start + SETTLED_S {
                moments.push((data.time(k), unpacked.disturbance.moment(&point.x)));
            }
        },
        &mut |_, _| {},
    )?;
    let length = (WINDOW_S / problem.sizes.step).max(1.0) as usize;
    let power = |w: &[(f64, f64)]| w.iter().map(|m| m.1 * m.1).sum::<f64>() / w.len() as f64;
    let windows: Vec<(f64, [f64; 2])> =
        moments.chunks_exact(length).map(|w| (power(w), [w[0].0, w[w.len() - 1].0])).collect();
    let mut powers: Vec<f64> = windows.iter().map(|w| w.0).collect();
    powers.sort_by(f64::total_cmp);
    let median = powers.get(powers.len() / 2)?.max(f64::MIN_POSITIVE);
    let independent = (length as f64 / correlated(&moments, length)).max(1.0);
    let chi = ChiSquared::new(independent).ok()?;
    let limit = chi.inverse_cdf(1.0 - ODDS / windows.len() as f64) / chi.inverse_cdf(0.5);
    let strong: Vec<[f64; 2]> = windows.iter().filter(|w| w.0 > 0.5 * limit * median).map(|w| w.1).collect();
    let highest = powers.last()? / median;
    Some(Burst { ratio: highest, score: highest / limit, windows: joined(&strong) })
}

/// Samples that count as one in the moment's power: 1 + 2 Σ ρ².
fn correlated(moments: &[(f64, f64)], longest: usize) -> f64 {
    let at_lag = |lag: usize| moments.iter().zip(&moments[lag..]).map(|(a, b)| a.1 * b.1).sum::<f64>();
    let variance = at_lag(0).max(f64::MIN_POSITIVE);
    1.0 + 2.0 * (1..longest.min(moments.len())).map(|lag| (at_lag(lag) / variance).powi(2)).sum::<f64>()
}

/// Windows that follow one another as one.
fn joined(windows: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::new();
    for window in windows {
        match all.last_mut() {
            Some(last) if window[0] - last[1] < 0.5 * WINDOW_S => last[1] = window[1],
            _ => all.push(*window),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Sums of twelve uniform numbers: kurtosis 3 − 1.2/12.
    fn noise(count: usize) -> Vec<f64> {
        let mut random = Pcg64::seed_from_u64(3);
        (0..count).map(|_| (0..12).map(|_| random.random::<f64>() - 0.5).sum()).collect()
    }

    #[test]
    fn outliers_show_in_the_kurtosis_and_noise_does_not() {
        let mut values = noise(4000);
        assert!((kurtosis(&values) - 2.9).abs() < 0.2, "{}", kurtosis(&values));
        values.iter_mut().step_by(100).for_each(|v| *v *= 6.0);
        assert!(kurtosis(&values) > HEAVY);
    }

    #[test]
    fn a_moment_that_comes_and_goes_is_no_gust() {
        let even = Goodness {
            kurtosis: 3.0,
            line: (6.0, 4.0),
            burst: Burst { ratio: 2.5, score: 0.6, windows: vec![[3.0, 6.0]] },
        };
        assert!(even.unevenness().is_none() && even.departure().is_none());
        let burst = Burst { ratio: 14.0, ..even.burst.clone() };
        let uneven = Goodness { burst, ..even.clone() }.unevenness().unwrap();
        assert_eq!(uneven.windows, [[3.0, 6.0]]);
        assert!(Goodness { kurtosis: 3.5, ..even }.unevenness().unwrap().windows.is_empty());
    }

    #[test]
    fn a_line_is_found_at_its_frequency_and_noise_has_none() {
        let step = 0.02;
        let mut values = noise(4000);
        assert!(line_of(&values, step).0 < 13.0);
        for (k, v) in values.iter_mut().enumerate() {
            *v += 0.3 * (7.0 * step * k as f64).sin();
        }
        let (height, omega) = line_of(&values, step);
        assert!(height > LINE && (omega - 7.0).abs() < 0.1, "{height} {omega}");
    }

    #[test]
    fn independent_values_count_one_each_and_windows_that_touch_are_one() {
        let moments: Vec<(f64, f64)> =
            noise(4000).into_iter().enumerate().map(|(k, m)| (k as f64, m)).collect();
        assert!((correlated(&moments, 10) - 1.0).abs() < 0.05);
        assert_eq!(joined(&[[0.0, 3.0], [3.02, 6.0], [9.0, 12.0]]), vec![[0.0, 6.0], [9.0, 12.0]]);
    }
}
