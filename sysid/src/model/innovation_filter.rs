//! What an addition to the model does to its innovations.

use super::plant::{State, StateMatrix};
use super::shift::Shift;
use crate::dataset::Run;

/// The predictor as a filter from a moment, or from an addition to the measurement, to the innovations:
///
/// ```text
/// δ⁺ = Φ (I − K C) δ + Γ m − Φ K d,     e = C δ + d
/// ```
///
/// From a row in which nothing was measured on, δ⁺ = Φ δ + Γ m. δ is by how much the true state is ahead of the predicted one (Kailath, 1968; Ljung, System Identification, ch. 4).
#[derive(Clone, Debug)]
pub struct InnovationFilter {
    /// Φ (I − K C), over one sample.
    pub transition: StateMatrix,
    /// Φ.
    pub uncorrected: StateMatrix,
    /// Γ: a unit moment, held over one sample.
    pub per_moment: State,
    /// Φ K, one column per measured channel.
    pub per_addition: Vec<State>,
    /// The states that the channels measure.
    pub measured: Vec<usize>,
    /// Delay of the input at the start of a recording, s.
    pub delay: f64,
}

impl InnovationFilter {
    /// The command that arrives between row `k` of `run` and the next.
    pub fn command(&self, run: &Run, k: usize) -> f64 {
        Shift::new(self.delay, 0, 1, run.step, run.held).mean(run, k)
    }

    /// x⁺ = Φ (I − K C) x + drive · f for all features f at once, Φ x + drive · f from a row that was not `measured`: x has a row for
    /// each state, `next` is room for the same.
    pub fn advance(
        &self,
        measured: bool,
        (drive, f): (&State, &[f64]),
        x: &mut Vec<Vec<f64>>,
        next: &mut Vec<Vec<f64>>,
    ) {
        let transition = if measured { &self.transition } else { &self.uncorrected };
        for (i, row) in next.iter_mut().enumerate() {
            row.iter_mut().zip(f).for_each(|(y, f)| *y = drive[i] * f);
            for (j, x) in x.iter().enumerate() {
                let a = transition[(i, j)];
                if a != 0.0 {
                    row.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
                }
            }
        }
        core::mem::swap(x, next);
    }
}
