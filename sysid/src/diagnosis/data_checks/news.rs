//! What is new in a section's input against what could not be known of its motion.
//!
//! Innovations e(k) of the fitted model are what could not be known before row k. An input that was decided beforehand
//! knows nothing of them; one that a controller, an operator or a limit has changed does:
//!
//! ```text
//! w(k) = u(k) − Σ_{i=1..p} a_i u(k−i) − a_0            what is new in the input (least squares)
//! z(l) = Σ_k e(k) w(k+l) / √(Σ_k e(k)² w(k+l)²),       l = 1..L;  Σ_l z(l)² ~ χ²_L without feedback
//! ```
//!
//! With u itself in place of w, anything of the input that the model leaves in e would come back by the input's own
//! correlation; and neither that nor a delay in the loop puts a *later* w into e. The switches of an excitation outweigh
//! by far what a controller adds to it, so the sums are taken twice, over all rows and (regression included) without those
//! of a large w, and once more over all rows up to a second ahead, more coarsely; the clearest counts, its odds multiplied,
//! the [dwells](super::dwells) of a switching input among them. A controller that is faster than the log answers in the row
//! of the motion, before which no input can have acted that is new there: l = 0 is a test of its own, but where the rows are
//! averages, in which the input acts. Outputs that were interpolated between uneven stamps hold what came up to a row later:
//! there the inputs from two rows on count. An input of two levels is new by where it may change at all: by the clock of a random
//! sequence, or its least dwell, the past of the switches tells more of the next than any regression, and so does a model's error
//! that begins at each of them. There w(k) = u(k) − ū(level, rows since its last switch). What is new in a few places alone, as a ramp
//! at the start and a step, is not asked: a model that lacks something errs alike all along a ramp.
//!
//! Sources: Haugh, JASA 71, 1976; White's (1980) variance, for errors of uneven size.

use super::dwells::{Dwells, Told};
use crate::dataset::{has_two_levels, median_size};
use crate::linalg::least_squares::least_squares;
use crate::model::pitch::Output;
use nalgebra::DVector;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::collections::HashMap;

/// Memory of the input's own prediction, s.
const MEMORY_S: f64 = 0.8;
const MOST_TAPS: usize = 40;
/// What is new beyond this many standard deviations (by the median) is a switch.
pub(super) const SWITCH: f64 = 4.0;
/// Regressions in which switches are left out.
pub(super) const TRIMMED: usize = 2;
/// News, relative to the input's size, that is the rounding of the numbers.
pub(super) const ROUNDING: f64 = 1e-4;
/// Later inputs that are looked at, s: each of the next ones, and one in a few up to where a person reacts.
const LATER_S: [f64; 2] = [0.1, 1.0];
/// Most later inputs that are looked at.
const MOST_LATER: usize = 10;
/// Fewest samples that are tested.
const FEWEST: usize = 200;
/// Stretches that a section is cut into, and how many of them at least the news must come from.
const STRETCHES: usize = 20;
pub(super) const FEWEST_STRETCHES: f64 = 5.0;

/// One section's input and innovations.
pub struct Section<'a> {
    pub u: &'a [f64],
    pub e: &'a [Output],
    pub supervised: &'a [bool],
    pub step: f64,
    pub averaged: usize,
    /// Whether the outputs were interpolated between the stamps.
    pub interpolated: bool,
    pub dwells: Option<Dwells>,
}

/// The outcome for one section.
pub struct Test {
    pub p_value: f64,
    /// Share of the variance of what is new in the input that the motion explains, beyond what chance gives.
    pub share: f64,
    pub kind: Kind,
}

/// What was asked.
pub enum Kind {
    /// What is new in a logged row's motion against what is new in the input `later` of the rows in which it may change, `every` so
    /// many.
    OwnRows { later: usize, every: usize },
    /// The innovations against what is new in the input of the same row.
    AtOnce,
    /// The innovations against what is new in the input so many s later.
    Later(f64),
    /// What the input did not make of the motion at a switch against the time to the next.
    Dwell,
}

