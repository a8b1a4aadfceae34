//! How accurately recordings tell a plant: the Cramér–Rao bound at the maximum of the likelihood,
//!
//! ```text
//! cov Θ̂ ≥ H⁻¹,      H = Σ J_kᵀ W J_k
//! ```
//!
//! with the noise model, and the mount where there is one, unknown beside the plant (Ljung, System Identification, 2nd ed., ch. 9).
//! Where the scores of blocks vary by more than H says, the interval is that of the blocks ([`Information::deviations`]).

use super::blow_up::no_likelihood;
use super::evidence::Information;
use super::fit::fit_baseline;
use super::problem::Problem;
use crate::dataset::Dataset;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::model::baseline::Baseline;
use crate::model::file::ModelFile;
use crate::recording::Recording;

/// The unknowns of the plant and of the effects in `model`, estimated from `recordings` with their 95 % intervals: `dM_dq`,
/// `dM_du`, `delay`, the mount's, and those of the effects by `id.parameter`. The search starts from `model`.
///
/// # Errors
/// Recordings that do not go together, no finite likelihood.
pub fn precision(recordings: &[Recording], model: &ModelFile) -> Result<Vec<Estimate>, Error> {
    let data = Dataset::new(recordings)?;
    let baseline = Baseline { delay_free: true, ..Baseline::from_model(model, &data)? };
    let problem = Problem::new(&data, &baseline, &[]);
    let fit = fit_baseline(&problem).ok_or_else(|| no_likelihood(&problem))?;
    let information = Information::new(&problem, &fit, &[]).ok_or_else(|| no_likelihood(&problem))?;
    let values = &fit.minimum.values;
    let deviations = information.deviations(values);
    let estimate = |(i, unknown): (usize, crate::optim::levenberg_marquardt::Coordinate)| {
        Estimate::new(&unknown.name, &unknown.unit, values[i], deviations[i], unknown.bounds)
    };
    let unknowns = problem.coordinates(&[]).into_iter().take(problem.plant_unknowns());
    Ok(unknowns.enumerate().map(estimate).collect())
}
