//! Whether the input has a line of its own at a frequency: what moves the craft there may be the input's, answered otherwise than
//! the model answers, or (in a loop) the input may be the motion's. A moment of that frequency is no finding then.

use crate::likelihood::problem::Problem;
use rustfft::num_complex::Complex;
use std::f64::consts::TAU;

/// Ordinates on each side that make the noise around a line, two apart, and the nearest of them: the line leaks into those between.
const AROUND: [usize; 2] = [2, 12];
/// Height over the median of those from which on it is a line: one in a million by chance.
const A_LINE: f64 = 20.0;

/// Whether the input of the longest run has a line at `f_hz`.
pub fn input_has_line(problem: &Problem<'_>, f_hz: f64) -> bool {
    let longest = problem.data.runs.iter().max_by_key(|run| run.len());
    longest.is_some_and(|run| has_line(&run.u, run.step, f_hz))
}

/// By its periodogram under Hann's window.
fn has_line(signal: &[f64], step: f64, f_hz: f64) -> bool {
    let n = signal.len() as f64;
    let mean = signal.iter().sum::<f64>() / n;
    let power = |f: f64| {
        let turn = TAU * f * step;
        let weighted = signal.iter().enumerate().map(|(k, x)| {
            let window = 1.0 - (TAU * (k as f64 + 0.5) / n).cos();
            Complex::from_polar((x - mean) * window, -turn * k as f64)
        });
        weighted.sum::<Complex<f64>>().norm_sqr()
    };
    let ordinate = 1.0 / (n * step);
    let [from, to] = AROUND;
    let places = (from..=to).flat_map(|j| [-2.0, 2.0].map(|side| f_hz + side * j as f64 * ordinate));
    let mut around: Vec<f64> = places.filter(|f| *f > 0.0).map(power).collect();
    around.sort_by(f64::total_cmp);
    around.get(around.len() / 2).is_some_and(|median| power(f_hz) > A_LINE * median)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_in_noise_is_a_line_and_the_noise_beside_it_is_none() {
        let mut state = 7_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        let (step, f_hz) = (0.02, 3.3);
        let tone: Vec<f64> =
            (0..3000).map(|k| noise() + 0.2 * (TAU * f_hz * step * f64::from(k)).sin()).collect();
        assert!(has_line(&tone, step, f_hz));
        let beside = (1..40).filter(|j| has_line(&tone, step, f_hz + 0.2 * f64::from(*j))).count();
        assert_eq!(beside, 0);
        assert!(!has_line(&[], step, f_hz) && !has_line(&[0.0; 100], step, f_hz));
    }
}
