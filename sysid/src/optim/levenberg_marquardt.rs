//! Levenberg–Marquardt for the prediction-error criterion with a free innovations covariance,
//!
//! ```text
//! V(z) = N/2 · log det( 1/N Σ e eᵀ ) + 1/2 Σ ((z_i − m_i)/s_i)²
//! ```
//!
//! over bounded coordinates z, with Jacobians by forward differences (Ljung, System Identification, 2nd ed., ch. 10).

use crate::model::pitch::Output;
use nalgebra::{DMatrix, DVector, Matrix2};
use rayon::prelude::*;

/// One unknown, in the coordinate that the search uses.
#[derive(Clone, Debug)]
pub struct Coordinate {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the parameter.
    pub unit: String,
    /// Bounds of the parameter.
    pub bounds: [f64; 2],
    /// Searched on the logarithm; otherwise in units of `unit_step`.
    pub log: bool,
    /// One step of a linear coordinate.
    pub unit_step: f64,
    /// Prior knowledge: centre, and standard deviation in the search coordinate.
    pub prior: Option<(f64, f64)>,
}

impl Coordinate {
    /// The search coordinate z of a value.
    pub fn inner(&self, value: f64) -> f64 {
        if self.log { value.max(f64::MIN_POSITIVE).ln() } else { value / self.unit_step }
    }
    fn unbounded(&self, z: f64) -> f64 {
        if self.log { z.exp() } else { z * self.unit_step }
    }
    /// The value at z, within the bounds.
    pub fn outer(&self, z: f64) -> f64 {
        self.unbounded(z).clamp(self.bounds[0], self.bounds[1])
    }
    /// d value / d z at `value`.
    pub fn stretch(&self, value: f64) -> f64 {
        if self.log { value } else { self.unit_step }
    }
}

/// A minimum of the criterion.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Parameters.
    pub values: Vec<f64>,
    /// 2 V without the prior's part: −2 log likelihood up to a constant.
    pub deviance: f64,
    /// 2 V with the prior's part.
    pub criterion: f64,
    /// Residuals at the minimum.
    pub residuals: Vec<Output>,
    /// Whether the search settled within the allowed iterations.
    pub converged: bool,
    /// By how much the last step lowered the criterion.
    pub drop: f64,
}

/// What stops the search.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Most iterations.
    pub iterations: usize,
    /// Settled when an iteration lowers 2 V by less than this.
    pub tolerance: f64,
}

/// The residuals to be made small, as a function of the parameters; `None` where the model has no finite answer.
pub type Residuals<'a> = dyn Fn(&[f64]) -> Option<Vec<Output>> + Sync + 'a;

/// Minimises the criterion over `coordinates` from `start`. `channels` is 1 where only the first entry of each
/// residual counts, 2 where both do. `None` where the residuals have no finite answer at the start.
pub fn minimize(
    residuals: &Residuals<'_>,
    channels: usize,
    coordinates: &[Coordinate],
    start: &[f64],
    effort: Effort,
) -> Option<Minimum> {
    let search = Search { residuals, channels, coordinates };
    let mut z = search.inner(start);
    let mut current = search.evaluate(&z)?;
    let mut damping = 1e-3;
    let (mut converged, mut drop) = (false, 0.0);
    let mut jacobian = search.slopes(&z, &current);
    let mut updated = false;
    for _ in 0..effort.iterations {
        let (hessian, gradient) = search.normal_equations(&z, &current, &jacobian);
        let free = search.free(&z, &gradient);
        let mut improved = None;
        while damping < 1e8 {
            let step = damped_step(&hessian, &gradient, &free, damping);
            let candidate = search.clamp(&z - step);
            match search.evaluate(&candidate) {
                Some(next) if next.criterion < current.criterion => {
                    improved = Some((candidate, next));
                    damping = (damping * 0.1).max(1e-9);
                    break;
                }
                _ if updated => break,
                _ => damping *= 10.0,
            }
        }
        let Some((candidate, next)) = improved else {
            if updated {
                search.renew(&mut jacobian, &z, &current);
                updated = false;
                continue;
            }
            converged = true;
            break;
        };
        drop = current.criterion - next.criterion;
        let step = &candidate - &z;
        let predicted = 2.0 * gradient.dot(&step) + (&hessian * &step).dot(&step);
        let settled = drop < effort.tolerance;
        if settled && !updated {
            (z, current, converged) = (candidate, next, true);
            break;
        }
        if settled || drop < TRUSTED * -predicted {
            (z, current, updated) = (candidate, next, false);
            search.renew(&mut jacobian, &z, &current);
        } else {
            broyden(&mut jacobian, &hessian, &step, &current.residuals, &next.residuals);
            (z, current, updated) = (candidate, next, true);
        }
    }
    Some(Minimum {
        values: search.outer(&z),
        deviance: current.deviance,
        criterion: current.criterion,
        residuals: current.residuals,
        converged,
        drop,
    })
}

