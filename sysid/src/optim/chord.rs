//! The chord method: many candidates' first steps share one Jacobian (Ortega and Rheinboldt, Iterative Solution of
//! Nonlinear Equations, 1970, ch. 7).

use super::levenberg_marquardt::{Coordinate, Residuals, Search, damped_step, dot, inner, weigh};
use crate::model::pitch::Output;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix2};

/// The derivatives of the residuals at one point.
pub struct Chord {
    jacobian: Vec<Vec<Output>>,
    /// Residuals there, and their weight.
    residuals: Vec<Output>,
    weight: Matrix2<f64>,
    /// Of the coordinates that may move there.
    free: Vec<usize>,
    hessian: Option<Cholesky<f64, Dyn>>,
    gradient: DVector<f64>,
}

/// Where a descent has come to.
#[derive(Clone, Debug)]
pub struct Descent {
    /// Parameters.
    pub values: Vec<f64>,
    /// The criterion there.
    pub criterion: f64,
    /// By how much the last step lowered it; 0 where no step did.
    pub drop: f64,
}

/// A step that lowers the criterion by less than this is the last.
const SETTLED: f64 = 0.2;
/// Dampings of a step, tried in turn until one lowers the criterion.
const DAMPINGS: [f64; 3] = [1e-3, 1e-1, 1e1];

/// A direction of which less than this share is none of the chord's own says nothing of its own.
const INDEPENDENT: f64 = 1e-6;
/// A start that moves the residuals by less than this share of their variance changes nothing.
const NEUTRAL: f64 = 1e-9;

impl Chord {
    /// The derivatives at `values`. `None` where the residuals have no finite answer there.
    pub fn new(
        residuals: &Residuals<'_>,
        channels: usize,
        coordinates: &[Coordinate],
        values: &[f64],
    ) -> Option<Self> {
        let search = Search { residuals, channels, coordinates };
        let z = search.inner(values);
        let at = search.evaluate(&z)?;
        let jacobian = search.jacobian(&z, &at);
        let (hessian, gradient) = search.normal_equations(&z, &at, &jacobian);
        let free = search.free(&z, &gradient);
        let entry = |a: usize, b: usize| {
            let damped = if a == b { 1.0 + DAMPINGS[0] } else { 1.0 };
            hessian[(free[a], free[b])] * damped + if a == b { f64::MIN_POSITIVE } else { 0.0 }
        };
        let hessian = DMatrix::from_fn(free.len(), free.len(), entry).cholesky();
        let gradient = DVector::from_iterator(free.len(), free.iter().map(|&i| gradient[i]));
        Some(Self { jacobian, residuals: at.residuals, weight: at.weight, free, hessian, gradient })
    }

    /// By how much the criterion may fall by the further coordinates that `start` has, beyond what those of the chord can do
    /// themselves: the score test of the directions D in which they change the residuals e,
    ///
    /// ```text
    /// bᵀ A⁻¹ b,    b = Dᵀ W e − Dᵀ W J H⁻¹ Jᵀ W e,    A = Dᵀ W D − Dᵀ W J H⁻¹ Jᵀ W D
    /// ```
    ///
    /// (Rao, Proc. Camb. Phil. Soc. 44, 1948). Where the residuals at `start` differ, D is that difference; where `start`
    /// changes nothing, D are the derivatives there, and all but the first cost ln N. `None` where the model has no finite
    /// answer at `start`.
    pub fn promise(
        &self,
        residuals: &Residuals<'_>,
        channels: usize,
        coordinates: &[Coordinate],
        start: &[f64],
    ) -> Option<f64> {
        let search = Search { residuals, channels, coordinates };
        let z = search.inner(start);
        let at = search.evaluate(&z)?;
        let differs = |(a, b): (&Output, &Output)| [a[0] - b[0], a[1] - b[1]];
        let change = || at.residuals.iter().zip(&self.residuals).map(differs);
        let norm: f64 = change().map(|d| inner(&d, &weigh(&self.weight, &d))).sum();
        let count = at.residuals.len() as f64;
        if norm > NEUTRAL * count {
            return Some(self.score(&[change().collect()]));
        }
        let own: Vec<Vec<Output>> =
            (self.jacobian.len()..z.len()).map(|i| search.column(&z, &at, i)).collect();
        let further = own.len().saturating_sub(1) as f64;
        Some(self.score(&own) - further * (count * channels as f64).ln())
    }

    fn score(&self, directions: &[Vec<Output>]) -> f64 {
        let n = directions.len();
        let weighted: Vec<Vec<Output>> =
            directions.iter().map(|d| d.iter().map(|e| weigh(&self.weight, e)).collect()).collect();
        let along =
            DMatrix::from_fn(self.free.len(), n, |a, j| dot(&self.jacobian[self.free[a]], &weighted[j]));
        let mut slope = DVector::from_fn(n, |j, _| dot(&weighted[j], &self.residuals));
        let mut left = DMatrix::from_fn(n, n, |i, j| dot(&directions[i], &weighted[j]));
        let whole = left.diagonal();
        if let Some(hessian) = &self.hessian {
            let known = hessian.solve(&along);
            slope -= known.tr_mul(&self.gradient);
            left -= known.tr_mul(&along);
        }
        for i in 0..n {
            left[(i, i)] += INDEPENDENT * whole[i] + f64::MIN_POSITIVE;
        }
        left.cholesky().map_or(0.0, |left| slope.dot(&left.solve(&slope)))
    }

    /// The derivatives, coordinate by coordinate, in the coordinates of the search.
    #[must_use]
    pub fn into_jacobian(self) -> Vec<Vec<Output>> {
        self.jacobian
    }

    /// At most `steps` Gauss–Newton steps from `start`. The derivatives with respect to the first coordinates are those
    /// taken here, the further ones are taken at every step. A step is damped until it lowers the criterion; where it
    /// never does, the descent ends.
    pub fn descend(
        &self,
        residuals: &Residuals<'_>,
        channels: usize,
        coordinates: &[Coordinate],
        start: &[f64],
        steps: usize,
    ) -> Option<Descent> {
        let search = Search { residuals, channels, coordinates };
        let known = self.jacobian.len();
        let mut z = search.inner(start);
        let mut at = search.evaluate(&z)?;
        let mut drop = 0.0;
        for _ in 0..steps {
            let own: Vec<Vec<Output>> = (known..z.len()).map(|i| search.column(&z, &at, i)).collect();
            let jacobian: Vec<&[Output]> = self.jacobian.iter().chain(&own).map(Vec::as_slice).collect();
            let (hessian, gradient) = search.normal_equations(&z, &at, &jacobian);
            let free = search.free(&z, &gradient);
            let lower = DAMPINGS.iter().find_map(|&damping| {
                let candidate = search.clamp(&z - damped_step(&hessian, &gradient, &free, damping));
                let next = search.evaluate(&candidate)?;
                (next.criterion < at.criterion).then_some((candidate, next))
            });
            let Some((candidate, next)) = lower else { break };
            drop = at.criterion - next.criterion;
            (z, at) = (candidate, next);
            if drop < SETTLED {
                break;
            }
        }
        Some(Descent { values: search.outer(&z), criterion: at.criterion, drop })
    }
}
