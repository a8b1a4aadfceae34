//! A servo that moves otherwise up than down, under load or by a worn spring: T u̇a = uc − ua, T = T_up while uc > ua,
//! T_down while uc < ua.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "asymmetric_servo",
    locus: "actuator",
    parameters: &[
        Parameter { name: "T_up", unit: "s", range: [0.06, 0.22], signed: false },
        Parameter { name: "T_down", unit: "s", range: [0.01, 0.05], signed: false },
    ],
    moderate_and_strong: [0.101, 0.155],
    near: &[],
    make: |values, _| Box::new(AsymmetricServo { up_s: values[0], down_s: values[1], position: 0.0 }),
};

#[derive(Debug)]
struct AsymmetricServo {
    up_s: f64,
    down_s: f64,
    position: f64,
}

impl Effect for AsymmetricServo {
    /// Mean of the exact exponential over the step: the position never crosses a held command.
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        let before = self.position;
        let time_constant_s = if u > before { self.up_s } else { self.down_s };
        if time_constant_s <= 0.0 {
            self.position = u;
            return u;
        }
        self.position = u + (before - u) * (-dt / time_constant_s).exp();
        u + (before - self.position) * time_constant_s / dt
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_and_down_are_exponentials_of_their_own() {
        let mut servo = AsymmetricServo { up_s: 0.2, down_s: 0.05, position: 0.0 };
        (0..100).for_each(|_| _ = servo.blade(0.0, 1.0, 1e-3));
        let risen = 1.0 - (-0.5_f64).exp();
        assert!((servo.position - risen).abs() < 1e-12);
        let area: f64 = (0..100).map(|_| 1e-3 * servo.blade(0.0, 0.0, 1e-3)).sum();
        assert!((servo.position - risen * (-2.0_f64).exp()).abs() < 1e-12);
        assert!((area - 0.05 * risen * (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
    }
}
