//! Does the input answer to the motion of the last few rows? Asked of the rows as they were logged, before any average, and without
//! a model of the vehicle.
//!
//! What the past tells neither of the motion nor of the input:
//!
//! ```text
//! e(k) = y(k) − ŷ(k | u, y before k),   w(k) = u(k) − û(k | u before k)          (least squares)
//! r(l): rank correlation of e(k) with w(k+l)                                     (Spearman, 1904)
//! ```
//!
//! An input that was decided beforehand knows nothing of e, and r √n is a standard normal number. What is logged too late, a rate that was
//! smoothed both ways, or an input that acts within its row have e show the input's own effect; so only what goes against that
//! effect counts, as a controller's answer does that holds the vehicle. For later rows the input of the motion's own row is among what is known.
//! Ranks, and no rows at the switches of an excitation or steps of a set-point, along which a model that lacks something errs alike.
//! A command that keeps its value for N rows and may change in the next is made by something slower than the log: of these rows alone the
//! same is asked.

use super::news::{FEWEST_STRETCHES, Kind, ROUNDING, SWITCH, TRIMMED, Test, news_from, typical_size};
use crate::dataset::{has_two_levels, median_size};
use crate::linalg::least_squares::least_squares;
use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::BTreeMap;

/// Rows of the past that are known, and fewest rows that are asked.
const ROWS: Asked = Asked { memory: 8, fewest: 200 };
/// The same of rows that are N apart.
const DECISIONS: Asked = Asked { memory: 4, fewest: 60 };
/// Rows that an answer may take.
const LATEST: usize = 3;
/// Share of the times between two changes that are by a clock, whole numbers of its period, and how far they may be from those, as a
/// share of it.
const BY_A_CLOCK: f64 = 0.95;
const JITTER: f64 = 0.15;
/// How far those may be from the most frequent that are the period, as a share of it.
const NEAR: f64 = 0.25;
/// Share of the values that recur after the period of a sequence that repeats itself, and most of them that are compared.
const ALWAYS: f64 = 0.95;
const LONGEST: usize = 10_000;

#[derive(Clone, Copy)]
struct Asked {
    memory: usize,
    fewest: usize,
}

/// Asks the rows of `u` and of the signals of `motion` that count; `effect` is the gain of the input as fitted. `None` where too
/// little is there to be asked, nothing is new in the input between its switches, or it has two levels: what is new in it is a switch then,
/// by its own clock.
pub fn answers(u: &[f64], motion: &[&[f64]], counts: &[bool], effect: f64) -> Option<Test> {
    decisions(u)
        .and_then(|(every, rows)| {
            let at = |signal: &[f64]| -> Vec<f64> { rows.iter().map(|&k| signal[k]).collect() };
            let motion: Vec<Vec<f64>> = motion.iter().map(|signal| at(signal)).collect();
            let motion: Vec<&[f64]> = motion.iter().map(Vec::as_slice).collect();
            let all_counted = |from: usize, to: usize| !counts[from..=to].contains(&false);
            let since = |i: usize| rows[i.saturating_sub(1)];
            let counts: Vec<bool> = (0..rows.len()).map(|i| all_counted(since(i), rows[i])).collect();
            asked(&at(u), &motion, &counts, effect, DECISIONS, every)
        })
        .or_else(|| asked(u, motion, counts, effect, ROWS, 1))
}