impl Test {
    /// The clearest of several, its odds multiplied.
    pub fn clearest(tests: Vec<Self>) -> Option<Self> {
        let odds = tests.len() as f64;
        let clearest = tests.into_iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
        Some(Self { p_value: (odds * clearest.p_value).min(1.0), ..clearest })
    }

    pub fn told(&self) -> String {
        let share = 100.0 * self.share;
        match self.kind {
            Kind::OwnRows { later, every } => {
                let rows = match every {
                    1 => "in the rows as logged".into(),
                    _ => format!("of the rows as logged in which the input may change, one in {every},"),
                };
                let of = match later {
                    0 => "of the same row".into(),
                    1 => "1 row later".into(),
                    _ => format!("{later} rows later"),
                };
                format!(
                    "{rows} what is new in the motion explains {share:.1} % of what is new in the input {of}, by rank, and against the \
                     input's effect"
                )
            }
            Kind::AtOnce => {
                format!("the innovations explain {share:.1} % of what is new in the input of the same row")
            }
            Kind::Later(reach) => format!(
                "the innovations explain {share:.1} % of what is new in the input within the next {reach:.2} s"
            ),
            Kind::Dwell => format!(
                "what else moves the craft at a switch explains {share:.0} % of the time to the next that the switches before do not"
            ),
        }
    }
}

impl Section<'_> {
    /// Tests innovations against what is new in later inputs, and says whether anything is new in it between its switches; `None`
    /// where too little is there to be tested.
    pub fn test(&self) -> Option<(Test, bool)> {
        let taps = ((MEMORY_S / self.step) as usize).clamp(2, MOST_TAPS).min(self.u.len() / 8);
        let all: Vec<bool> = (0..self.u.len()).map(|k| k >= taps && !self.supervised[k]).collect();
        let switching = by_age(self.u, &all);
        let asked_between = switching.is_none();
        let whole = switching.or_else(|| whitened(self.u, taps, &all))?;
        if typical_size(&whole, &all) < ROUNDING * typical_size(self.u, &all) {
            return None;
        }
        let channels = uncorrelated(self.e);
        let [near, far] = LATER_S.map(|reach| self.later(reach));
        let sums = |lags: &[usize], new: &[f64], counts: &[bool]| self.sums(&channels, new, counts, lags);
        let between = asked_between.then(|| self.between_switches(taps, whole.clone(), &all)).flatten();
        let (between, whole) = (between.as_ref(), (&whole, &all));
        let in_its_row = |(new, counts): (&Vec<f64>, &Vec<bool>)| {
            (self.averaged == 1 && !self.interpolated).then(|| sums(&[0], new, counts)).flatten()
        };
        let by_the_rest = self.dwells.as_ref().and_then(|dwells| dwells.by_the_rest.as_ref());
        let tests = [
            in_its_row(whole),
            sums(&near, whole.0, whole.1),
            sums(&far, whole.0, whole.1),
            between.and_then(|(new, counts)| in_its_row((new, counts))),
            between.and_then(|(new, counts)| sums(&near, new, counts)),
            by_the_rest.map(|&Told { p_value, share }| Test { p_value, share, kind: Kind::Dwell }),
        ];
        let tests: Vec<Test> = tests.into_iter().flatten().collect();
        Some((Test::clearest(tests)?, between.is_some()))
    }

    /// What is new in the input between its switches, and the rows that are no switches; `None` where nothing is.
    fn between_switches(&self, taps: usize, whole: Vec<f64>, all: &[bool]) -> Option<(Vec<f64>, Vec<bool>)> {
        let (mut new, mut counts) = (whole, all.to_vec());
        for _ in 0..TRIMMED {
            let limit = SWITCH * median_size(&new, &counts);
            counts = (0..new.len()).map(|k| all[k] && new[k].abs() <= limit).collect();
            new = whitened(self.u, taps, &counts)?;
        }
        (median_size(&new, &counts) > ROUNDING * typical_size(self.u, all)).then_some((new, counts))
    }

    /// The lags of inputs up to `reach` s later.
    fn later(&self, reach: f64) -> Vec<usize> {
        let last = ((reach / self.step).round() as usize).max(3);
        (if self.interpolated { 2 } else { 1 }..=last).step_by(last.div_ceil(MOST_LATER)).collect()
    }

    /// Of innovations and what is new in the input `lags` rows later.
    fn sums(&self, channels: &[Vec<f64>], new: &[f64], counts: &[bool], lags: &[usize]) -> Option<Test> {
        if news_from(new, counts) < FEWEST_STRETCHES {
            return None;
        }
        let (mut sum, mut share, mut fewest) = (0.0, 0.0, usize::MAX);
        for &lag in lags {
            // Rows without the supervisor from the innovation to the input that is new.
            let rows: Vec<usize> = (lag..new.len())
                .filter(|&k| counts[k] && !self.supervised[k - lag..=k].contains(&true))
                .collect();
            fewest = fewest.min(rows.len());
            for e in channels {
                let pairs = || rows.iter().map(|&k| (e[k - lag], new[k]));
                let product: f64 = pairs().map(|(e, w)| e * w).sum();
                let spread: f64 = pairs().map(|(e, w)| e * e * w * w).sum();
                let powers = pairs().fold((0.0, 0.0), |(a, b), (e, w)| (a + e * e, b + w * w));
                if spread > 0.0 {
                    sum += product * product / spread;
                    share += product * product / (powers.0 * powers.1) - 1.0 / rows.len() as f64;
                }
            }
        }
        let freedom = (channels.len() * lags.len()) as f64;
        let p_value = ChiSquared::new(freedom).ok()?.sf(sum);
        let kind = match lags {
            [0] => Kind::AtOnce,
            _ => Kind::Later(lags.last().map_or(0.0, |&last| last as f64 * self.step)),
        };
        (fewest >= FEWEST).then_some(Test { p_value, share, kind })
    }
}

