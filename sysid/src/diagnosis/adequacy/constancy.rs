//! Whether a model's parameters are the same everywhere: in every section, at every size of the motion.
//!
//! At the optimum the scores s_k = J_kᵀ W e_k of all rows add up to zero, and each is unpredictable from the past. A
//! parameter θ_i that is larger where a known weight w_k is larger makes the weighted sum differ from zero (score test;
//! Newey, Econometrica 53, 1985; Nyblom, JASA 84, 1989):
//!
//! ```text
//! m = Σ w_k s_ki,    v = A − B I⁻¹ Bᵀ,    A = Σ w_k² J_kiᵀ W J_ki,   B = Σ w_k J_kiᵀ W J_k,   I = Σ J_kᵀ W J_k
//! m²/(κ v) ~ χ²(1)
//! ```
//!
//! κ, no less than one, is the variance of the sums over blocks relative to A. Of all pairs of a parameter and a weight,
//! the worst counts (Bonferroni).

use super::Test;
use super::left::Left;
use super::p_values::{chi_squared_tail, divisor};
use crate::dataset::Place;
use crate::estimate::digits;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use nalgebra::{DMatrix, DVector};

/// A weight of which all unknowns together leave less than this share says nothing of its parameter.
const LEAST_SHARE: f64 = 1e-6;
/// Where each weight is large, as the end of "a sign that dM_dq differs ...".
const REGIMES: [&str; 8] = [
    "at large rates from small ones",
    "between nose-up and nose-down rates",
    "at large angles from small ones",
    "between nose-up and nose-down angles",
    "at large commands from small ones",
    "between positive and negative commands",
    "shortly after a switch of the input from elsewhere",
    "late in the recording from early",
];
/// The regime that is time.
const LATE: usize = 7;

/// Tests every parameter of the physics against every weight and section.
pub fn test(left: &Left, problem: &Problem<'_>, fit: &Fit, sections: &[Place]) -> Test {
    let coordinates = problem.coordinates(&fit.effects);
    let of_those = |asked: fn(&dyn Effect) -> bool| -> Vec<usize> {
        let which = (0..fit.effects.len()).filter(|&i| asked(fit.effects[i]));
        which.flat_map(|i| fit.own_range(problem, i)).collect()
    };
    // An effect of time has no other time, and says itself what changes over time.
    let of_time = of_those(|effect| effect.about().variable == "t");
    let background = of_those(|effect| effect.is_background());
    // The user's mount is held by its prior: its scores do not add up to zero.
    let tested: Vec<usize> = (0..coordinates.len())
        .filter(|i| !problem.noise_range().contains(i) && !problem.mount_range().contains(i))
        .filter(|i| !of_time.contains(i) && !background.contains(i))
        .filter(|i| coordinates[*i].bounds[0] < coordinates[*i].bounds[1])
        .collect();
    let mut weights = regimes(left);
    if !of_time.is_empty() {
        weights.remove(LATE);
    }
    // One section alone is the whole recording.
    if sections.len() > 1 {
        weights.extend(sections.iter().map(|place| in_section(left, place)));
    }
    let Some(found) = statistics(left, &tested, &weights) else { return Test::silent("constancy", true) };
    let Some(worst) = found.iter().max_by(|a, b| a.statistic.total_cmp(&b.statistic)) else {
        return Test::silent("constancy", true);
    };
    Test {
        name: "constancy",
        statistic: worst.statistic,
        p_value: p_value(&found),
        closes: worst.statistic,
        of_physics: true,
        windows: Vec::new(),
        words: format!(
            "a sign that {} differs {} (chi-squared {})",
            coordinates[worst.unknown].name,
            weights[worst.weight].words,
            digits(worst.statistic)
        ),
    }
}

/// A weight for every counted row.
pub struct Weight {
    words: String,
    values: Vec<f64>,
}

/// One pair.
pub struct Pair {
    unknown: usize,
    weight: usize,
    /// χ² with one degree of freedom.
    pub statistic: f64,
}

