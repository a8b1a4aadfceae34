//! Control effectiveness follows the supply voltage.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Picture, Scale, Signal};

/// ∂M/∂u (V/V̄)^n, V the supply voltage and V̄ its mean; thrust at a fixed throttle goes with about the square of it.
pub struct VoltageDroop;

impl Effect for VoltageDroop {
    fn about(&self) -> About {
        About {
            id: "voltage_droop",
            locus: Locus::Actuator,
            sentence: "control effectiveness follows the supply voltage",
            equation: "dM/du (V/V_mean)^n",
            variable: "voltage",
            condition: "at high supply voltage against low",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Gain(Signal::Voltage))
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "n", unit: "1", lower: 0.0, upper: 8.0, scale: Scale::Linear(0.2) }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![1.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.varies(|beside| beside.voltage.as_deref())
    }
    fn of_thrust(&self) -> bool {
        true
    }
    fn actuate(&self, p: &[f64], _s: &mut [f64], u: f64, at: &Conditions) -> f64 {
        u * (1.0 + at.voltage).max(0.0).powf(p[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_less_voltage_leaves_a_power_of_four_fifths() {
        let at = Conditions { voltage: -0.2, ..Conditions::default() };
        assert!((VoltageDroop.actuate(&[2.0], &mut [], 0.5, &at) - 0.32).abs() < 1e-15);
        let below = Conditions { voltage: -1.5, ..Conditions::default() };
        assert_eq!(VoltageDroop.actuate(&[1.0], &mut [], 0.5, &below), 0.0);
    }
}
