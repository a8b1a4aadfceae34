//! A background with a slow moment beside the band-passed one.

use super::gust_disturbance::GustDisturbance;
use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Parameter, Scale};
use crate::model::noise::{Gust, Third};

/// The moment of [`GustDisturbance`] in the noise model, σ relative to the noise of the first channel. Whether it is a gust,
/// or a fact about the day, is asked when the model stands.
pub struct SlowMoment;

impl Effect for SlowMoment {
    fn about(&self) -> About {
        GustDisturbance.about()
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let unit = 10.0 * data.moment / data.q;
        vec![
            Parameter { name: "sigma", unit: "1", lower: 1e-5 * unit, upper: 1e5 * unit, scale: Scale::Log },
            Parameter { name: "T", unit: "s", lower: data.step, upper: data.duration, scale: Scale::Log },
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        let unit = 10.0 * data.moment / data.q;
        [0.1, 1.0, 10.0].map(|share| vec![share * unit, 1.0]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, _data: &Dataset) -> bool {
        false
    }
    fn is_background(&self) -> bool {
        true
    }
    fn noise(&self, p: &[f64]) -> Option<Third> {
        Some(Third::Gust(Gust { sigma: p[0], time_constant: p[1] }))
    }
}
