//! Do the errors' sizes follow what the vehicle does? A moment that the model lacks makes errors larger while it acts.
//!
//! With y_k = |e_k|²/c over the c white channels and a weight w_k known before row k (1 shortly after a switch of the
//! input; at large rates; at large angles; else 0), ỹ and w̃ what is left of both beside a constant, |u| and u²:
//!
//! ```text
//! z = Σ w̃_k ỹ_k / √(κ Σ w̃_k² ỹ_k²),     κ from the sums over blocks
//! ```
//!
//! the score test for a variance that depends on w (Breusch and Pagan, Econometrica 47, 1979; for errors y of any variance:
//! White, Econometrica 48, 1980). Noise that grows with the input itself (vibration) is a background.

use super::Test;
use super::left::Left;
use super::p_values::{divisor, least_of, two_sided};
use crate::estimate::digits;
use nalgebra::{Matrix3, Vector3};

/// The input has switched where it moves by more than this, in standard deviations.
const SWITCH: f64 = 1.0;
/// A large rate and a large angle, in standard deviations: about a third and an eighth of the time.
const LARGE: [f64; 2] = [1.0, 1.5];
/// A weight that holds for less than this share of the time compares nothing.
const LEAST_SHARE: f64 = 0.02;
/// Relative part added to the sums of squares, so that they can be inverted.
const HAIR: f64 = 1e-9;
const WORDS: [&str; 3] = ["shortly after a switch of the input", "at large rates", "at large angles"];

/// Tests every weight.
pub fn test(left: &Left) -> Test {
    let sizes: Vec<f64> = left
        .errors
        .iter()
        .map(|e| e[..left.channels].iter().map(|e| e * e).sum::<f64>() / left.channels as f64)
        .collect();
    let blocks = left.blocks();
    let mut weights = [const { Vec::new() }; WORDS.len()];
    let mut commands = Vec::with_capacity(sizes.len());
    for (_, _, known) in left.rows() {
        let [u, q, theta] = known.signals;
        commands.push(u);
        weights[0].push(known.moved > SWITCH);
        weights[1].push(q.abs() > LARGE[0]);
        weights[2].push(theta.abs() > LARGE[1]);
    }
    let sizes = beside(&commands, &sizes);
    let scores = weights.iter().map(|weight| score(&sizes, &commands, weight, &blocks));
    let tested: Vec<(f64, &str)> =
        scores.zip(WORDS).filter_map(|(score, words)| Some((score?, words))).collect();
    let Some(&(z, words)) = tested.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) else {
        return Test::silent("switches", true);
    };
    let change = if z > 0.0 { "larger" } else { "smaller" };
    Test {
        name: "switches",
        statistic: z,
        p_value: least_of(two_sided(z), tested.len()),
        closes: z * z,
        of_physics: true,
        windows: Vec::new(),
        words: format!(
            "errors that are {change} {words} than elsewhere ({} standard errors)",
            digits(z.abs())
        ),
    }
}

/// z of the squared sizes `left` by the `commands` against `weight`. `None` where the weight is nearly always or nearly never on.
fn score(left: &[f64], commands: &[f64], weight: &[bool], blocks: &[usize]) -> Option<f64> {
    let n = left.len() as f64;
    let share = weight.iter().filter(|w| **w).count() as f64 / n;
    if !(LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&share) {
        return None;
    }
    let weight: Vec<f64> = weight.iter().map(|w| f64::from(u8::from(*w))).collect();
    let products: Vec<f64> = beside(commands, &weight).iter().zip(left).map(|(w, y)| w * y).collect();
    let mut of_blocks = vec![0.0; blocks.last()? + 1];
    for (product, &block) in products.iter().zip(blocks) {
        of_blocks[block] += product;
    }
    let score: f64 = of_blocks.iter().sum();
    let v = products.iter().map(|p| p * p).sum::<f64>();
    // about its own mean: an effect that is the same everywhere makes no block uneven
    let count = of_blocks.len() as f64;
    let uneven = of_blocks.iter().map(|s| (s - score / count).powi(2)).sum::<f64>() / v;
    Some(score / (v * divisor(uneven, count - 1.0)).sqrt()).filter(|z| z.is_finite())
}

/// What is left of `values` beside a constant, |u| and u² (least squares).
fn beside(commands: &[f64], values: &[f64]) -> Vec<f64> {
    let strength = |u: &f64| Vector3::new(1.0, u.abs(), u * u);
    let (mut gram, mut with) = (Matrix3::zeros(), Vector3::zeros());
    for (u, value) in commands.iter().zip(values) {
        let strength = strength(u);
        gram += strength * strength.transpose();
        with += strength * *value;
    }
    // a command of one size is a constant
    gram += Matrix3::identity() * (HAIR * gram.trace());
    let x = gram.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&with));
    commands.iter().zip(values).map(|(u, value)| value - strength(u).dot(&x)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::normal;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn errors_after_switches_show_and_a_background_whose_strength_is_slow_or_of_the_input_does_not() {
        let mut random = Pcg64::seed_from_u64(4);
        let blocks: Vec<usize> = (0..5000).map(|k| k / 150).collect();
        let weight: Vec<bool> = (0..5000).map(|k| k % 70 < 15).collect();
        // switched to and fro, and at rest for a third of the time
        let commands: Vec<f64> = (0..5000)
            .map(|k| match k / 70 % 3 {
                2 => 0.0,
                i => i as f64 * 2.0 - 1.0,
            })
            .collect();
        let mut z = |grown: &dyn Fn(usize) -> f64, weight: &[bool]| {
            let sizes: Vec<f64> = (0..5000).map(|k| (grown(k) * normal(&mut random)).powi(2)).collect();
            score(&beside(&commands, &sizes), &commands, weight, &blocks).unwrap()
        };
        assert!(z(&|k| if weight[k] { 1.3 } else { 1.0 }, &weight) > 5.0);
        assert!(z(&|k| if k / 400 % 2 == 0 { 1.5 } else { 1.0 }, &weight).abs() < 3.0);
        let moves: Vec<bool> = (0..5000).map(|k| weight[k] && k / 70 % 3 != 2).collect();
        assert!(z(&|k| 0.5 + 0.5 * commands[k].abs(), &moves).abs() < 3.0, "of the input's size");
    }
}
