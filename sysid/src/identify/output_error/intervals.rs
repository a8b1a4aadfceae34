//! How sure the estimates are.
//!
//! ```text
//! I = Σ s sᵀ / σ²                        information, initial states and offsets eliminated; Cramér–Rao: I⁻¹
//! P = H⁻¹ M H⁻¹,  H = Σ s sᵀ             corrected where the errors are not white:
//! M = 1/(L+1) Σ_w (Σ_{k∈w} s e) (·)ᵀ     all windows w of L+1 rows: Bartlett's weights (Newey, West, 1987)
//! ```
//!
//! The correction is used where the errors' correlation up to lag L is more than chance: Ljung's and Box's statistic
//! beyond its 99 % quantile, so one set in a hundred with white errors gets it too.

use super::colour::autocovariance;
use super::search::{At, Problem};
use crate::model::sampled::Parameter;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// L, s: longer than the errors are correlated.
const CORRELATED_S: f64 = 1.0;
/// Odds of a correction without need.
const NEEDLESS: f64 = 0.01;

/// Covariances of the free parameters.
pub(super) struct Covariances {
    /// Cramér–Rao.
    pub bound: DMatrix<f64>,
    /// The one that the intervals are made of.
    pub used: DMatrix<f64>,
    /// Whether it is corrected for coloured errors.
    pub corrected: bool,
}

/// Covariances at a minimum, over `free` parameters.
pub(super) fn covariances(problem: &Problem, at: &At, free: &[usize], ar: &[f64]) -> Option<Covariances> {
    let hessian = DMatrix::from_fn(free.len(), free.len(), |a, b| at.hessian[(free[a], free[b])]);
    let inverse = inverse(&hessian)?;
    let unknowns = free.len() + at.x0.len() * (problem.order() + 1) + ar.len();
    let variance = at.squares / at.rows.saturating_sub(unknowns).max(1) as f64;
    let bound = &inverse * variance;
    let window = (CORRELATED_S / problem.step).ceil() as usize + 1;
    let (middle, errors) = scores(problem, at, ar, window);
    if white(&errors, window, ar.len()) {
        return Some(Covariances { used: bound.clone(), bound, corrected: false });
    }
    let middle = DMatrix::from_fn(free.len(), free.len(), |a, b| middle[(free[a], free[b])]);
    Some(Covariances { used: &inverse * middle * &inverse, bound, corrected: true })
}

/// The inverse of a positive definite matrix, scaled to a unit diagonal first.
pub(super) fn inverse(m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = DVector::from_fn(m.nrows(), |i, _| m[(i, i)].max(f64::MIN_POSITIVE).sqrt());
    let unit = DMatrix::from_fn(m.nrows(), m.nrows(), |i, j| m[(i, j)] / (scale[i] * scale[j]));
    let inverse = unit.cholesky()?.inverse();
    Some(DMatrix::from_fn(m.nrows(), m.nrows(), |i, j| inverse[(i, j)] / (scale[i] * scale[j])))
}

/// M over all parameters, and the whitened errors by section. The derivatives are projected: what initial state and
/// offset of the section could explain is taken out of them.
fn scores(problem: &Problem, at: &At, ar: &[f64], window: usize) -> (DMatrix<f64>, Vec<Vec<f64>>) {
    let parameters: Vec<Parameter> = problem.coordinates.iter().map(|c| c.parameter).collect();
    let (unknowns, model) = (parameters.len(), problem.sensitivities(&at.theta, &parameters));
    let nuisance = model.order + 1;
    let (mut middle, mut all) = (DMatrix::zeros(unknowns, unknowns), Vec::new());
    for (index, section) in problem.sections.iter().enumerate() {
        let projections = at.projections(index, model.order);
        let (mut errors, mut sums) = (Vec::new(), vec![0.0; unknowns]);
        model.rows(section, &at.x0[index], ar, &mut |some| {
            for row in some.chunks_exact(model.width()) {
                let (own, rest) = row.split_at(nuisance);
                // the rows are linearised about the resolved initial state: only the offset is left
                let e = rest[unknowns] - at.offsets[index] * own[nuisance - 1];
                for (slope, projection) in rest.iter().zip(&projections) {
                    let left = slope - own.iter().zip(projection).map(|(g, c)| g * c).sum::<f64>();
                    sums.push(sums[sums.len() - unknowns] + left * e);
                }
                errors.push(e);
            }
        });
        let count = errors.len();
        for end in 1..count + window {
            let (to, from) = (end.min(count) * unknowns, end.saturating_sub(window) * unknowns);
            let part = DVector::from_fn(unknowns, |i, _| sums[to + i] - sums[from + i]);
            middle.ger(1.0 / window as f64, &part, &part, 1.0);
        }
        all.push(errors);
    }
    (middle, all)
}

/// Whether nothing speaks against white errors.
fn white(errors: &[Vec<f64>], lags: usize, fitted: usize) -> bool {
    let count: usize = errors.iter().map(Vec::len).sum();
    let (n, power) = (count as f64, autocovariance(errors, 0));
    let statistic: f64 = (1..=lags.min(count / 4))
        .map(|lag| n * (n + 2.0) / (n - lag as f64) * (autocovariance(errors, lag) / power).powi(2))
        .sum();
    ChiSquared::new(lags.saturating_sub(fitted).max(1) as f64)
        .is_ok_and(|chi| statistic < chi.inverse_cdf(1.0 - NEEDLESS))
}
