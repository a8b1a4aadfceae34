//! Does the time between two switches of the input depend on the motion at the first?
//!
//! A controller, an operator or a limit may leave the levels of a switching input as they are and move its switches alone. With
//! the dwell d_i after switch i, its direction s_i = ±1, its place τ_i from 0 to 1, and rate and angle there,
//!
//! ```text
//! d_i = c_0 + c_1 s_i + c_2 τ_i + c_3 τ_i² + c_4 τ_i³  +  a_1 s_i q_i + a_2 |q_i| + a_3 s_i θ_i + a_4 |θ_i|  + error
//! ```
//!
//! and an input whose dwells are drawn one by one beforehand has a = 0 (F test). Where it has not, the dwells may as well follow
//! from those before, as in a sweep or in pulses that are drawn in groups, which is known from the motion that those made. What
//! tells the two apart is the part of the motion that the input did not make, q − q̂ with q̂ of the model's free run: a controller
//! answers to that too, and no sequence that was drawn beforehand does. With the [`PAST`] dwells before (each with s_i) among the
//! c's, the test is then of s_i (q_i − q̂_i), sign(q̂_i) (q_i − q̂_i) and the same of θ, which are even whatever the input was.
//!
//! A sequence that repeats itself is not asked.

use crate::model::pitch::Output;
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
/// Regressors of the motion that are tested.
const TESTED: usize = 4;

/// What the motion at a switch tells of the time to the next.
pub(super) struct Dwells {
    /// Odds of that by chance, were each dwell drawn by itself.
    pub(super) by_motion: f64,
    /// That, and the same of what the input did not make of the motion; `None` where no free run is to be had.
    pub(super) by_the_rest: Option<Told>,
}

/// One test: its odds by chance, and the share of the dwells' variance that it explains beyond what chance gives.
pub(super) struct Told {
    pub(super) p_value: f64,
    pub(super) share: f64,
}

/// The test of one section, `simulated` by the model from its first row; `None` where the input is no sequence of steps, or too
/// short a one.
pub(super) fn dwells(
    u: &[f64],
    motion: &[Output],
    supervised: &[bool],
    simulated: Option<&[Output]>,
) -> Option<Dwells> {
    let switches: Vec<usize> = (1..u.len()).filter(|&k| u[k] != u[k - 1]).collect();
    if switches.len() < FEWEST || switches.len() as f64 > STEPS * u.len() as f64 {
        return None;
    }
    let dwells: Vec<usize> = switches.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if repeats(&dwells) {
        return None;
    }
    let free = |i: &usize| !supervised[switches[*i]..=switches[i + 1]].contains(&true);
    let asked: Vec<usize> = (PAST..dwells.len()).filter(free).collect();
    if asked.len() < FEWEST - PAST {
        return None;
    }
    let d = DVector::from_iterator(asked.len(), asked.iter().map(|&i| dwells[i] as f64));
    let side = |i: usize| (u[switches[i]] - u[switches[i] - 1]).signum();
    let drawn = |i: usize| {
        let place = i as f64 / dwells.len() as f64;
        vec![1.0, side(i), place, place.powi(2), place.powi(3)]
    };
    let by_motion = |&i: &usize| {
        let [q, theta] = motion[switches[i]];
        [drawn(i), vec![side(i) * q, q.abs(), side(i) * theta, theta.abs()]].concat()
    };
    let by_motion = tested(&d, asked.iter().map(by_motion))?;
    let by_the_rest = simulated.and_then(|simulated| {
        let row = |&i: &usize| {
            let past = dwells[i - PAST..i].iter().flat_map(|&d| [d as f64, side(i) * d as f64]).collect();
            let (all, made) = (motion[switches[i]], simulated[switches[i]]);
            let rest = [0, 1].map(|y| all[y] - made[y]);
            let rest = (0..2).flat_map(|y| [side(i) * rest[y], made[y].signum() * rest[y]]).collect();
            [drawn(i), past, rest].concat()
        };
        let told = tested(&d, asked.iter().map(row))?;
        Some(Told { p_value: told.p_value.max(by_motion.p_value), ..told })
    });
    Some(Dwells { by_motion: by_motion.p_value, by_the_rest })
}

