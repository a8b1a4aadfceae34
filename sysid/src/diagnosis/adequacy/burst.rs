//! Windows of time in which the disturbance is stronger than elsewhere.
//!
//! The power P of the disturbance's moment over a window of N samples, of the mean one, is a mixture of χ²(1) whose weights
//! are the eigenvalues of R/N, R the matrix of the moment's autocorrelation in the window: a gamma distribution with the
//! same mean, variance and skewness (Pearson, 1959). The median of w windows, that P is compared with, has a chance of its
//! own (its variance from the density of the normal distribution):
//!
//! ```text
//! c_k = tr (R/N)^k,   l = c₂³/c₃²,   x = 1 + (P − 1) √(2/l) / √(2c₂),   x ~ χ²(l)/l,   against the median: F(l, 2w/(π c₂))
//! ```
//!
//! A burst is physics where it is local: an event or two, without whose windows, which are few, the rest is even, and does not
//! spread so far that the strongest window may belong to it. Otherwise the background is uneven, and that is a fact about the
//! day.

use super::Test;
use super::left::Left;
use super::p_values::least_of;
use super::tails;
use crate::estimate::digits;
use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

/// Length of the windows, s: shorter than a manoeuvre, longer than the memory of turbulence around a hovering vehicle.
const WINDOW_S: f64 = 3.0;
/// The disturbance's estimate is the predictor's own transient for this time after the start of a run, s.
const SETTLED_S: f64 = 4.0;
/// Lags within a window that its power is judged by: a disturbance is correlated over many samples.
const LAGS: usize = 150;
/// Fewest windows that have a median.
const FEWEST: usize = 6;
/// A window whose own p-value is below this belongs to a burst that was found.
const STRONG: f64 = 1e-3;
/// Level at which the rest counts as even.
const EVEN: f64 = 0.01;
/// A burst is an event, or two; what comes and goes more often is the air of the day.
const MOST_SPANS: usize = 2;
/// A burst takes at most this share of the time.
const LONGEST: f64 = 0.2;

/// One window.
#[derive(Clone, Debug)]
pub struct Window {
    /// First and last time, s.
    pub span: [f64; 2],
    /// Relative to the median window.
    pub ratio: f64,
    /// Of this window alone.
    pub p_value: f64,
    power: f64,
}

/// The windows of a recording.
#[derive(Clone, Debug)]
pub struct Windows {
    all: Vec<Window>,
    /// c₂ and c₃.
    cumulants: [f64; 2],
}

/// Tests the disturbance's moment.
pub fn test(left: &Left) -> Test {
    let Some(windows) = Windows::new(&moments(left), left.step) else { return Test::silent("burst", true) };
    let ratio = windows.all.iter().map(|w| w.ratio).fold(0.0, f64::max);
    let strong: Vec<&Window> = windows.all.iter().filter(|w| w.p_value < STRONG).collect();
    let spans = joined(&strong);
    let local =
        strong.is_empty() || spans.len() <= MOST_SPANS && windows.are_local(&strong) && is_even(left, &spans);
    let described: Vec<String> = spans.iter().map(|[a, b]| format!("{a:.0} to {b:.0} s")).collect();
    let closes = strong.iter().map(|w| (w.ratio - 1.0 - w.ratio.ln()) / windows.cumulants[0]).sum();
    let strength = format!("up to {} times the power of the median window", digits(ratio));
    Test {
        name: if local { "burst" } else { "unevenness" },
        statistic: ratio,
        p_value: windows.p_value(),
        closes: if local { closes } else { 0.0 },
        of_physics: local,
        words: if local {
            format!("a moment in a window of time ({}), {strength}", described.join(", "))
        } else {
            format!("a random moment of uneven strength, {strength}")
        },
        windows: spans,
    }
}