/// The rows in which an input may change that keeps its value between them, and how many rows these are apart; `None` where it
/// changes by no clock or in neighbouring rows, or repeats itself: that was decided beforehand.
fn decisions(u: &[f64]) -> Option<(usize, Vec<usize>)> {
    let changes: Vec<usize> = (1..u.len()).filter(|&k| u[k] != u[k - 1]).collect();
    let gaps = || changes.windows(2).map(|pair| pair[1] - pair[0]);
    let mut seen: BTreeMap<usize, usize> = BTreeMap::new();
    gaps().for_each(|gap| *seen.entry(gap).or_default() += 1);
    let usual = *seen.iter().max_by_key(|(_, count)| **count)?.0 as f64;
    let usual: Vec<f64> =
        gaps().map(|gap| gap as f64).filter(|gap| (gap / usual - 1.0).abs() < NEAR).collect();
    let every = usual.iter().sum::<f64>() / usual.len() as f64;
    let times = |gap: usize| (gap as f64 / every).round().max(1.0);
    let by_the_clock = gaps().filter(|&gap| (gap as f64 / every - times(gap)).abs() <= JITTER).count();
    if every < 2.0 || (by_the_clock as f64) < BY_A_CLOCK * gaps().count() as f64 {
        return None;
    }
    let between = changes.windows(2).flat_map(|pair| {
        let count = times(pair[1] - pair[0]) as usize;
        (0..count).map(move |i| pair[0] + i * (pair[1] - pair[0]) / count)
    });
    let rows: Vec<usize> = between.collect();
    let levels: Vec<f64> = rows.iter().take(LONGEST).map(|&k| u[k]).collect();
    let repeats = |period: usize| {
        let others = ((1.0 - ALWAYS) * (levels.len() - period) as f64) as usize;
        levels.iter().zip(&levels[period..]).filter(|(level, later)| level != later).nth(others).is_none()
    };
    (!(1..=levels.len() / 2).any(repeats)).then(|| (every.round() as usize, rows))
}

/// Asks these rows, which stand for one in `every` of the log.
fn asked(
    u: &[f64],
    motion: &[&[f64]],
    counts: &[bool],
    effect: f64,
    Asked { memory, fewest }: Asked,
    every: usize,
) -> Option<Test> {
    let rows: Vec<usize> = (memory..u.len()).filter(|&k| !counts[k - memory..=k].contains(&false)).collect();
    if rows.len() < fewest || has_two_levels(rows.iter().map(|&k| &u[k])) {
        return None;
    }
    let u = &standardised(u, &rows);
    let motion: Vec<Vec<f64>> = motion.iter().map(|signal| standardised(signal, &rows)).collect();
    let before = |x: &[f64], k: usize| -> Vec<f64> { x[k - memory..k].to_vec() };
    let mut between = vec![true; rows.len()];
    let mut new_input = left(&rows, &between, u, |k| before(u, k))?;
    for _ in 0..TRIMMED {
        let limit = SWITCH * median_size(&new_input, &between);
        between = new_input.iter().map(|new| new.abs() <= limit).collect();
        new_input = left(&rows, &between, u, |k| before(u, k))?;
    }
    let is_new = median_size(&new_input, &between) > ROUNDING * typical_size(u, &vec![true; u.len()]);
    if !is_new || news_from(&new_input, &between) < FEWEST_STRETCHES {
        return None;
    }
    let known =
        |k: usize| motion.iter().fold(before(u, k), |known, signal| [known, before(signal, k)].concat());
    let all = vec![true; rows.len()];
    let mut tests = Vec::new();
    for signal in &motion {
        let at_once = left(&rows, &all, signal, known)?;
        let later = left(&rows, &all, signal, |k| [known(k), vec![u[k]]].concat())?;
        for lag in 0..=LATEST {
            let e = if lag == 0 { &at_once } else { &later };
            let pairs: Vec<(f64, f64)> = (0..rows.len() - lag)
                .filter(|&i| rows[i + lag] == rows[i] + lag && between[i + lag])
                .map(|i| (e[i], new_input[i + lag]))
                .collect();
            if pairs.len() >= fewest {
                let r = rank_correlation(&pairs);
                let against = Normal::standard().cdf(r * (pairs.len() as f64).sqrt() * effect.signum());
                let share = r * r - 1.0 / pairs.len() as f64;
                tests.push(Test { p_value: against, share, kind: Kind::OwnRows { later: lag, every } });
            }
        }
    }
    Test::clearest(tests)
}

/// About the mean over `rows`, and of the size of one there.
fn standardised(x: &[f64], rows: &[usize]) -> Vec<f64> {
    let count = rows.len() as f64;
    let mean = rows.iter().map(|&k| x[k]).sum::<f64>() / count;
    let variance = rows.iter().map(|&k| (x[k] - mean).powi(2)).sum::<f64>() / count;
    x.iter().map(|x| (x - mean) / variance.sqrt().max(f64::MIN_POSITIVE)).collect()
}

