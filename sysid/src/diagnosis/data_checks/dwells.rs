//! Does the time between two switches of the input depend on the motion at the first?
//!
//! A controller, an operator or a limit may leave the levels of a switching input as they are and move its switches alone. With
//! the dwell d_i after switch i, its direction s_i = ±1, its place τ_i from 0 to 1, and rate and angle there,
//!
//! ```text
//! d_i = c_0 + c_1 s_i + c_2 τ_i + c_3 τ_i² + c_4 τ_i³  +  a_1 s_i q_i + a_2 |q_i| + a_3 s_i θ_i + a_4 |θ_i|  + error
//! ```
//!
//! and an input whose dwells are drawn beforehand has a = 0 (F test). Dwells that follow from those before, as in a sequence
//! that repeats itself, a sweep, or pulses that are drawn in groups, are known from the motion that those made, and are not asked.

use super::feedback::{Kind, Test};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Fewest switches that are asked.
const FEWEST: usize = 40;
/// Most of the samples in which an input of steps changes.
const STEPS: f64 = 0.3;
/// Dwells before a dwell that tell it, where a sequence repeats itself.
const PAST: usize = 4;
/// Share of the recurring pasts that are followed by the same dwell, from which a sequence repeats itself.
const REPEATS: f64 = 0.6;
/// Share of a dwell's variance that those before it tell, in each direction, from which they follow from each other.
const FOLLOWS: f64 = 0.64;
/// Regressors that stand for the input alone, and all.
const OWN: usize = 5;
const ALL: usize = 9;

/// The test of one section; `None` where the input is no sequence of steps, or too short a one.
pub(super) fn dwells(u: &[f64], rate: &[f64], angle: &[f64], supervised: &[bool]) -> Option<Test> {
    let switches: Vec<usize> = (1..u.len()).filter(|&k| u[k] != u[k - 1]).collect();
    if switches.len() < FEWEST || switches.len() as f64 > STEPS * u.len() as f64 {
        return None;
    }
    let dwells: Vec<usize> = switches.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let sides: Vec<f64> = switches.iter().map(|&k| (u[k] - u[k - 1]).signum()).collect();
    if repeats(&dwells) || follows(&dwells, &sides) > FOLLOWS {
        return None;
    }
    let free = |i: &usize| !supervised[switches[*i]..=switches[i + 1]].contains(&true);
    let asked: Vec<usize> = (0..dwells.len()).filter(free).collect();
    if asked.len() < FEWEST {
        return None;
    }
    let regressors = |i: usize| {
        let k = switches[i];
        let side = sides[i];
        let place = i as f64 / dwells.len() as f64;
        let own = [1.0, side, place, place.powi(2), place.powi(3)];
        own.into_iter().chain([side * rate[k], rate[k].abs(), side * angle[k], angle[k].abs()])
    };
    let rows = asked.iter().flat_map(|&i| regressors(i));
    let x = DMatrix::from_row_iterator(asked.len(), ALL, rows);
    let d = DVector::from_iterator(asked.len(), asked.iter().map(|&i| dwells[i] as f64));
    let [own, all] = [OWN, ALL].map(|count| left(&x.columns(0, count).into_owned(), &d));
    let freedom = asked.len() - ALL;
    let further = (ALL - OWN) as f64;
    let ratio = (own - all) / further / (all / freedom as f64).max(f64::MIN_POSITIVE);
    let p_value = FisherSnedecor::new(further, freedom as f64).ok()?.sf(ratio.max(0.0));
    let share = (own - all) / own.max(f64::MIN_POSITIVE) - further / freedom as f64;
    Some(Test { p_value, share, kind: Kind::Dwell })
}

/// Whether the dwells before a dwell tell it wherever they recur.
fn repeats(dwells: &[usize]) -> bool {
    let mut last = std::collections::HashMap::new();
    let (mut recurring, mut same) = (0, 0);
    for window in dwells.windows(PAST + 1) {
        let (past, next) = (&window[..PAST], window[PAST]);
        if let Some(before) = last.insert(past, next) {
            recurring += 1;
            same += usize::from(before == next);
        }
    }
    2 * recurring > dwells.len() && same as f64 > REPEATS * recurring as f64
}