/// Times and moments, s and N m, in pieces without a gap.
fn moments(left: &Left) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    for stretch in &left.stretches {
        let begin = stretch.known.first().map_or(0.0, |row| row.time);
        let mut before = false;
        for (k, (row, &counted)) in stretch.known.iter().zip(&stretch.counted).enumerate() {
            // between two readings the moment is known as well
            let counts = (counted || !stretch.is_measured(k)) && row.time > begin + SETTLED_S;
            if counts && !before {
                pieces.push(Vec::new());
            }
            if counts && let Some(piece) = pieces.last_mut() {
                piece.push((row.time, row.disturbance));
            }
            before = counts;
        }
    }
    pieces
}

impl Windows {
    /// `None` where there are too few.
    pub fn new(pieces: &[Vec<(f64, f64)>], step: f64) -> Option<Self> {
        let length = (WINDOW_S / step).max(1.0) as usize;
        let power = |w: &[(f64, f64)]| w.iter().map(|m| m.1 * m.1).sum::<f64>() / w.len() as f64;
        let spans = pieces.iter().flat_map(|piece| piece.chunks_exact(length));
        let window = |w: &[(f64, f64)]| Window {
            span: [w[0].0, w[w.len() - 1].0],
            power: power(w),
            ratio: 0.0,
            p_value: 1.0,
        };
        let mut all = Self { all: spans.map(window).collect(), cumulants: cumulants(pieces, length) };
        all.compare()?;
        Some(all)
    }

    /// Every window with the median one.
    fn compare(&mut self) -> Option<()> {
        let mut powers: Vec<f64> = self.all.iter().map(|w| w.power).collect();
        powers.sort_by(f64::total_cmp);
        let median = 0.5 * (powers.get((powers.len().max(1) - 1) / 2)? + powers.get(powers.len() / 2)?);
        let [c2, c3] = self.cumulants;
        let l = c2.powi(3) / (c3 * c3);
        let stretch = l.sqrt() * c2.sqrt();
        let usual = 1.0 + (ChiSquared::new(l).ok()?.inverse_cdf(0.5) / l - 1.0) * stretch;
        let of_median = self.all.len() as f64 * std::f64::consts::FRAC_2_PI / c2;
        let chance = FisherSnedecor::new(l, of_median).ok()?;
        for window in &mut self.all {
            window.ratio = window.power / median.max(f64::MIN_POSITIVE);
            window.p_value = chance.sf((1.0 + (window.ratio * usual - 1.0) / stretch).max(0.0));
        }
        (self.all.len() >= FEWEST).then_some(())
    }

    /// Of the strongest window, among all.
    pub fn p_value(&self) -> f64 {
        least_of(self.all.iter().map(|w| w.p_value).fold(1.0, f64::min), self.all.len())
    }

    /// Whether `strong` windows are few, and none of the others is strong once they are out.
    fn are_local(&self, strong: &[&Window]) -> bool {
        // the windows beside a strong one hold its beginning and the estimate's transient after it
        let beside = |a: &Window, b: &Window| {
            a.span[0] - b.span[1] < 0.5 * WINDOW_S && b.span[0] - a.span[1] < 0.5 * WINDOW_S
        };
        let mut rest = self.clone();
        rest.all.retain(|w| !strong.iter().any(|s| beside(s, w)));
        let few = strong.len() as f64 <= (LONGEST * self.all.len() as f64).max(1.0);
        few && rest.compare().is_none_or(|()| rest.p_value() > EVEN && rest.are_exceeded_by(strong))
    }

