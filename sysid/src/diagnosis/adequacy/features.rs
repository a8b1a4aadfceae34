//! Features of what was known before, passed through the predictor: what a moment, or an addition to the measurement, that
//! depends on them would leave.
//!
//! ```text
//! f(s) = cos(ωᵀ s + φ),   ω ~ N(0, I),   s = (u/σ_u, q/σ_q, θ/σ_θ)
//! ```
//!
//! span the smooth functions of s (Rahimi and Recht, 2007). Of time: cos(π j t/T) alone, and times u and q.

use super::Test;
use super::left::{Known, Left, white};
use super::score::{Outcome, Sums};
use crate::estimate::digits;
use crate::model::plant::STATES;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::{PI, TAU};

/// Features of the signals.
pub const COUNT: usize = 150;
/// Cosines of time: a period of a tenth of the recording is the shortest change that is no motion.
pub const HARMONICS: usize = 20;
const SEED: u64 = 1;
/// Rows at which the fitted function is looked at to tell what it depends on.
const LOOKED_AT: usize = 200;
/// Half the distance over which its slope is taken, in standard deviations.
const REACH: f64 = 0.1;
/// Something is named where the function depends on it at least so much as on what it depends on most.
const NAMED: f64 = 0.5;
/// A function whose mean makes up this share of its square is a constant.
const CONSTANT: f64 = 0.8;

/// Where an addition enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// As a moment.
    Moment,
    /// On the first measured channel.
    Measurement,
}

/// cos(ωᵀ s + φ).
#[derive(Clone, Debug)]
pub struct Wave {
    omega: [f64; 3],
    phase: f64,
}

impl Wave {
    /// `count` of them, always the same.
    pub fn draw(count: usize) -> Vec<Self> {
        let mut random = Pcg64::seed_from_u64(SEED);
        let mut uniform = || random.random::<f64>();
        // Box and Muller, 1958
        let mut normal = || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos();
        let omegas: Vec<[f64; 3]> = (0..count).map(|_| core::array::from_fn(|_| normal())).collect();
        let phases: Vec<f64> = (0..count).map(|_| TAU * random.random::<f64>()).collect();
        omegas.into_iter().zip(phases).map(|(omega, phase)| Self { omega, phase }).collect()
    }

    /// At the signals `s`.
    pub fn at(&self, s: &[f64; 3]) -> f64 {
        let [a, b, c] = self.omega;
        (a * s[0] + b * s[1] + c * s[2] + self.phase).cos()
    }
}

/// Can a moment f(u, q, θ) explain what is left?
pub fn moment(left: &Left) -> Test {
    of_signals(left, "moment", Entry::Moment, "a moment", "N m")
}

/// Can an addition f(u, q, θ) to the measurement?
pub fn sensor(left: &Left) -> Test {
    of_signals(left, "sensor", Entry::Measurement, "an addition to the measurement", "rad/s")
}

fn of_signals(left: &Left, name: &'static str, entry: Entry, what: &str, unit: &str) -> Test {
    let waves = Wave::draw(COUNT);
    let Some(outcome) = of_waves(left, entry, &waves) else { return Test::silent(name, true) };
    let (size, on) = described(left, &waves, &outcome.coefficients);
    let how = if on.is_empty() { "that is constant".to_owned() } else { format!("that depends on {on}") };
    test(name, &outcome, format!("{what} {how}, about {} {unit}", digits(size)))
}

/// The score test for these waves.
pub fn of_waves(left: &Left, entry: Entry, waves: &[Wave]) -> Option<Outcome> {
    outcome(left, entry, waves.len(), &|known, out| {
        for (out, wave) in out.iter_mut().zip(waves) {
            *out = wave.at(&known.signals);
        }
    })
}

/// Can a moment, a gain or a damping that changes over time?
pub fn time(left: &Left) -> Test {
    let Some(outcome) = of_time(left, HARMONICS) else { return Test::silent("time", true) };
    let size = |of: usize| {
        (0.5 * outcome.coefficients.iter().skip(of).step_by(3).map(|c| c * c).sum::<f64>()).sqrt()
    };
    let sizes = [size(0), size(1), size(2)];
    let largest = sizes.into_iter().fold(0.0, f64::max);
    let described = ["a moment", "a gain of the input", "a damping"].into_iter().zip(sizes);
    let names: Vec<&str> = described.filter(|(_, s)| *s >= NAMED * largest).map(|(name, _)| name).collect();
    let change = if names.len() > 1 { "change" } else { "changes" };
    let words = format!("{} that {change} over time, about {} N m", names.join(" and "), digits(largest));
    test("time", &outcome, words)
}

/// The score test for so many cosines of time, alone and times u and q.
pub fn of_time(left: &Left, harmonics: usize) -> Option<Outcome> {
    outcome(left, Entry::Moment, 3 * harmonics, &|known, out| {
        let [u, q, _] = known.signals;
        for (j, three) in out.chunks_exact_mut(3).enumerate() {
            let wave = (PI * (j + 1) as f64 * known.time / left.duration).cos();
            three.copy_from_slice(&[wave, wave * u, wave * q]);
        }
    })
}