/// Share of the dwells' variance that the [`PAST`] before each tell, in each direction.
fn follows(dwells: &[usize], sides: &[f64]) -> f64 {
    const MEANS: usize = 2;
    const WITH_PAST: usize = MEANS + 2 * PAST;
    let count = dwells.len() - PAST;
    let row = |i: usize| {
        let past = dwells[i - PAST..i].iter().flat_map(move |&d| [d as f64, sides[i] * d as f64]);
        [1.0, sides[i]].into_iter().chain(past)
    };
    let x = DMatrix::from_row_iterator(count, WITH_PAST, (PAST..dwells.len()).flat_map(row));
    let d = DVector::from_iterator(count, dwells[PAST..].iter().map(|&d| d as f64));
    let variance = |columns: usize| left(&x.columns(0, columns).into_owned(), &d) / (count - columns) as f64;
    1.0 - variance(WITH_PAST) / variance(MEANS).max(f64::MIN_POSITIVE)
}

/// Sum of squares that a regression of `d` on the columns of `x` leaves.
fn left(x: &DMatrix<f64>, d: &DVector<f64>) -> f64 {
    let svd = x.clone().svd(true, true);
    let tiny = 1e-10 * svd.singular_values.max();
    svd.solve(d, tiny).map_or(f64::INFINITY, |c| (d - x * c).norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Sixty seconds of a rate that is pushed to and fro and has noise of its own; dwells of 10 to 20 rows, lengthened by
    /// `lengthened` rows per rad/s of the rate at the switch.
    fn asked(seed: u64, lengthened: f64, drawn: impl Fn(usize, &mut Pcg64) -> usize) -> Option<Test> {
        let mut random = Pcg64::seed_from_u64(seed);
        let (mut level, mut left, mut count) = (1.0, 0, 0);
        let (mut rate, mut angle) = (0.0_f64, 0.0);
        let (mut u, mut q, mut theta) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..3000 {
            if left == 0 {
                level = -level;
                left = drawn(count, &mut random) + (lengthened * rate.abs()) as usize;
                count += 1;
            }
            left -= 1;
            u.push(level);
            q.push(rate);
            theta.push(angle);
            rate = 0.97 * rate + 0.1 * level + 0.3 * (random.random::<f64>() - 0.5);
            angle += 0.02 * rate;
        }
        dwells(&u, &q, &theta, &vec![false; u.len()])
    }

    #[test]
    fn dwells_that_are_drawn_know_nothing_of_the_motion_and_lengthened_ones_do() {
        let tests: Vec<Test> =
            (0..400).map(|seed| asked(seed, 0.0, |_, random| random.random_range(10..20)).unwrap()).collect();
        let below = |level: f64| tests.iter().filter(|test| test.p_value < level).count();
        assert!((5..=40).contains(&below(0.05)), "{}", below(0.05));
        assert!(below(0.001) <= 3, "{}", below(0.001));
        let closed = asked(1, 6.0, |_, random| random.random_range(10..20)).unwrap();
        assert!(closed.p_value < 1e-6 && closed.share > 0.2, "{} {}", closed.p_value, closed.share);
    }

    #[test]
    fn pulses_to_and_fro_and_back_are_drawn_in_groups() {
        let odds: Vec<f64> = (0..100)
            .map(|seed| {
                let mut random = Pcg64::seed_from_u64(1000 + seed);
                let drawn: Vec<usize> = (0..120).map(|_| random.random_range(6..20)).collect();
                // +d −2d +d, and the first of the next group after the last
                let dwell = |count: usize| match count % 2 {
                    0 => drawn[count / 2] + if count == 0 { 0 } else { drawn[count / 2 - 1] },
                    _ => 2 * drawn[count / 2],
                };
                asked(seed, 0.0, |count, _| dwell(count)).map_or(1.0, |test| test.p_value)
            })
            .collect();
        assert!(odds.iter().all(|p| *p > 1e-4), "{odds:?}");
    }

    #[test]
    fn a_sequence_that_repeats_itself_is_not_asked() {
        let once = [10, 14, 11, 19, 12, 17, 13, 10, 16, 15, 18];
        assert!(asked(2, 0.0, |count, _| once[count % once.len()]).is_none());
        assert!(asked(2, 0.0, |count, _| 5 + count / 4).is_none(), "a sweep");
    }
}
