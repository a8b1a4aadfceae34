//! Do the errors' sizes follow what the vehicle does? A moment that the model lacks makes errors larger while it acts.
//!
//! With y_k = |e_k|²/c − 1 over the c white channels and a weight w_k known before row k (1 shortly after a switch of the
//! input; at large rates; at large angles; else 0):
//!
//! ```text
//! z = Σ (w_k − w̄) y_k / √(κ v),     v = Σ (w_k − w̄)² · var y,     κ from the sums over blocks
//! ```
//!
//! the score test for a variance that depends on w (Breusch and Pagan, Econometrica 47, 1979; studentised: Koenker, 1981).
//! The size of the input itself is no weight: noise that grows with it (vibration) is a background.

use super::Test;
use super::chance::{divisor, least_of, two_sided};
use super::left::Left;
use crate::estimate::digits;

/// The input has switched where it moves by more than this, in standard deviations.
const SWITCH: f64 = 1.0;
/// A large rate and a large angle, in standard deviations: about a third and an eighth of the time.
const LARGE: [f64; 2] = [1.0, 1.5];
/// A weight that holds for less than this share of the time compares nothing.
const LEAST_SHARE: f64 = 0.02;
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
    for (_, _, known) in left.rows() {
        let [_, q, theta] = known.signals;
        weights[0].push(known.moved > SWITCH);
        weights[1].push(q.abs() > LARGE[0]);
        weights[2].push(theta.abs() > LARGE[1]);
    }
    let scores = weights.iter().map(|weight| score(&sizes, weight, &blocks));
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

/// z of the squared `sizes` against `weight`. `None` where the weight is nearly always or nearly never on.
pub fn score(sizes: &[f64], weight: &[bool], blocks: &[usize]) -> Option<f64> {
    let n = sizes.len() as f64;
    let share = weight.iter().filter(|w| **w).count() as f64 / n;
    if !(LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&share) {
        return None;
    }
    let mean = sizes.iter().sum::<f64>() / n;
    let variance = sizes.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / n;
    let mut of_blocks = vec![0.0; blocks.last()? + 1];
    for ((y, w), &block) in sizes.iter().zip(weight).zip(blocks) {
        of_blocks[block] += (f64::from(u8::from(*w)) - share) * (y - mean);
    }
    let score: f64 = of_blocks.iter().sum();
    let v = n * share * (1.0 - share) * variance;
    // about its own mean: an effect that is the same everywhere makes no block uneven
    let count = of_blocks.len() as f64;
    let uneven = of_blocks.iter().map(|s| (s - score / count).powi(2)).sum::<f64>() / v;
    Some(score / (v * divisor(uneven, count - 1.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::normal;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn errors_after_switches_show_and_a_background_of_slow_strength_does_not() {
        let mut random = Pcg64::seed_from_u64(4);
        let blocks: Vec<usize> = (0..5000).map(|k| k / 150).collect();
        let weight: Vec<bool> = (0..5000).map(|k| k % 70 < 15).collect();
        let mut sizes = |grown: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..5000).map(|k| (grown(k) * normal(&mut random)).powi(2)).collect()
        };
        let after = sizes(&|k| if weight[k] { 1.3 } else { 1.0 });
        assert!(score(&after, &weight, &blocks).unwrap() > 5.0);
        let slow = sizes(&|k| if k / 400 % 2 == 0 { 1.5 } else { 1.0 });
        assert!(score(&slow, &weight, &blocks).unwrap().abs() < 3.0);
    }
}
