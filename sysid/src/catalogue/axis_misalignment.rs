//! The IMU is turned: it mixes the rates.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Picture, Scale, Signal};
use crate::model::pitch::Output;

/// q_meas = q cos a + p sin a.
pub struct AxisMisalignment;

impl Effect for AxisMisalignment {
    fn about(&self) -> About {
        About {
            id: "axis_misalignment",
            locus: Locus::Sensor,
            sentence: "the IMU is turned about its vertical axis and mixes roll into the pitch rate",
            equation: "q_meas = q cos(a) + p sin(a)",
            variable: "p",
            condition: "in proportion to the roll rate",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Measured(Signal::RollRate))
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "angle_deg",
            unit: "deg",
            lower: -60.0,
            upper: 60.0,
            scale: Scale::Linear(2.0),
        }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate && data.varies(|beside| beside.roll_rate.as_deref())
    }
    fn measure(&self, p: &[f64], _s: &[f64], y: Output, roll_rate: f64) -> Output {
        let (sin, cos) = p[0].to_radians().sin_cos();
        [y[0] * cos + roll_rate * sin, y[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_right_angle_shows_both_rates_alike() {
        let [rate, angle] = AxisMisalignment.measure(&[45.0], &[], [0.5, 0.1], 0.3);
        assert!((rate - 0.8 * 0.5_f64.sqrt()).abs() < 1e-12 && angle == 0.1);
        assert_eq!(AxisMisalignment.measure(&[0.0], &[], [0.5, 0.1], 0.3), [0.5, 0.1]);
    }
}
