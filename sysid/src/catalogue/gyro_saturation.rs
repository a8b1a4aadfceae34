//! The gyro clips.

use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;
use crate::model::effect::{About, Effect, Locus, Parameter, Scale};
use crate::model::pitch::Output;

/// |q_meas| ≤ q_max. Where the log shows the reading at which the rate clips, that is q_max, and nothing is left to fit: a
/// fit would take a lower one, because the mean of a rate that is not known exactly, once clipped, lies below the limit. Of a
/// rate whose largest value does not recur the log does not show that it clips: it may level off for another reason.
pub struct GyroSaturation;

/// Share to which a limit is read off a log.
const READ_OFF: f64 = 1e-4;

impl Effect for GyroSaturation {
    fn about(&self) -> About {
        About {
            id: "gyro_saturation",
            locus: Locus::Sensor,
            sentence: "the gyro clips",
            equation: "|q_meas| <= q_max",
            variable: "q",
            condition: "at the largest pitch rates",
        }
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let [lower, upper] = match data.rate_limit {
            Some(limit) => [1.0 - READ_OFF, 1.0 + READ_OFF].map(|share| share * limit),
            None => [0.5 * data.q, 6.0 * data.q],
        };
        vec![Parameter { name: "q_max", unit: "rad/s", lower, upper, scale: Scale::Log }]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        match data.rate_limit {
            Some(limit) => vec![vec![limit]],
            None => [1.2, 1.6, 2.1].map(|share| vec![share * data.q]).to_vec(),
        }
    }
    fn beyond_data(&self, _p: &[f64], data: &Amplitudes) -> Option<usize> {
        data.rate_limit.map(|_| 0)
    }
    fn applies(&self, _baseline: &Baseline, data: &Dataset) -> bool {
        data.has_rate && data.rate_clips
    }
    fn limit(&self, p: &[f64], y: Output) -> Output {
        [y[0].clamp(-p[0], p[0]), y[1]]
    }
}
