//! The white noise of the first measured channel.

use super::fit::Fit;
use super::problem::Problem;

/// Standard deviation of the first channel's white noise: that of its innovations, less what the state's uncertainty
/// adds to it.
pub fn sensor_noise(problem: &Problem<'_>, fit: &Fit) -> Option<f64> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let run = problem.data.runs.first()?;
    let model = problem.model(&unpacked, run.step)?;
    let gain = model.gain(&unpacked.disturbance, run)?;
    let (rate, angle) = model.measured();
    let first = if problem.data.has_rate { rate } else { angle };
    let residuals = &fit.minimum.residuals;
    let variance = residuals.iter().map(|e| e[0] * e[0]).sum::<f64>() / residuals.len().max(1) as f64;
    Some((variance * (1.0 - gain.begin.first()?[first]).max(0.0)).sqrt())
}
