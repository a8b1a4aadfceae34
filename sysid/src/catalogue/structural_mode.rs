//! A bending mode of arm or frame, shaken by the control moment and seen by the IMU.

use super::spectral_lines::lines;
use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, ResidualMoment, Scale};
use crate::model::oscillator::oscillate;
use crate::model::pitch::Output;
use std::f64::consts::TAU;

/// η̈ + 2ζω η̇ + ω² η = g (∂M/∂u) u_a / Iyy, q_meas = q + η̇, θ_meas = θ + η.
pub struct StructuralMode;

/// Least frequency of a mode, rad/s.
const LEAST_OMEGA: f64 = 8.0;

impl Effect for StructuralMode {
    fn about(&self) -> About {
        About {
            id: "structural_mode",
            locus: Locus::PitchMoment,
            sentence: "a bending mode of the frame is shaken by the control moment and seen by the gyro",
            equation: "eta'' + 2 zeta omega eta' + omega^2 eta = g (dM/du) u_a / Iyy, q_meas = q + eta', theta_meas = theta + eta",
            variable: "u_rate",
            condition: "as ringing after each switch of the input",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::Resonance)
    }
    /// A mode that moves with the control moment alone and against it is a mount.
    fn generalises(&self, other: &dyn Effect) -> bool {
        other.about().id == "imu_mount"
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter {
                name: "omega",
                unit: "rad/s",
                lower: LEAST_OMEGA,
                upper: 1.2 / data.step,
                scale: Scale::Log,
            },
            Parameter { name: "zeta", unit: "1", lower: 0.001, upper: 0.3, scale: Scale::Log },
            Parameter { name: "gain", unit: "1", lower: -5.0, upper: 5.0, scale: Scale::Linear(0.1) },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let highest = 1.0 / data.step;
        let from = 0.16 * highest;
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|i: f64| vec![from * (highest / from).powf(i), 0.05, 0.1]).to_vec()
    }
    /// And where what is left stands out of its spectrum: a light mode is narrower than the gaps between the starts.
    fn starts_from(&self, data: &Amplitudes, left: &ResidualMoment) -> Vec<Vec<f64>> {
        let lines = lines(&left.moment, left.step, LEAST_OMEGA / TAU).into_iter();
        let at_lines = lines.map(|line| vec![TAU * line.frequency, 0.03, 0.1]);
        let seen = |start: &Vec<f64>| start[0] < 1.0 / data.step;
        self.starts(data).into_iter().chain(at_lines.filter(seen)).collect()
    }
    fn rings(&self, p: &[f64]) -> Option<[f64; 2]> {
        Some([p[0] / TAU, p[1]])
    }
    fn start_ringing(&self, f_hz: f64, zeta: f64) -> Option<Vec<f64>> {
        Some(vec![TAU * f_hz, zeta, 0.1])
    }
    fn states(&self) -> usize {
        2
    }
    fn within_sample(&self) -> bool {
        true
    }
    /// Exact for an acceleration that is constant over the step; states (η, η̇).
    fn sense(&self, p: &[f64], s: &mut [f64], _q: f64, _theta: f64, control: f64, at: &Conditions) {
        let (omega, zeta) = (p[0], p[1]);
        oscillate(s, omega, zeta, p[2] * control / (omega * omega), at.dt);
    }
    fn measure(&self, _p: &[f64], s: &[f64], y: Output, _roll_rate: f64) -> Output {
        [y[0] + s[1], y[1] + s[0]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_mode_is_looked_for_where_what_is_left_rings() {
        let data = Amplitudes { step: 0.02, ..Amplitudes::default() };
        let (omega, zeta) = (10.7, 0.03);
        let ringing = |k: usize| {
            let t = 0.02 * k as f64 % 9.0;
            (-zeta * omega * t).exp() * (omega * t).sin() + 0.3 * (0.7 * (k * k % 1009) as f64).sin()
        };
        let moment = (0..4000).map(ringing).collect();
        let left = ResidualMoment { start: 0.0, step: 0.02, moment, angle: Vec::new() };
        let starts = StructuralMode.starts_from(&data, &left);
        assert!(starts[5..].iter().any(|start| (start[0] / omega - 1.0).abs() < 0.05), "{starts:?}");
        let none = StructuralMode.starts_from(&data, &ResidualMoment::default());
        assert_eq!(none, StructuralMode.starts(&data));
    }
}