/// Covariance of the parameters at `values`: the inverse of the information, corrected for residuals that are
/// correlated over `lag` samples (0: not corrected).
pub fn covariance(
    residuals: &Residuals<'_>,
    channels: usize,
    coordinates: &[Coordinate],
    values: &[f64],
    lag: usize,
) -> Option<DMatrix<f64>> {
    let search = Search { residuals, channels, coordinates };
    let z = search.inner(values);
    let at = search.evaluate(&z)?;
    let jacobian = search.jacobian(&z, &at);
    search.covariance(&z, &at, &jacobian, lag)
}

/// Share of the predicted drop of 2 V that a step must reach for the derivatives to be updated and not taken anew.
const TRUSTED: f64 = 0.5;

/// The least change of the derivatives `jacobian` that makes them agree with what `step` did to the residuals, in the metric of
/// the diagonal of `hessian` (Broyden, Math. Comp. 19, 1965; Moré, Lect. Notes Math. 630, 1978).
fn broyden(
    jacobian: &mut [Vec<Output>],
    hessian: &DMatrix<f64>,
    step: &DVector<f64>,
    before: &[Output],
    after: &[Output],
) {
    let scaled = step.component_mul(&hessian.diagonal());
    let length = scaled.dot(step);
    if length <= 0.0 {
        return;
    }
    let mut missed: Vec<Output> = after.iter().zip(before).map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).collect();
    let moved = |i: &usize| step[*i] != 0.0;
    for i in (0..step.len()).filter(moved) {
        for (missed, slope) in missed.iter_mut().zip(&jacobian[i]) {
            missed[0] -= slope[0] * step[i];
            missed[1] -= slope[1] * step[i];
        }
    }
    for i in (0..step.len()).filter(moved) {
        let share = scaled[i] / length;
        for (slope, missed) in jacobian[i].iter_mut().zip(&missed) {
            slope[0] += share * missed[0];
            slope[1] += share * missed[1];
        }
    }
}

pub(super) struct Evaluation {
    pub(super) residuals: Vec<Output>,
    pub(super) weight: Matrix2<f64>,
    deviance: f64,
    pub(super) criterion: f64,
}

pub(super) struct Search<'a> {
    pub(super) residuals: &'a Residuals<'a>,
    pub(super) channels: usize,
    pub(super) coordinates: &'a [Coordinate],
}

