//! The chord method: many candidates' first steps share one Jacobian (Ortega and Rheinboldt, Iterative Solution of
//! Nonlinear Equations, 1970, ch. 7).

use super::levenberg_marquardt::{Coordinate, Residuals, Search, damped_step};
use crate::model::pitch::Output;

/// The derivatives of the residuals at one point.
pub struct Chord {
    jacobian: Vec<Vec<Output>>,
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
        Some(Self { jacobian: search.jacobian(&z, &at) })
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
        let mut jacobian = self.jacobian.clone();
        for _ in 0..steps {
            jacobian.truncate(known);
            jacobian.extend((known..z.len()).map(|i| search.column(&z, &at, i)));
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
