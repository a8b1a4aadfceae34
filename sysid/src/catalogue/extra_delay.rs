//! The loop delay is not what the model says.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Picture, Scale};

/// u(t − τ − Δ).
pub struct ExtraDelay;

impl Effect for ExtraDelay {
    fn about(&self) -> About {
        About {
            id: "extra_delay",
            locus: Locus::Timing,
            sentence: "the loop delay differs from the one in the model",
            equation: "u(t - tau - Delta)",
            variable: "u_rate",
            condition: "for one delay after each switch of the input",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::Phase)
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::StepResponse)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "Delta",
            unit: "s",
            lower: -0.06,
            upper: 0.2,
            scale: Scale::Linear(data.step),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.5 * data.step], vec![0.05], vec![-0.05]]
    }
    fn applies(&self, baseline: &Baseline, _data: &Dataset) -> bool {
        !baseline.delay_free
    }
    fn delay(&self, p: &[f64], _at: &Conditions) -> f64 {
        p[0]
    }
}
