//! The encoder's reading errs with the angle.

use super::over_angle::{most_periods, ripples, turned};
use super::spectral_lines::PHASE;
use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, ResidualMoment, Scale};
use crate::model::pitch::Output;
use std::f64::consts::TAU;

/// θ_meas = θ + a sin(n θ + φ): n = 1 for a disc that is not centred, 2 for a magnet off its axis, the number of lines for an
/// interpolation that is not even.
pub struct EncoderError;

/// The least number of periods within the angle that was turned through: of less it is a wrong gain.
const PERIODS: f64 = 1.0;
const LEAST_PER_TURN: f64 = 0.8;
/// Numbers of periods per turn, and phases, that are tried.
const USUAL: [f64; 2] = [1.0, 2.0];
const PHASES: usize = 3;

impl Effect for EncoderError {
    fn about(&self) -> About {
        About {
            id: "encoder_error",
            locus: Locus::Sensor,
            sentence: "the measured angle errs periodically with the angle, as an eccentric disc or a magnet off its axis makes it",
            equation: "theta_meas = theta + amplitude sin(n theta + phase)",
            variable: "theta",
            condition: "periodic in the angle, in the measured angle alone",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let turned = turned(data);
        let lower = LEAST_PER_TURN.max(PERIODS * TAU / turned);
        vec![
            Parameter { name: "amplitude", unit: "rad", lower: 1e-5, upper: 0.3, scale: Scale::Log },
            Parameter {
                name: "n",
                unit: "1",
                lower,
                upper: most_periods(turned),
                scale: Scale::Linear(0.5 * TAU / turned),
            },
            PHASE,
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let [_, n, _] = &self.parameters(data)[..] else { return Vec::new() };
        let usual = USUAL.into_iter().filter(|usual| *usual > n.lower && *usual < n.upper);
        usual.flat_map(|n| from_any_phase(0.01, n)).collect()
    }
    /// The usual numbers of periods, and the two at which what is left stands out most over the angle.
    fn starts_from(&self, data: &Amplitudes, left: &ResidualMoment) -> Vec<Vec<f64>> {
        let lowest = LEAST_PER_TURN.max(1.2 * PERIODS * TAU / turned(data));
        let left = ripples(data, left, lowest).into_iter().take(1);
        let further = left.flat_map(|ripple| from_any_phase(0.05 / ripple.n, ripple.n));
        self.starts(data).into_iter().chain(further).collect()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_angle
    }
    fn turns(&self) -> Option<usize> {
        Some(2)
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, _roll_rate: f64) -> Output {
        [y[0], y[1] + p[0] * (p[1] * y[1] + p[2]).sin()]
    }
}

fn from_any_phase(amplitude: f64, n: f64) -> Vec<Vec<f64>> {
    (0..PHASES).map(|k| vec![amplitude, n, (0.5 + k as f64 / PHASES as f64) * TAU]).collect()
}
