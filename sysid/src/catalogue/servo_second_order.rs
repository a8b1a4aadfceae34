//! The servo rings.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale};
use crate::model::oscillator::oscillate;

/// ü_a = ω² (u_c − u_a) − 2ζω u̇_a with ω = 2π f and ζ < 1.
pub struct ServoSecondOrder;

impl Effect for ServoSecondOrder {
    fn about(&self) -> About {
        About {
            id: "servo_second_order",
            locus: Locus::Actuator,
            sentence: "the servo follows the command with a resonance of its own",
            equation: "u_a'' = w^2 (u_c - u_a) - 2 zeta w u_a', w = 2 pi f_hz",
            variable: "u_rate",
            condition: "as an overshoot that rings off after each switch of the input",
        }
    }
    fn generalises(&self, other: &dyn Effect) -> bool {
        other.about().id == "servo_lag"
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter { name: "f_hz", unit: "Hz", lower: 0.3, upper: 0.4 / data.step, scale: Scale::Log },
            Parameter { name: "zeta", unit: "1", lower: 0.02, upper: 0.98, scale: Scale::Log },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.022, 0.045, 0.09, 0.18].map(|share| vec![share / data.step, 0.3]).to_vec()
    }
    fn rings(&self, p: &[f64]) -> Option<[f64; 2]> {
        Some([p[0], p[1]])
    }
    fn start_ringing(&self, f_hz: f64, zeta: f64) -> Option<Vec<f64>> {
        Some(vec![f_hz, zeta])
    }
    fn states(&self) -> usize {
        2
    }
    fn carries_thrust(&self) -> bool {
        true
    }
    /// Exact for a command that is constant over the step; answers the mean of u_a over it.
    fn actuate(&self, p: &[f64], s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        let omega = std::f64::consts::TAU * p[0];
        let before = [s[0], s[1]];
        oscillate(s, omega, p[1], u, at.dt);
        let gained = (s[1] - before[1]) / omega + 2.0 * p[1] * (s[0] - before[0]);
        u - gained / (omega * at.dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_answers_a_step_in_closed_form() {
        let (f_hz, zeta, dt) = (3.0_f64, 0.2_f64, 0.01);
        let at = Conditions { dt, ..Conditions::default() };
        let (mut s, mut sum) = ([0.0; 2], 0.0);
        let omega = std::f64::consts::TAU * f_hz;
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        for k in 1..=100 {
            sum += ServoSecondOrder.actuate(&[f_hz, zeta], &mut s, 0.5, &at) * dt;
            let t = dt * f64::from(k);
            let (sin, cos) = (damped * t).sin_cos();
            let decay = (-zeta * omega * t).exp();
            let expected = 0.5 * (1.0 - decay * (cos + zeta * omega / damped * sin));
            assert!((s[0] - expected).abs() < 1e-12, "{k}");
        }
        // its integral: u t − (2ζ u_a + u̇_a/ω)/ω
        assert!((sum - (0.5 - (2.0 * zeta * s[0] + s[1] / omega) / omega)).abs() < 1e-12);
    }
}