/// What `known` of each row, and a constant, do not tell of `x`, by a regression over those that count.
fn left(rows: &[usize], counts: &[bool], x: &[f64], known: impl Fn(usize) -> Vec<f64>) -> Option<Vec<f64>> {
    let row = |k: usize| DVector::from_vec([known(k), vec![1.0]].concat());
    let columns = row(*rows.first()?).len();
    let counted = rows.iter().zip(counts).filter(|(_, counts)| **counts);
    let weights = least_squares(columns, counted.map(|(&k, _)| (row(k), x[k])))?;
    Some(rows.iter().map(|&k| x[k] - weights.dot(&row(k))).collect())
}

fn rank_correlation(pairs: &[(f64, f64)]) -> f64 {
    let [a, b] = [ranks(pairs.iter().map(|p| p.0)), ranks(pairs.iter().map(|p| p.1))];
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt().max(f64::MIN_POSITIVE)
}

/// Each value's place in order, about zero; equal ones share theirs.
fn ranks(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let values: Vec<f64> = values.collect();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for alike in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let place = first as f64 + (alike.len() - 1) as f64 / 2.0;
        alike.iter().for_each(|&k| ranks[k] = place - (values.len() - 1) as f64 / 2.0);
        first += alike.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::super::feedback::ODDS;
    use super::super::fixture::normal;
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// What is logged of each row: the rate before or after the input of the row has acted, and the input of that row or the last.
    #[derive(Clone, Copy)]
    struct Logged {
        rate_after: bool,
        input_late: bool,
    }
    const IN_TIME: Logged = Logged { rate_after: false, input_late: false };

    /// A vehicle that the air shakes, at 100 Hz, under an input of a new level every fourth row. The gains of a controller are those on
    /// the rate of the same row and of two rows before.
    fn logged(seed: u64, log: Logged, [now, before]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
        let mut random = Pcg64::seed_from_u64(seed);
        let (mut u, mut q): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let (mut rate, mut air, mut level) = (0.0, 0.0, 0.0);
        for k in 0..1500_usize {
            level = if k % 4 == 0 { 0.1 * normal(&mut random) } else { level };
            let measured = rate + 0.05 * normal(&mut random);
            let earlier = if k < 2 { 0.0 } else { q[k - 2] };
            u.push(level - now * measured - before * earlier);
            air = 0.9 * air + 0.3 * normal(&mut random);
            rate += 0.01 * (20.0 * u[k] - 2.0 * rate + air);
            q.push(if log.rate_after { rate + 0.05 * normal(&mut random) } else { measured });
        }
        if log.input_late {
            u.insert(0, 0.0);
            u.pop();
        }
        (u, q)
    }

    fn answered((u, q): (Vec<f64>, Vec<f64>)) -> Option<Test> {
        answers(&u, &[&q], &vec![true; u.len()], 20.0)
    }

    /// The same vehicle under a controller that is told only every tenth row, or one late by as many as `jitter`, and rounds its command.
    fn slowly(seed: u64, jitter: u64, gain: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = Pcg64::seed_from_u64(seed);
        let (mut u, mut q): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let (mut rate, mut air, mut given, mut next) = (0.0, 0.0, 0.0, 0);
        for k in 0..4000_u64 {
            q.push(rate + 0.05 * normal(&mut random));
            if k == next {
                let wanted = 0.05 * normal(&mut random) - gain * q[k as usize];
                given = (wanted / 0.01).round() * 0.01;
                next = k / 10 * 10 + 10 + random.random_range(0..=jitter);
            }
            u.push(given);
            air = 0.9 * air + 0.3 * normal(&mut random);
            rate += 0.01 * (20.0 * given - 2.0 * rate + air);
        }
        (u, q)
    }

    #[test]
    fn a_controller_that_is_slower_than_the_log_is_asked_where_it_decides() {
        for jitter in [0, 1] {
            let test = answered(slowly(3, jitter, 0.4)).unwrap();
            assert!(test.p_value < ODDS && test.share > 0.02, "{}: {:.0e}", test.told(), test.p_value);
            assert!(test.told().contains("one in 10,"), "{}", test.told());
            let p_values: Vec<f64> =
                (0..200).map(|seed| answered(slowly(seed, jitter, 0.0)).unwrap().p_value).collect();
            let below = |level: f64| p_values.iter().filter(|p| **p < level).count();
            assert!(below(0.05) <= 20 && below(0.01) <= 7 && below(ODDS) <= 1, "{p_values:?}");
        }
        let levels = |every: usize, period: usize| -> Vec<f64> {
            (0..2000).map(|k| f64::from((k / every % period * 7919 % 31) as u32)).collect()
        };
        assert_eq!(decisions(&levels(20, 1000)).map(|(every, _)| every), None, "31 values over again");
        assert_eq!(decisions(&levels(60, 1000)).map(|(every, _)| every), Some(60));
        let irregular = (0..2000).map(|k| f64::from((f64::from(k).sqrt() as u32) % 7)).collect::<Vec<_>>();
        assert!(decisions(&irregular).is_none());
        for odd in [1, 5] {
            let mut once = slowly(3, 0, 0.4).0;
            once[2000 + odd..2010].fill(9.0);
            assert_eq!(decisions(&once).map(|(every, _)| every), Some(10), "one change off the clock");
        }
    }

    #[test]
    fn an_answer_within_the_row_or_soon_after_is_found() {
        for gains in [[0.4, 0.0], [0.0, 0.4]] {
            let test = answered(logged(5, IN_TIME, gains)).unwrap();
            assert!(test.p_value < ODDS && test.share > 0.02, "{}: {:.0e}", test.told(), test.p_value);
        }
    }

    #[test]
    fn an_input_that_was_decided_beforehand_answers_nothing() {
        const SEEDS: u64 = 200;
        let early = Logged { rate_after: true, ..IN_TIME };
        for log in [IN_TIME, early, Logged { input_late: true, ..early }] {
            let p_values = (0..SEEDS).map(|seed| answered(logged(seed, log, [0.0; 2])).unwrap().p_value);
            let p_values: Vec<f64> = p_values.collect();
            let below = |level: f64| p_values.iter().filter(|p| **p < level).count();
            // 10 and 2 by chance
            assert!(below(0.05) <= 20 && below(0.01) <= 7 && below(ODDS) <= 1, "{p_values:?}");
        }
    }

    #[test]
    fn a_rate_that_was_smoothed_both_ways_is_no_answer() {
        for seed in 0..10 {
            let (u, q) = logged(seed, IN_TIME, [0.0; 2]);
            let smoothed: Vec<f64> = q.windows(7).map(|seven| seven.iter().sum::<f64>() / 7.0).collect();
            let test = answered((u[3..u.len() - 3].to_vec(), smoothed)).unwrap();
            assert!(test.p_value > ODDS, "{}: {:.0e}", test.told(), test.p_value);
        }
    }

    #[test]
    fn an_excitation_in_long_steps_is_not_asked() {
        let staircase: Vec<f64> =
            (0..1500).map(|k| 1500.0 + [0.0, 100.0, -50.0, 200.0][k / 100 % 4]).collect();
        let pulls = |k: usize| (0.01 * k as f64).sin();
        let q: Vec<f64> = (0..1500).map(|k| 1e-3 * staircase[k] + pulls(k)).collect();
        assert!(answered((staircase, q.clone())).is_none() && answered((vec![0.0; 1500], q)).is_none());
    }

    #[test]
    fn two_levels_and_few_rows_are_not_asked() {
        let q: Vec<f64> = (0..400).map(|k| (0.7 * f64::from(k * k % 101)).sin()).collect();
        let relay: Vec<f64> = q.iter().map(|q| -q.signum()).collect();
        assert!(answers(&relay, &[&q], &[true; 400], 1.0).is_none());
        let fed_back: Vec<f64> = q.iter().map(|q| -q).collect();
        assert!(answers(&fed_back, &[&q], &[true; 400], 1.0).is_some());
        assert!(answers(&fed_back[..150], &[&q[..150]], &[true; 150], 1.0).is_none());
    }

    #[test]
    fn equal_values_share_a_rank() {
        assert_eq!(ranks([3.0, 1.0, 3.0, 2.0].into_iter()), [1.0, -1.5, 1.0, -0.5]);
        let pairs = [(0.0, 5.0), (1.0, 7.0), (2.0, 100.0)];
        assert!((rank_correlation(&pairs) - 1.0).abs() < 1e-12);
        assert_eq!(rank_correlation(&[(1.0, 2.0), (1.0, 3.0)]), 0.0);
    }
}
