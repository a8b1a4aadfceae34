//! The motor's magnets pull towards preferred angles.

use super::over_angle::{Ripple, most_periods, ripples, turned};
use super::spectral_lines::{PHASE, amid};
use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{
    About, Conditions, Effect, Locus, Parameter, Picture, ResidualMoment, Scale, Signal,
};
use std::f64::consts::TAU;

/// M += a sin(n θ + φ), n periods per turn.
pub struct Cogging;

/// The least number of periods within the angle that was turned through: of fewer it is a spring.
const PERIODS: f64 = 2.0;
/// Once per turn is a centre of gravity off the pivot.
const LEAST_PER_TURN: f64 = 1.5;

impl Effect for Cogging {
    fn about(&self) -> About {
        About {
            id: "cogging",
            locus: Locus::PitchMoment,
            sentence: "a moment repeats with the angle, as the cogging of a motor or the mesh of a gear gives",
            equation: "M += amplitude sin(n theta + phase)",
            variable: "theta",
            condition: "periodic in the angle, whatever the rate",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Hanselman, 1994")
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Angle))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let turned = turned(data);
        vec![
            Parameter {
                name: "amplitude",
                unit: "N m",
                lower: 1e-4 * data.moment,
                upper: 5.0 * data.moment,
                scale: Scale::Log,
            },
            Parameter {
                name: "n",
                unit: "1",
                lower: LEAST_PER_TURN.max(PERIODS * TAU / turned),
                upper: most_periods(turned),
                scale: Scale::Linear(0.5 * TAU / turned),
            },
            PHASE,
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let [_, n, _] = &self.parameters(data)[..] else { return Vec::new() };
        vec![vec![0.1 * data.moment, (2.0 * n.lower).min(n.upper), TAU]]
    }
    /// The two periods over the angle at which what is left stands out most from its surroundings.
    fn starts_from(&self, data: &Amplitudes, left: &ResidualMoment) -> Vec<Vec<f64>> {
        let lowest = LEAST_PER_TURN.max(1.2 * PERIODS * TAU / turned(data));
        let start =
            |ripple: Ripple| vec![ripple.amplitude.max(1e-3 * data.moment), ripple.n, amid(ripple.phase)];
        ripples(data, left, lowest).into_iter().map(start).collect()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_angle
    }
    fn turns(&self) -> Option<usize> {
        Some(2)
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], q: f64, theta: f64, at: &Conditions) -> f64 {
        // The mean over the step at this rate.
        let half = 0.5 * p[1] * q * at.dt;
        let share = if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { half.sin() / half };
        p[0] * share * (p[1] * theta + p[2]).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_mean_over_a_step_is_that_of_the_sine() {
        let (a, n, phase, dt) = (0.3, 7.0, 0.7, 0.01);
        let at = Conditions { dt, ..Conditions::default() };
        for k in -20..20 {
            let (q, theta) = (f64::from(k), 0.1 * f64::from(k));
            let ends = [theta - 0.5 * q * dt, theta + 0.5 * q * dt].map(|angle| (n * angle + phase).cos());
            let mean = if k == 0 { a * phase.sin() } else { a * (ends[0] - ends[1]) / (n * q * dt) };
            assert!((Cogging.moment(&[a, n, phase], &[], q, theta, &at) - mean).abs() < 1e-8, "{k}");
        }
    }

    #[test]
    fn it_starts_at_the_period_and_phase_that_are_left() {
        let (n, phase) = (7.0, 0.9);
        let angle: Vec<f64> = (0..8000)
            .map(|k| 30.0 * (0.013 * f64::from(k)).sin() + 3.0 * (0.11 * f64::from(k)).sin())
            .collect();
        let noise = |k: usize| 0.05 * ((k as f64 * 0.618_033_988_749_895).fract() - 0.5);
        let moment =
            angle.iter().enumerate().map(|(k, angle)| noise(k) + 0.02 * (n * angle + phase).sin()).collect();
        let data = Amplitudes { moment: 0.3, step: 0.01, turned: 66.0, ..Amplitudes::default() };
        let starts = Cogging.starts_from(&data, &ResidualMoment { start: 0.0, step: 0.01, moment, angle });
        let found = &starts[0];
        let around = TAU / data.turned;
        assert!((found[1] - n).abs() < 0.2 * around && (found[0] - 0.02).abs() < 6e-3, "{found:?}");
        let off = (found[2] - phase + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
        assert!(off.abs() < 0.6, "{found:?}");
        assert!(Cogging.starts_from(&data, &ResidualMoment::default()).is_empty());
    }
}