/// Of the worst pair, among all (Bonferroni).
pub fn p_value(found: &[Pair]) -> f64 {
    let worst = found.iter().map(|pair| pair.statistic).fold(0.0, f64::max);
    (found.len() as f64 * chi_squared_tail(worst, 1.0)).min(1.0)
}

/// χ² of every pair of an unknown of `tested` and a weight. `None` where the unknowns are not independent.
pub fn statistics(left: &Left, tested: &[usize], weights: &[Weight]) -> Option<Vec<Pair>> {
    let inner = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[0] + a[1] * b[1];
    let slopes = &left.slopes;
    let product = |i: usize, j: usize, weight: Option<&Vec<f64>>| -> f64 {
        let products = slopes[i].iter().zip(&slopes[j]).map(|(a, b)| inner(a, b));
        match weight {
            None => products.sum(),
            Some(weight) => products.zip(weight).map(|(p, w)| w * p).sum(),
        }
    };
    let moving: Vec<usize> = (0..slopes.len()).filter(|&i| product(i, i, None) > 0.0).collect();
    let n = moving.len();
    let mut information = DMatrix::zeros(n, n);
    for (a, b) in (0..n).flat_map(|a| (0..=a).map(move |b| (a, b))) {
        information[(a, b)] = product(moving[a], moving[b], None);
        information[(b, a)] = information[(a, b)];
    }
    let solver = information.cholesky()?;
    let blocks = left.blocks();
    let count = blocks.last()? + 1;
    let mut scores = DMatrix::zeros(n, count);
    for (k, (e, &block)) in left.errors.iter().zip(&blocks).enumerate() {
        for (a, &i) in moving.iter().enumerate() {
            scores[(a, block)] += inner(&slopes[i][k], e);
        }
    }
    let mut all = Vec::new();
    for (index, Weight { values: weight, .. }) in weights.iter().enumerate() {
        for &i in tested.iter().filter(|i| moving.contains(i)) {
            let (mut of_blocks, mut a_of_blocks) =
                (DVector::<f64>::zeros(count), DVector::<f64>::zeros(count));
            for (((slope, e), w), &block) in slopes[i].iter().zip(&left.errors).zip(weight).zip(&blocks) {
                of_blocks[block] += w * inner(slope, e);
                a_of_blocks[block] += w * w * inner(slope, slope);
            }
            let b = DVector::from_iterator(n, moving.iter().map(|&j| product(i, j, Some(weight))));
            let along = solver.solve(&b);
            let a = a_of_blocks.sum();
            let v = a - b.dot(&along);
            if v > LEAST_SHARE * a {
                of_blocks -= scores.tr_mul(&along);
                let m = of_blocks.sum();
                // about what a change that is there adds to each block
                let uneven = (of_blocks - a_of_blocks * (m / a)).norm_squared() / v;
                let statistic = m * m / (v * divisor(uneven, count as f64));
                all.push(Pair { unknown: i, weight: index, statistic });
            }
        }
    }
    Some(all)
}

/// A weight for every regime.
pub fn regimes(left: &Left) -> Vec<Weight> {
    let mut all: Vec<Weight> =
        REGIMES.iter().map(|words| Weight { words: (*words).to_owned(), values: Vec::new() }).collect();
    for (_, _, known) in left.rows() {
        let [u, q, theta] = known.signals;
        let values = [q.abs(), q, theta.abs(), theta, u.abs(), u, known.moved, known.time / left.duration];
        for (weight, value) in all.iter_mut().zip(values) {
            weight.values.push(value);
        }
    }
    all
}

fn in_section(left: &Left, place: &Place) -> Weight {
    let within =
        |(run, k, _): (usize, usize, _)| f64::from(u8::from(place.run == run && place.rows.contains(&k)));
    Weight {
        words: format!("in section {} from elsewhere", place.label),
        values: left.rows().map(within).collect(),
    }
}
