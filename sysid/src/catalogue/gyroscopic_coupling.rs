//! In free flight roll and yaw couple into pitch.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};

/// M += ΔI p r; ΔI is expected at Izz − Ixx. What the angle has of roll and yaw, θ̇ = q cos φ − r sin φ, every model has.
pub struct GyroscopicCoupling;

impl Effect for GyroscopicCoupling {
    fn about(&self) -> About {
        About {
            id: "gyroscopic_coupling",
            locus: Locus::PitchMoment,
            sentence: "roll and yaw rates couple into pitch",
            equation: "M += dI p r",
            variable: "p r",
            condition: "when roll and yaw rates are large together",
        }
    }
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter { name: "dI", unit: "kg m^2", lower: -2.0, upper: 2.0, scale: Scale::Linear(0.01) }]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.runs.iter().all(|run| run.beside.roll_and_yaw.is_some())
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn moment(&self, p: &[f64], _s: &[f64], _q: f64, _theta: f64, at: &Conditions) -> f64 {
        p[0] * at.roll_rate * at.yaw_rate
    }
}
