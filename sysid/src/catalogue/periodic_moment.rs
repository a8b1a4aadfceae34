//! A moment of one frequency: once per revolution, an imbalance.

use super::spectral_lines::{PHASE, amid, lines};
use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, ResidualMoment, Scale};
use std::f64::consts::{FRAC_PI_2, TAU};

/// M += a sin(2π f t + φ), t since the start of the recording.
pub struct PeriodicMoment;

/// The least number of periods within the data.
const PERIODS: f64 = 3.0;
/// The estimate of the moment trails the moment by up to a third of a turn.
const TRAILS: [f64; 2] = [0.3, 1.4];

impl Effect for PeriodicMoment {
    fn about(&self) -> About {
        About {
            id: "periodic_moment",
            locus: Locus::PitchMoment,
            sentence: "a moment of one frequency acts, as an imbalance gives once per revolution or a servo that hunts",
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
            PHASE,
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [1.0, 4.0].map(|f_hz| vec![0.1 * data.moment, f_hz, TAU]).to_vec()
    }
    /// The two frequencies at which what is left stands out most from its surroundings.
    fn starts_from(&self, data: &Amplitudes, left: &ResidualMoment) -> Vec<Vec<f64>> {
        let lowest = 1.5 * PERIODS / data.duration;
        let mut starts = Vec::new();
        for line in lines(&left.moment, left.step, lowest) {
            let f_hz = line.frequency;
            for trails in TRAILS {
                let phase = line.amplitude.arg() + FRAC_PI_2 - TAU * f_hz * left.start + trails;
                starts.push(vec![line.amplitude.norm().max(1e-3 * data.moment), f_hz, amid(phase)]);
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
        let starts = PeriodicMoment
            .starts_from(&data, &ResidualMoment { start: 1.0, step: 0.02, moment, angle: Vec::new() });
        let (found, around) = (&starts[0], 1.0 / data.duration);
        assert!((found[1] - f_hz).abs() < 0.2 * around && (found[0] - 0.02).abs() < 4e-3, "{found:?}");
        let late = (found[2] - phase - TRAILS[0]).rem_euclid(TAU);
        assert!(late.min(TAU - late) < 0.5, "{found:?}");
        assert!(PeriodicMoment.starts_from(&data, &ResidualMoment::default()).is_empty());
    }
}
