//! Free play in the pitch linkage.

use crate::dataset::{Amplitudes, Dataset};
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Class, Conditions, Effect, Locus, Parameter, Scale};

/// Play operator of half-width b.
pub struct LinkageBacklash;

impl Effect for LinkageBacklash {
    fn about(&self) -> About {
        About {
            id: "linkage_backlash",
            locus: Locus::Actuator,
            sentence: "the linkage of the blades has free play",
            equation: "play operator of half-width b on u",
            variable: "u",
            condition: "after each reversal of the command",
        }
    }
    fn class(&self) -> Option<Class> {
        Some(Class::SmallSignals)
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![Parameter {
            name: "b",
            unit: "rad",
            lower: 0.0,
            upper: 1.5 * data.u,
            scale: Scale::Linear(0.1 * data.u),
        }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.1, 0.35].map(|share| vec![share * data.u]).to_vec()
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        !data.two_levels
    }
    fn states(&self) -> usize {
        1
    }
    fn actuate(&self, p: &[f64], s: &mut [f64], u: f64, _at: &Conditions) -> f64 {
        s[0] = s[0].clamp(u - p[0], u + p[0]);
        s[0]
    }
}
