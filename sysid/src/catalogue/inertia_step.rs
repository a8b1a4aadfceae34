//! Mass or inertia changes at a moment in time.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};

/// Iyy → Iyy (1 + δ) for t > t*.
pub struct InertiaStep;

impl Effect for InertiaStep {
    fn about(&self) -> About {
        About {
            id: "inertia_step",
            locus: Locus::PitchMoment,
            sentence: "the inertia changes at a moment in time",
            equation: "Iyy -> Iyy (1 + delta) for t > t_star",
            variable: "t",
            condition: "from one moment on",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter { name: "delta", unit: "1", lower: -0.8, upper: 3.0, scale: Scale::Linear(0.1) },
            Parameter {
                name: "t_star",
                unit: "s",
                lower: 0.0,
                upper: data.duration,
                scale: Scale::Linear(0.05 * data.duration),
            },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        (1..20).map(|i| vec![0.1, 0.05 * f64::from(i) * data.duration]).collect()
    }
    fn begins_at(&self) -> Option<usize> {
        Some(1)
    }
    fn within_sample(&self) -> bool {
        true
    }
    fn inertia(&self, p: &[f64], at: &Conditions) -> f64 {
        // The share of the step after the change, so that the likelihood moves smoothly with t*.
        1.0 + p[0] * ((at.t + at.dt - p[1]) / at.dt).clamp(0.0, 1.0)
    }
}
