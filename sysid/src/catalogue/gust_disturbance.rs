//! Recirculation, turbulence: a coloured moment that the input does not cause.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};

/// T ẇ = −w + noise, M += w.
///
/// It moves nothing that a simulation could repeat, so it is never tried as a term: the diagnosis
/// tells it by the spectrum of the disturbance.
pub struct GustDisturbance;

impl Effect for GustDisturbance {
    fn about(&self) -> About {
        About {
            id: "gust_disturbance",
            locus: Locus::Environment,
            sentence: "a slow random moment acts that the input does not cause (gusts, recirculation)",
            equation: "T dw/dt = -w + noise, M += w",
            variable: "t",
            condition: "at low frequencies, whatever the input does",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter {
                name: "sigma",
                unit: "N m",
                lower: 0.0,
                upper: 10.0 * data.moment,
                scale: Scale::Log,
            },
            Parameter { name: "T", unit: "s", lower: data.step, upper: data.duration, scale: Scale::Log },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        vec![vec![0.1 * data.moment, 1.0]]
    }
    fn applies(&self, _baseline: &Baseline, _data: &Dataset) -> bool {
        false
    }
}
