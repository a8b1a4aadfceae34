//! A bending mode of arm or frame, shaken by the control moment and seen by the IMU.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Scale};
use crate::model::oscillator::oscillate;
use crate::model::pitch::Output;

/// η̈ + 2ζω η̇ + ω² η = g (∂M/∂u) u_a / Iyy, q_meas = q + η̇, θ_meas = θ + η.
pub struct StructuralMode;

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
            Parameter { name: "omega", unit: "rad/s", lower: 8.0, upper: 1.2 / data.step, scale: Scale::Log },
            Parameter { name: "zeta", unit: "1", lower: 0.001, upper: 0.3, scale: Scale::Log },
            Parameter { name: "gain", unit: "1", lower: -5.0, upper: 5.0, scale: Scale::Linear(0.1) },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let highest = 1.0 / data.step;
        let from = 0.16 * highest;
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|i: f64| vec![from * (highest / from).powf(i), 0.05, 0.1]).to_vec()
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