    /// Whether the strongest of `strong` is stronger than windows that spread like these, ln P with Student's t: strength that
    /// wanders a little everywhere is stronger somewhere.
    fn are_exceeded_by(&self, strong: &[&Window]) -> bool {
        let logs: Vec<f64> = self.all.iter().map(|w| w.power.max(f64::MIN_POSITIVE).ln()).collect();
        let n = logs.len() as f64;
        let mean = logs.iter().sum::<f64>() / n;
        let spread = (logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let strongest = strong.iter().map(|w| w.power).fold(f64::MIN_POSITIVE, f64::max);
        let t = (strongest.ln() - mean) / (spread * (1.0 + 1.0 / n).sqrt());
        let chance = StudentsT::new(0.0, 1.0, n - 1.0).map_or(1.0, |student| student.sf(t));
        least_of(chance, logs.len() + strong.len()) < EVEN
    }
}

/// Whether the innovations a window away from `spans` have Gaussian tails.
fn is_even(left: &Left, spans: &[[f64; 2]]) -> bool {
    let outside = |time: f64| !spans.iter().any(|[a, b]| (a - WINDOW_S..=b + WINDOW_S).contains(&time));
    (0..left.channels).all(|channel| {
        let rows = left.rows().zip(&left.errors).filter(|((.., known), _)| outside(known.time));
        let rest: Vec<f64> = rows.map(|(_, e)| e[channel]).collect();
        tails::p_value(tails::kurtosis(&rest), rest.len()) > EVEN / left.channels as f64
    })
}

/// c₂ and c₃ of a window of `length` samples, from the autocorrelation at [`LAGS`] or fewer lags. Estimates of ρ add
/// length/count to c₂ by chance, relatively (their variance is 1 + 2 Σ ρ² over the number of samples: Bartlett, 1946).
fn cumulants(pieces: &[Vec<(f64, f64)>], length: usize) -> [f64; 2] {
    let at_lag = |lag: usize| -> f64 {
        let of_piece =
            |p: &Vec<(f64, f64)>| p.iter().zip(p.iter().skip(lag)).map(|(a, b)| a.1 * b.1).sum::<f64>();
        pieces.iter().map(of_piece).sum()
    };
    let stride = length.div_ceil(LAGS);
    let size = length / stride;
    let variance = at_lag(0).max(f64::MIN_POSITIVE);
    let rho: Vec<f64> = (0..size).map(|i| at_lag(i * stride) / variance).collect();
    let r = DMatrix::from_fn(size, size, |i, j| rho[i.abs_diff(j)] / size as f64);
    let square = &r * &r;
    let count: usize = pieces.iter().map(Vec::len).sum();
    let by_chance = 1.0 + length as f64 / count.max(1) as f64;
    let floor = 1.0 / size as f64;
    let c2 = (square.trace() / by_chance).max(floor);
    // a skewness between that of equal eigenvalues and that of one alone
    [c2, (square.dot(&r) / by_chance).clamp(c2 * c2, c2.powf(1.5))]
}

/// Windows that follow one another as one.
fn joined(windows: &[&Window]) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::new();
    for Window { span, .. } in windows {
        match all.last_mut() {
            Some(last) if span[0] - last[1] < 0.5 * WINDOW_S => last[1] = span[1],
            _ => all.push(*span),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::adequacy::sizes::left;

    /// Noise of mean 0 that a closure without a state can give.
    fn noise(time: f64) -> f64 {
        let x = (time * 12_989.8).sin() * 43_758.5;
        3.4 * (x - x.floor() - 0.5)
    }

    #[test]
    fn a_gust_in_one_window_is_local_and_a_background_of_uneven_strength_is_not() {
        let gust = |_, t: f64| [if (40.0..44.0).contains(&t) { 0.5 } else { 0.0 }, 0.0];
        let burst = test(&left(5, 5000, &gust));
        assert!(burst.name == "burst" && burst.of_physics && burst.p_value < 1e-4, "{burst:?}");
        assert!(
            burst.closes > 10.0 && burst.windows.iter().all(|[a, b]| *b > 38.0 && *a < 48.0),
            "{burst:?}"
        );
        // every other ten seconds, by bursts of half a second
        let wind = |_, t: f64| {
            let strength = if t % 20.0 > 10.0 { 0.6 * noise((2.0 * t).floor()).abs() } else { 0.0 };
            [strength * noise((10.0 * t).floor() + 0.3), 0.0]
        };
        let uneven = test(&left(5, 5000, &wind));
        assert!(uneven.name == "unevenness" && !uneven.of_physics && uneven.closes == 0.0, "{uneven:?}");
        assert!(uneven.p_value < 0.01, "{uneven:?}");
    }
}