/// Root mean square of the rows that count.
pub(super) fn typical_size(values: &[f64], counts: &[bool]) -> f64 {
    let counted = || values.iter().zip(counts).filter(|(_, c)| **c).map(|(v, _)| *v);
    (counted().map(|v| v * v).sum::<f64>() / counted().count().max(1) as f64).sqrt()
}

/// How many of the section's [`STRETCHES`] what is new comes from: (Σ E)² / Σ E² of their energies.
pub(super) fn news_from(new: &[f64], counts: &[bool]) -> f64 {
    let long = new.len().div_ceil(STRETCHES).max(1);
    let energy = |(new, counts): (&[f64], &[bool])| {
        new.iter().zip(counts).filter(|(_, c)| **c).map(|(w, _)| w * w).sum::<f64>()
    };
    let (sum, squares) = new
        .chunks(long)
        .zip(counts.chunks(long))
        .map(energy)
        .fold((0.0, 0.0), |(a, b), e| (a + e, b + e * e));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// What `taps` values before it do not tell of each value, by a regression over the rows that count.
fn whitened(u: &[f64], taps: usize, counts: &[bool]) -> Option<Vec<f64>> {
    let row = |k: usize| {
        let past = u[k - taps..k].iter().rev().copied();
        DVector::from_iterator(taps + 1, past.chain([1.0]))
    };
    let rows = (taps..u.len()).filter(|&k| counts[k]).map(|k| (row(k), u[k]));
    let weights = least_squares(taps + 1, rows)?;
    let new = |k: usize| if k < taps { 0.0 } else { u[k] - weights.dot(&row(k)) };
    Some((0..u.len()).map(new).collect())
}

/// What the level of an input of two levels and the rows since its last switch do not tell of each value, by their mean over the rows
/// that count; `None` for any other input.
fn by_age(u: &[f64], counts: &[bool]) -> Option<Vec<f64>> {
    if !has_two_levels(u.iter().zip(counts).filter(|(_, counts)| **counts).map(|(u, _)| u)) {
        return None;
    }
    let mut age = 0;
    let places: Vec<(u64, usize)> = (0..u.len())
        .map(|k| {
            let before = u[k.saturating_sub(1)];
            age = if k < 2 || before != u[k - 2] { 1 } else { age + 1 };
            // zero has two signs, and is one level
            ((before + 0.0).to_bits(), age)
        })
        .collect();
    let mut sums: HashMap<(u64, usize), (f64, f64)> = HashMap::new();
    for k in (0..u.len()).filter(|&k| counts[k]) {
        let (sum, number) = sums.entry(places[k]).or_default();
        *sum += u[k];
        *number += 1.0;
    }
    let new =
        |k: usize| if counts[k] { sums.get(&places[k]).map_or(0.0, |(sum, n)| u[k] - sum / n) } else { 0.0 };
    Some((0..u.len()).map(new).collect())
}

/// The channels, the second less what the first tells of it; a dead channel is left out.
fn uncorrelated(innovations: &[Output]) -> Vec<Vec<f64>> {
    let product = |a: usize, b: usize| innovations.iter().map(|e| e[a] * e[b]).sum::<f64>();
    let first: Vec<f64> = innovations.iter().map(|e| e[0]).collect();
    let slope = product(0, 1) / product(0, 0).max(f64::MIN_POSITIVE);
    let second: Vec<f64> = innovations.iter().map(|e| e[1] - slope * e[0]).collect();
    [first, second].into_iter().filter(|channel| channel.iter().any(|e| *e != 0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::feedback::ODDS;
    use super::*;

    /// What a section says of the motion that one row later is its input, but for what is new in it.
    fn asked(u: &[f64], e: impl Fn(usize, f64) -> f64) -> Option<Test> {
        let noise = |k: usize| (0.7 * (k * k % 1009) as f64).sin();
        let e: Vec<Output> = (0..u.len()).map(|k| [e(k, noise(k)), 0.0]).collect();
        let supervised = vec![false; u.len()];
        let section = Section {
            u,
            e: &e,
            supervised: &supervised,
            step: 0.05,
            averaged: 1,
            interpolated: false,
            dwells: None,
        };
        section.test().map(|(test, _)| test)
    }

    /// A random sequence of two levels that may change every `clock` rows, and the rows since its last switch.
    fn clocked(clock: usize) -> (Vec<f64>, Vec<usize>) {
        let level =
            |k: usize| if (0.7 * ((k / clock).pow(2) % 1013) as f64).sin() > 0.0 { 1.0 } else { -1.0 };
        let u: Vec<f64> = (0..800).map(level).collect();
        let mut age = 0;
        let since = (0..u.len()).map(|k| {
            age = if k > 0 && u[k] == u[k - 1] { age + 1 } else { 0 };
            age
        });
        (u.clone(), since.collect())
    }

    #[test]
    fn a_clocks_next_switch_is_not_told_by_a_model_that_errs_after_the_last() {
        let (u, since) = clocked(8);
        let errs = |k: usize, noise: f64| noise + if (1..5).contains(&since[k]) { 2.0 * u[k] } else { 0.0 };
        let test = asked(&u, errs).unwrap();
        assert!(test.p_value > ODDS, "{}", test.told());
        let told = asked(&u, |k, noise| noise + if k < 799 { 0.8 * (u[k + 1] - u[k]) } else { 0.0 });
        assert!(told.is_some_and(|test| test.p_value < ODDS), "a relay");
    }

    #[test]
    fn a_ramp_along_which_a_model_errs_is_not_asked_and_feedback_is() {
        let ramp: Vec<f64> = (0..400).map(|k| if k < 200 { k.min(30) as f64 } else { 35.0 }).collect();
        assert!(asked(&ramp, |k, noise| noise + if k < 30 { 3.0 } else { 0.0 }).is_none());
        let noise = |k: usize| (0.7 * (k * k % 1013) as f64).sin();
        let moved: Vec<f64> = (0..400).map(noise).collect();
        let fed_back = asked(&moved, |k, noise| noise + if k < 399 { 2.0 * moved[k + 1] } else { 0.0 });
        assert!(fed_back.is_some_and(|test| test.p_value < ODDS));
        assert!(asked(&moved, |_, noise| noise).is_some_and(|test| test.p_value > ODDS));
    }
}
