//! A moment of one frequency: once per revolution, an imbalance.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, ResidualMoment, Scale};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f64::consts::{FRAC_PI_2, TAU};

/// M += a sin(2π f t + φ), t since the start of the recording.
pub struct PeriodicMoment;

/// Lines on each side of a frequency among which its power is compared.
const AROUND: usize = 40;
/// Zeros behind the data, as multiples of their length: the grid of frequencies is as much finer.
const FINER: usize = 4;
/// Lines this far apart, in units of one over the data's length, are not of one peak.
const APART: usize = 3;
/// The least number of periods within the data.
const PERIODS: f64 = 3.0;
/// The estimate of the moment trails the moment by up to a third of a turn.
const TRAILS: [f64; 2] = [0.3, 1.4];

impl Effect for PeriodicMoment {
    fn about(&self) -> About {
        About {
            id: "periodic_moment",
            locus: Locus::PitchMoment,
            sentence: "a moment of one frequency acts, as an imbalance gives once per revolution",
            equation: "M += amplitude sin(2 pi f_hz t + phase)",
            variable: "t",
            condition: "at one frequency, whatever the input does",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter {
                name: "amplitude",
                unit: "N m",
                lower: 1e-4 * data.moment,
                upper: 5.0 * data.moment,
                scale: Scale::Log,
            },
            Parameter {
                name: "f_hz",
                unit: "Hz",
                lower: PERIODS / data.duration,
                // Of fewer than two and a half samples a period a line is not told from its alias.
                upper: 0.4 / data.step,
                scale: Scale::Linear(0.5 / data.duration),
            },
            // Two turns, so that no phase stands at a bound.
            Parameter { name: "phase", unit: "rad", lower: 0.0, upper: 2.0 * TAU, scale: Scale::Linear(0.5) },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [1.0, 4.0].map(|f_hz| vec![0.1 * data.moment, f_hz, TAU]).to_vec()
    }
    /// The two frequencies at which what is left stands out most from its surroundings.
    fn starts_from(&self, data: &Amplitudes, left: &ResidualMoment) -> Vec<Vec<f64>> {
        let lowest = 1.5 * PERIODS / data.duration;
        let mut starts = Vec::new();
        for (f_hz, line) in lines(left, lowest) {
            for trails in TRAILS {
                let phase = line.arg() + FRAC_PI_2 - TAU * f_hz * left.start + trails;
                starts.push(vec![
                    line.norm().max(1e-3 * data.moment),
                    f_hz,
                    (phase - 0.5 * TAU).rem_euclid(TAU) + 0.5 * TAU,
                ]);
            }
        }
        starts
    }
    fn turns(&self) -> Option<usize> {
        Some(2)
    }
    fn acts_at_frequency(&self, p: &[f64]) -> Option<f64> {
        Some(p[1])
    }
    fn forcing(&self, p: &[f64], at: &Conditions) -> f64 {
        let omega = TAU * p[1];
        let half = 0.5 * omega * at.dt;
        // The mean of a sine over the step.
        p[0] * (omega * (at.t + 0.5 * at.dt) + p[2]).sin()
            * (1.0 - half * half / 6.0 * (1.0 - half * half / 20.0))
    }
}

/// Frequency in Hz and complex amplitude (of cos ωt and −sin ωt) of the two lines above `lowest` Hz that stand out most from
/// the median of their surroundings.
fn lines(left: &ResidualMoment, lowest: f64) -> Vec<(f64, Complex<f64>)> {
    let n = left.moment.len();
    if n < 2 * AROUND {
        return Vec::new();
    }
    let mean = left.moment.iter().sum::<f64>() / n as f64;
    let window = |k: usize| 1.0 - (TAU * (k as f64 + 0.5) / n as f64).cos();
    let mut buffer: Vec<Complex<f64>> =
        left.moment.iter().enumerate().map(|(k, m)| Complex::from((m - mean) * window(k))).collect();
    buffer.resize((FINER * n).next_power_of_two(), Complex::default());
    FftPlanner::new().plan_fft_forward(buffer.len()).process(&mut buffer);
    let spacing = 1.0 / (left.step * buffer.len() as f64);
    let power: Vec<f64> =
        buffer.iter().take((0.9 * buffer.len() as f64 / 2.0) as usize).map(Complex::norm_sqr).collect();
    // Every line of the unpadded grid, then the finer one beside the highest.
    let stride = buffer.len() / n;
    let coarse: Vec<usize> = ((lowest / spacing).ceil() as usize..power.len()).step_by(stride).collect();
    let prominence = |place: usize| {
        let (from, to) = (place.saturating_sub(AROUND), (place + AROUND + 1).min(coarse.len()));
        let mut around: Vec<f64> = coarse[from..to].iter().map(|&j| power[j]).collect();
        let middle = around.len() / 2;
        power[coarse[place]] / around.select_nth_unstable_by(middle, f64::total_cmp).1.max(f64::MIN_POSITIVE)
    };
    let mut ranked: Vec<(f64, usize)> = (0..coarse.len()).map(|place| (prominence(place), place)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut peaks: Vec<usize> = Vec::new();
    for (_, place) in ranked {
        if peaks.len() < 2 && peaks.iter().all(|&other| place.abs_diff(other) > APART) {
            peaks.push(place);
        }
    }
    let amplitude = |j: usize| buffer[j] * (2.0 / n as f64);
    let finest = |place: usize| {
        let (from, to) =
            (coarse[place].saturating_sub(stride), (coarse[place] + stride + 1).min(power.len()));
        (from..to).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap_or(coarse[place])
    };
    peaks.into_iter().map(finest).map(|j| (spacing * j as f64, amplitude(j))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_mean_over_a_step_is_that_of_the_sine() {
        let (a, f_hz, phase, dt) = (0.3, 4.0, 0.7, 0.01);
        let omega = TAU * f_hz;
        for k in 0..50 {
            let t = dt * f64::from(k);
            let mean = a * ((omega * t + phase).cos() - (omega * (t + dt) + phase).cos()) / (omega * dt);
            let at = Conditions { t, dt, ..Conditions::default() };
            assert!((PeriodicMoment.forcing(&[a, f_hz, phase], &at) - mean).abs() < 1e-8);
        }
    }

    #[test]
    fn it_starts_at_the_frequency_and_phase_that_are_left() {
        let data = Amplitudes { moment: 0.3, step: 0.02, duration: 90.0, ..Amplitudes::default() };
        let (f_hz, phase) = (2.347, 0.9);
        let mut slow = 0.0;
        let moment = (0..4400)
            .map(|k| {
                let t = 1.0 + 0.02 * f64::from(k);
                slow = 0.98 * slow + 0.01 * ((f64::from(k) * 0.618_033_988_749_895).fract() - 0.5);
                slow + 0.02 * (TAU * f_hz * t + phase).sin()
            })
            .collect();
        let starts = PeriodicMoment.starts_from(&data, &ResidualMoment { start: 1.0, step: 0.02, moment });
        let (found, around) = (&starts[0], 1.0 / data.duration);
        assert!((found[1] - f_hz).abs() < 0.2 * around && (found[0] - 0.02).abs() < 4e-3, "{found:?}");
        let late = (found[2] - phase - TRAILS[0]).rem_euclid(TAU);
        assert!(late.min(TAU - late) < 0.5, "{found:?}");
        assert!(PeriodicMoment.starts_from(&data, &ResidualMoment::default()).is_empty());
    }
}