impl Search<'_> {
    pub(super) fn outer(&self, z: &DVector<f64>) -> Vec<f64> {
        self.coordinates.iter().zip(z.iter()).map(|(c, &z)| c.outer(z)).collect()
    }

    pub(super) fn inner(&self, values: &[f64]) -> DVector<f64> {
        let inner = |(c, &v): (&Coordinate, &f64)| c.inner(v.clamp(c.bounds[0], c.bounds[1]));
        DVector::from_iterator(values.len(), self.coordinates.iter().zip(values).map(inner))
    }

    pub(super) fn clamp(&self, mut z: DVector<f64>) -> DVector<f64> {
        for (c, z) in self.coordinates.iter().zip(z.iter_mut()) {
            let value = c.unbounded(*z);
            if value != value.clamp(c.bounds[0], c.bounds[1]) {
                *z = c.inner(c.outer(*z));
            }
        }
        z
    }

    pub(super) fn evaluate(&self, z: &DVector<f64>) -> Option<Evaluation> {
        let residuals = (self.residuals)(&self.outer(z))?;
        let n = residuals.len() as f64;
        let mut s = Matrix2::zeros();
        for e in &residuals {
            s[(0, 0)] += e[0] * e[0];
            s[(0, 1)] += e[0] * e[1];
            s[(1, 1)] += e[1] * e[1];
        }
        s /= n;
        let (determinant, weight) = if self.channels == 1 {
            (s[(0, 0)], Matrix2::new(1.0 / s[(0, 0)], 0.0, 0.0, 0.0))
        } else {
            s[(1, 0)] = s[(0, 1)];
            (s.determinant(), s.try_inverse()?)
        };
        let deviance = n * determinant.ln();
        if !deviance.is_finite() {
            return None;
        }
        Some(Evaluation { residuals, weight, deviance, criterion: deviance + self.penalty(z) })
    }

    fn penalty(&self, z: &DVector<f64>) -> f64 {
        self.coordinates
            .iter()
            .zip(z.iter())
            .filter_map(|(c, &z)| c.prior.map(|(m, s)| ((z - c.inner(m)) / s).powi(2)))
            .sum()
    }

    pub(super) fn jacobian(&self, z: &DVector<f64>, at: &Evaluation) -> Vec<Vec<Output>> {
        (0..z.len()).into_par_iter().map(|i| self.column(z, at, i)).collect()
    }

    /// The same, nothing for what is held: a long recording has a column of megabytes for each.
    fn slopes(&self, z: &DVector<f64>, at: &Evaluation) -> Vec<Vec<Output>> {
        let held = |i: usize| self.coordinates[i].bounds[0] == self.coordinates[i].bounds[1];
        let column = |i| if held(i) { Vec::new() } else { self.column(z, at, i) };
        (0..z.len()).into_par_iter().map(column).collect()
    }

    /// Puts the slopes at `z` in the place of others: two sets of a long recording's would be hundreds of megabytes.
    fn renew(&self, slopes: &mut Vec<Vec<Output>>, z: &DVector<f64>, at: &Evaluation) {
        slopes.clear();
        *slopes = self.slopes(z, at);
    }

    /// d e / d z_i by a forward difference, stepping away from a bound that is near; zero for a coordinate that is
    /// held by equal bounds.
    pub(super) fn column(&self, z: &DVector<f64>, at: &Evaluation, i: usize) -> Vec<Output> {
        const STEP: f64 = 1e-4;
        let c = &self.coordinates[i];
        for h in [STEP, -STEP] {
            let mut moved = z.clone();
            moved[i] += h;
            let value = c.unbounded(moved[i]);
            if value < c.bounds[0] || value > c.bounds[1] {
                continue;
            }
            if let Some(mut column) = (self.residuals)(&self.outer(&moved)) {
                for (a, b) in column.iter_mut().zip(&at.residuals) {
                    *a = [(a[0] - b[0]) / h, (a[1] - b[1]) / h];
                }
                return column;
            }
        }
        vec![[0.0; 2]; at.residuals.len()]
    }

    pub(super) fn normal_equations(
        &self,
        z: &DVector<f64>,
        at: &Evaluation,
        j: &[impl AsRef<[Output]>],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let n = j.len();
        let weighted = |e: &Output| weigh(&at.weight, e);
        let mut hessian = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        let we: Vec<Output> = at.residuals.iter().map(weighted).collect();
        for a in 0..n {
            gradient[a] = dot(j[a].as_ref(), &we);
            let wj: Vec<Output> = j[a].as_ref().iter().map(weighted).collect();
            for b in a..n {
                hessian[(a, b)] = dot(&wj, j[b].as_ref());
                hessian[(b, a)] = hessian[(a, b)];
            }
        }
        for (i, c) in self.coordinates.iter().enumerate() {
            if let Some((m, s)) = c.prior {
                gradient[i] += (z[i] - c.inner(m)) / (s * s);
                hessian[(i, i)] += 1.0 / (s * s);
            }
        }
        (hessian, gradient)
    }

    /// Coordinates that may move: not held by equal bounds, nor at a bound that the gradient pushes against.
    pub(super) fn free(&self, z: &DVector<f64>, gradient: &DVector<f64>) -> Vec<usize> {
        (0..z.len())
            .filter(|&i| {
                let c = &self.coordinates[i];
                let value = c.outer(z[i]);
                let hair = 1e-12 * (c.bounds[1] - c.bounds[0]);
                let at_lower = value <= c.bounds[0] + hair && gradient[i] > 0.0;
                let at_upper = value >= c.bounds[1] - hair && gradient[i] < 0.0;
                !(at_lower || at_upper || c.bounds[0] == c.bounds[1])
            })
            .collect()
    }

    /// With `lag` > 0 the scores' correlation over that many samples is taken into account (Newey and West, 1987), and
    /// the larger of both variances is kept. A parameter at its bound has no variance of its own.
    fn covariance(
        &self,
        z: &DVector<f64>,
        at: &Evaluation,
        j: &[Vec<Output>],
        lag: usize,
    ) -> Option<DMatrix<f64>> {
        let n = j.len();
        let (hessian, gradient) = self.normal_equations(z, at, j);
        let free = self.free(z, &gradient);
        let information = DMatrix::from_fn(free.len(), free.len(), |a, b| hessian[(free[a], free[b])]);
        let inverse = information.cholesky()?.inverse();
        let mut widened = inverse.clone();
        if lag > 0 {
            let scores = self.score_covariance(at, j, lag);
            let scores = DMatrix::from_fn(free.len(), free.len(), |a, b| scores[(free[a], free[b])]);
            let corrected = &inverse * scores * &inverse;
            for i in 0..free.len() {
                let ratio = (corrected[(i, i)] / inverse[(i, i)]).max(1.0).sqrt();
                widened.row_mut(i).scale_mut(ratio);
                widened.column_mut(i).scale_mut(ratio);
            }
        }
        let values = self.outer(z);
        let mut covariance = DMatrix::zeros(n, n);
        for (a, &i) in free.iter().enumerate() {
            for (b, &k) in free.iter().enumerate() {
                let stretch = self.coordinates[i].stretch(values[i]) * self.coordinates[k].stretch(values[k]);
                covariance[(i, k)] = widened[(a, b)] * stretch;
            }
        }
        Some(covariance)
    }

    fn score_covariance(&self, at: &Evaluation, j: &[Vec<Output>], lag: usize) -> DMatrix<f64> {
        let n = j.len();
        let samples = at.residuals.len();
        let weighted: Vec<Output> = at.residuals.iter().map(|e| weigh(&at.weight, e)).collect();
        let scores = DMatrix::from_fn(n, samples, |a, k| inner(&j[a][k], &weighted[k]));
        let mut sum = &scores * scores.transpose();
        for l in 1..=lag.min(samples.saturating_sub(1)) {
            let weight = 1.0 - l as f64 / (lag + 1) as f64;
            let cross = scores.columns(l, samples - l) * scores.columns(0, samples - l).transpose();
            sum += (&cross + cross.transpose()) * weight;
        }
        sum
    }
}