fn test(name: &'static str, outcome: &Outcome, words: String) -> Test {
    Test {
        name,
        statistic: outcome.statistic,
        p_value: outcome.p_value,
        closes: outcome.closes,
        of_physics: true,
        windows: Vec::new(),
        words,
    }
}

/// The score test for `count` features that `fill` makes of what was known after a row; they act from there to the next
/// row as a moment, or on the next row's measurement.
fn outcome(left: &Left, entry: Entry, count: usize, fill: &dyn Fn(&Known, &mut [f64])) -> Option<Outcome> {
    let mut sums = Sums::new(count, left.slopes.len());
    let blocks = left.blocks();
    let mut index = 0;
    let mut f = vec![0.0; count];
    let mut shown = vec![vec![0.0; count]; 2];
    for stretch in &left.stretches {
        let filter = &stretch.filter;
        let drive = match entry {
            Entry::Moment => filter.per_moment,
            Entry::Measurement => -*filter.per_addition.first()?,
        };
        // one row of the state for each of the filter's
        let mut x = vec![vec![0.0; count]; STATES];
        let mut next = x.clone();
        index += usize::from(stretch.counted.first() == Some(&true));
        for k in 1..stretch.known.len() {
            fill(&stretch.known[k - 1], &mut f);
            if entry == Entry::Moment {
                filter.advance(stretch.is_measured(k - 1), (&drive, &f), &mut x, &mut next);
            }
            if stretch.counted[k] {
                for (shown, &state) in shown.iter_mut().zip(&filter.measured) {
                    shown.copy_from_slice(&x[state]);
                }
                if entry == Entry::Measurement {
                    shown[0].iter_mut().zip(&f).for_each(|(z, f)| *z += f);
                }
                whiten(&left.whitening, &mut shown);
                for (channel, z) in shown.iter().enumerate().take(left.channels) {
                    let slopes = left.slopes.iter().map(|column| column[index][channel]);
                    sums.add(blocks[index], z, slopes, left.errors[index][channel]);
                }
            }
            if entry == Entry::Measurement {
                let measured = stretch.is_measured(k);
                if !measured {
                    f.fill(0.0);
                }
                filter.advance(measured, (&drive, &f), &mut x, &mut next);
            }
            index += usize::from(stretch.counted[k]);
        }
    }
    sums.outcome()
}

/// Each feature's response, made white.
pub fn whiten(whitening: &[f64; 3], shown: &mut [Vec<f64>]) {
    if let [first, second] = shown {
        for (a, b) in first.iter_mut().zip(second) {
            [*a, *b] = white(whitening, &[*a, *b]);
        }
    }
}

/// Root mean square of the function with these coefficients, less what is linear in u and q (the model has that), and the
/// signals that it depends on.
fn described(left: &Left, waves: &[Wave], coefficients: &[f64]) -> (f64, String) {
    let value = |s: &[f64; 3]| waves.iter().zip(coefficients).map(|(w, c)| c * w.at(s)).sum::<f64>();
    let every = left.errors.len().div_ceil(LOOKED_AT).max(1);
    let rows: Vec<[f64; 3]> = left.rows().step_by(every).map(|(_, _, known)| known.signals).collect();
    let values = DVector::from_iterator(rows.len(), rows.iter().map(&value));
    let linear = DMatrix::from_fn(rows.len(), 3, |k, i| if i == 2 { 1.0 } else { rows[k][i] });
    let mut normal = linear.tr_mul(&linear);
    for i in 0..3 {
        normal[(i, i)] += 1e-9 * rows.len() as f64;
    }
    let Some(known) = normal.cholesky().map(|c| c.solve(&linear.tr_mul(&values))) else {
        return (0.0, String::new());
    };
    let count = rows.len().max(1) as f64;
    let changing = (&values - &linear * &known).norm_squared() / count;
    let constant = known[2] * known[2];
    let size = (changing + constant).sqrt();
    if constant > CONSTANT * (changing + constant) {
        return (size, String::new());
    }
    let steepness: Vec<f64> = (0..3)
        .map(|i| {
            let slope = |s: &[f64; 3]| {
                let moved = |by: f64| core::array::from_fn(|j| if i == j { s[j] + by } else { s[j] });
                let known = if i < 2 { known[i] } else { 0.0 };
                (value(&moved(REACH)) - value(&moved(-REACH))) / (2.0 * REACH) - known
            };
            (rows.iter().map(|s| slope(s).powi(2)).sum::<f64>() / count).sqrt()
        })
        .collect();
    let most = steepness.iter().copied().fold(0.0, f64::max);
    let names = ["u", "q", "theta"].into_iter().zip(&steepness).filter(|(_, s)| **s >= NAMED * most);
    (size, names.map(|(name, _)| name).collect::<Vec<_>>().join(" and "))
}