/// Tests the last [`TESTED`] columns of a regression of `d`; `None` with more columns than rows.
fn tested(d: &DVector<f64>, rows: impl Iterator<Item = Vec<f64>>) -> Option<Told> {
    let rows: Vec<Vec<f64>> = rows.collect();
    let columns = rows.first()?.len();
    let freedom = d.len().checked_sub(columns).filter(|freedom| *freedom > 0)? as f64;
    let x = DMatrix::from_row_iterator(d.len(), columns, rows.into_iter().flatten());
    let [own, all] = [columns - TESTED, columns].map(|count| left(&x.columns(0, count).into_owned(), d));
    let further = TESTED as f64;
    let ratio = (own - all) / further / (all / freedom).max(f64::MIN_POSITIVE);
    let p_value = FisherSnedecor::new(further, freedom).ok()?.sf(ratio.max(0.0));
    let share = (own - all) / own.max(f64::MIN_POSITIVE) - further / freedom;
    Some(Told { p_value, share })
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

    /// Sixty seconds of a rate that is pushed to and fro and has noise of its own, of this size; dwells as `drawn`, lengthened by
    /// `lengthened` rows per rad/s of the rate at the switch. Beside it the rate without noise.
    fn asked(
        seed: u64,
        noise: f64,
        lengthened: f64,
        drawn: impl Fn(usize, &mut Pcg64) -> usize,
    ) -> Option<Dwells> {
        let mut random = Pcg64::seed_from_u64(seed);
        let (mut level, mut left, mut count) = (1.0, 0, 0);
        let ([mut rate, mut angle], [mut made, mut turned]) = ([0.0_f64; 2], [0.0; 2]);
        let (mut u, mut motion, mut simulated) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..3000 {
            if left == 0 {
                level = -level;
                left = drawn(count, &mut random) + (lengthened * rate.abs()) as usize;
                count += 1;
            }
            left -= 1;
            u.push(level);
            motion.push([rate, angle]);
            simulated.push([made, turned]);
            rate = 0.97 * rate + 0.1 * level + noise * (random.random::<f64>() - 0.5);
            angle += 0.02 * rate;
            made = 0.97 * made + 0.1 * level;
            turned += 0.02 * made;
        }
        dwells(&u, &motion, &vec![false; u.len()], Some(&simulated))
    }

    fn one_by_one(_: usize, random: &mut Pcg64) -> usize {
        random.random_range(10..20)
    }

    /// Odds of both tests.
    fn odds(dwells: &Dwells) -> [f64; 2] {
        [dwells.by_motion, dwells.by_the_rest.as_ref().map_or(1.0, |told| told.p_value)]
    }

    #[test]
    fn dwells_that_are_drawn_know_nothing_of_the_motion_and_lengthened_ones_do() {
        let tests: Vec<[f64; 2]> =
            (0..400).map(|seed| odds(&asked(seed, 0.3, 0.0, one_by_one).unwrap())).collect();
        for test in 0..2 {
            let below = |level: f64| tests.iter().filter(|odds| odds[test] < level).count();
            assert!((5..=40).contains(&below(0.05)), "{}", below(0.05));
            assert!(below(0.001) <= 3, "{}", below(0.001));
        }
        let closed = asked(1, 0.3, 6.0, one_by_one).unwrap();
        let rest = closed.by_the_rest.unwrap();
        assert!(
            closed.by_motion < 1e-6 && rest.p_value < 1e-6 && rest.share > 0.2,
            "{} {}",
            rest.p_value,
            rest.share
        );
    }

    #[test]
    fn where_nothing_else_moves_the_craft_nothing_tells_a_controller_from_a_sequence() {
        let [by_motion, by_the_rest] = odds(&asked(1, 0.003, 12.0, one_by_one).unwrap());
        assert!(by_motion < 1e-6 && by_the_rest > 1e-3, "{by_motion} {by_the_rest}");
    }

    #[test]
    fn pulses_in_groups_follow_the_motion_that_they_made_and_no_other() {
        let tests: Vec<[f64; 2]> = (0..100)
            .map(|seed| {
                let mut random = Pcg64::seed_from_u64(1000 + seed);
                let drawn: Vec<usize> = (0..120).map(|_| random.random_range(6..20)).collect();
                // +d −2d +d, and the first of the next group after the last
                let dwell = |count: usize| match count % 2 {
                    0 => drawn[count / 2] + if count == 0 { 0 } else { drawn[count / 2 - 1] },
                    _ => 2 * drawn[count / 2],
                };
                odds(&asked(seed, 0.3, 0.0, |count, _| dwell(count)).unwrap())
            })
            .collect();
        assert!(tests.iter().filter(|odds| odds[0] < 1e-3).count() > 30, "{tests:?}");
        assert!(tests.iter().all(|odds| odds[1] > 1e-4), "{tests:?}");
    }

    #[test]
    fn a_sequence_that_repeats_itself_is_not_asked_and_a_sweep_is_no_feedback() {
        let once = [10, 14, 11, 19, 12, 17, 13, 10, 16, 15, 18];
        assert!(asked(2, 0.3, 0.0, |count, _| once[count % once.len()]).is_none());
        for seed in 0..100 {
            let sweep = asked(seed, 0.3, 0.0, |count, _| 5 + count / 4).unwrap();
            assert!(odds(&sweep)[1] > 1e-3, "{:?}", odds(&sweep));
        }
    }
}