/// W e.
pub(crate) fn weigh(w: &Matrix2<f64>, e: &Output) -> Output {
    [w[(0, 0)] * e[0] + w[(0, 1)] * e[1], w[(1, 0)] * e[0] + w[(1, 1)] * e[1]]
}

/// aᵀ b of one sample.
pub(crate) fn inner(a: &Output, b: &Output) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Σ aᵀ b over the samples.
pub(super) fn dot(a: &[Output], b: &[Output]) -> f64 {
    a.iter().zip(b).map(|(a, b)| inner(a, b)).sum()
}

pub(super) fn damped_step(
    hessian: &DMatrix<f64>,
    gradient: &DVector<f64>,
    free: &[usize],
    damping: f64,
) -> DVector<f64> {
    let mut step = DVector::zeros(gradient.len());
    let h = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        let entry = hessian[(free[a], free[b])];
        if a == b { entry * (1.0 + damping) + 1e-12 } else { entry }
    });
    let g = DVector::from_iterator(free.len(), free.iter().map(|&i| gradient[i]));
    if let Some(solution) = h.cholesky().map(|c| c.solve(&g)) {
        for (a, &i) in free.iter().enumerate() {
            // No coordinate jumps further than a factor of e³ or three units: the quadratic model is local.
            step[i] = solution[a].clamp(-3.0, 3.0);
        }
    }
    step
}
