//! The servo follows with another lag up than down.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale};

/// T u̇_a = u_c − u_a with T = T_up while the command is above the position, T_down while it is below; with the same lag
/// each way it is `servo_lag`.
pub struct AsymmetricServo;

impl Effect for AsymmetricServo {
    fn about(&self) -> About {
        About {
            id: "asymmetric_servo",
            locus: Locus::Actuator,
            sentence: "the servo (or the rotor) follows the command faster one way than the other",
            equation: "T du_a/dt = u_c - u_a, T = T_up for u_c > u_a, T_down for u_c < u_a",
            variable: "u_rate",
            condition: "for a few tenths of a second after each switch of the input, unlike up and down",
        }
    }
    fn generalises(&self, other: &dyn Effect) -> bool {
        other.about().id == "servo_lag"
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let (lower, upper) = (0.2 * data.step, 0.5);
        ["T_up", "T_down"].map(|name| Parameter { name, unit: "s", lower, upper, scale: Scale::Log }).to_vec()
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1, 0.04], vec![0.04, 0.1]]
    }
    fn moves_the_mean(&self) -> bool {
        true
    }
    fn states(&self) -> usize {
        1
    }
    /// Exact for a command that is constant over the step; answers the mean of u_a over it.
    fn actuate(&self, p: &[f64], s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        let before = s[0];
        let lag = p[usize::from(u < before)];
        let passed = -(-at.dt / lag).exp_m1();
        s[0] = before + (u - before) * passed;
        u + (before - u) * passed * lag / at.dt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_with_one_time_constant_and_falls_with_the_other() {
        let at = Conditions { dt: 0.01, ..Conditions::default() };
        let mut s = [0.0];
        let mut after = |u: f64, steps: usize| {
            for _ in 0..steps {
                AsymmetricServo.actuate(&[0.05, 0.2], &mut s, u, &at);
            }
            s[0]
        };
        let top = 1.0 - (-2.0_f64).exp();
        assert!((after(1.0, 10) - top).abs() < 1e-12);
        assert!((after(0.0, 20) - top * (-1.0_f64).exp()).abs() < 1e-12);
    }
}
