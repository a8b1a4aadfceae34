//! A spectral line in what a model leaves.
//!
//! Ordinates of the periodogram of white noise are independent, each a multiple of χ²(2) (Fisher, 1929). One against the
//! mean of m of its neighbours is F(2, 2m), of the highest of n
//!
//! ```text
//! p = 1 − (1 − (1 + x/m)^(−m))ⁿ
//! ```
//!
//! Neighbours and not the whole spectrum, so that a background of another colour than the model's is no line.

use super::Test;
use super::left::Left;
use super::p_values::least_of;
use crate::estimate::digits;
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Frequencies between which a line is looked for, rad/s: from where the disturbance's own poles end to rotors' harmonics.
const LINES: [f64; 2] = [0.8, 40.0];
/// Share of the Nyquist frequency up to which the sampled signals are taken for what they are.
const BELOW_NYQUIST: f64 = 0.8;
/// Ordinates at least and at most so far away make the noise around a line: a line between two ordinates leaks into those
/// beside it, and a resonance of the background is wider than twenty.
const AROUND: [usize; 2] = [3, 20];
/// Fewest neighbours that make a noise.
const FEWEST: usize = 10;
/// Below this length the transform is summed directly.
const DIRECT: usize = 128;

/// The highest line.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Relative to the noise around it.
    pub height: f64,
    /// rad/s.
    pub omega: f64,
    /// Of the highest of all.
    pub p_value: f64,
}

/// Tests the first channel.
pub fn test(left: &Left) -> Test {
    let Some(line) = highest(&left.channel(0), left.step * left.rows_per_reading()) else {
        return Test::silent("line", true);
    };
    Test {
        name: "line",
        statistic: line.height,
        p_value: line.p_value,
        closes: 2.0 * line.height,
        of_physics: true,
        windows: Vec::new(),
        words: format!(
            "a periodic moment at {} rad/s, {} times above the noise around it",
            digits(line.omega),
            digits(line.height)
        ),
    }
}

/// The line that chance is least likely to make. Where rows were left out between, a line loses height, noise nothing.
pub fn highest(values: &[f64], step: f64) -> Option<Line> {
    // At most one sample in 64 is left out at the end, so that the length can be halved down to DIRECT.
    let halvings = (values.len() / DIRECT).checked_ilog2().map_or(0, |h| h + 1);
    let length = values.len() >> halvings << halvings;
    let signal: Vec<Complex<f64>> = values[..length].iter().map(|&v| Complex::from(v)).collect();
    let power: Vec<f64> = transform(&signal).iter().map(Complex::norm_sqr).collect();
    let resolution = TAU / (length as f64 * step);
    let top = LINES[1].min(BELOW_NYQUIST * std::f64::consts::PI / step);
    let range = (LINES[0] / resolution).ceil() as usize..(top / resolution) as usize;
    let single = |i: usize| {
        let around = i.saturating_sub(AROUND[1]).max(range.start)..(i + AROUND[1] + 1).min(range.end);
        let noise: Vec<f64> = around.filter(|j| j.abs_diff(i) >= AROUND[0]).map(|j| power[j]).collect();
        let m = noise.len() as f64;
        let height = power[i] * m / noise.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let p_value = (-m * (height / m).ln_1p()).exp();
        (noise.len() >= FEWEST).then_some(Line { height, omega: i as f64 * resolution, p_value })
    };
    let best = range.clone().filter_map(single).min_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
    Some(Line { p_value: least_of(best.p_value, range.len()), ..best })
}

/// Σ x_k exp(−2πi jk/n): halved as often as n allows (Cooley and Tukey, 1965), then summed directly.
fn transform(x: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = x.len();
    let turn = |j: usize| Complex::from_polar(1.0, -TAU * j as f64 / n as f64);
    if n % 2 == 1 || n == 0 {
        let turns: Vec<Complex<f64>> = (0..n).map(turn).collect();
        return (0..n).map(|j| x.iter().enumerate().map(|(k, x)| x * turns[j * k % n]).sum()).collect();
    }
    let every_second =
        |from: usize| -> Vec<Complex<f64>> { x.iter().skip(from).step_by(2).copied().collect() };
    let (even, odd) = (transform(&every_second(0)), transform(&every_second(1)));
    let half = n / 2;
    let shifted: Vec<Complex<f64>> = odd.iter().enumerate().map(|(j, o)| turn(j) * o).collect();
    (0..n).map(|j| if j < half { even[j] + shifted[j] } else { even[j - half] - shifted[j - half] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::normal;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn the_transform_is_the_sum() {
        let x: Vec<Complex<f64>> =
            (0..24).map(|k| Complex::new((k * k % 7) as f64, (k % 5) as f64)).collect();
        for (j, y) in transform(&x).iter().enumerate() {
            let term =
                |(k, x): (usize, &Complex<f64>)| x * Complex::from_polar(1.0, -TAU * (j * k) as f64 / 24.0);
            let sum: Complex<f64> = x.iter().enumerate().map(term).sum();
            assert!((sum - y).norm() < 1e-10, "{j}: {sum} {y}");
        }
    }

    #[test]
    fn a_line_is_found_at_its_frequency_and_a_resonance_is_none() {
        let mut random = Pcg64::seed_from_u64(3);
        let mut values: Vec<f64> = (0..4000).map(|_| normal(&mut random)).collect();
        assert!(highest(&values, 0.02).unwrap().p_value > 0.01);
        // a resonance of the damping ratio 0.2 at 6 rad/s, four times as strong as the noise at its peak
        let (mut x, mut v) = (0.0, 0.0);
        let resonant: Vec<f64> = values
            .iter()
            .map(|noise| {
                v += 0.02 * (-36.0 * x - 2.4 * v) + normal(&mut random);
                x += 0.02 * v;
                noise + 0.5 * v
            })
            .collect();
        assert!(highest(&resonant, 0.02).unwrap().p_value > 1e-4);
        for (k, v) in values.iter_mut().enumerate() {
            *v += 0.3 * (7.0 * 0.02 * k as f64).sin();
        }
        let Line { height, omega, p_value } = highest(&values, 0.02).unwrap();
        assert!(height > 20.0 && (omega - 7.0).abs() < 0.1 && p_value < 1e-4, "{height} {omega} {p_value}");
    }
}
