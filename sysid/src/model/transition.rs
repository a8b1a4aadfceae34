//! A step of the linear model, as the inner loop of a simulation wants it.

use crate::model::plant::{STATES, State, StateMatrix};

/// A state matrix by columns.
pub struct Transition([[f64; STATES]; STATES]);

impl Transition {
    /// Takes `matrix` apart.
    pub fn new(matrix: &StateMatrix) -> Self {
        Self(core::array::from_fn(|j| matrix.column(j).into_owned().into()))
    }

    /// The matrix times `x`. Zeros are multiplied too: whole columns leave nothing stored that the next load has to wait for.
    #[inline(always)]
    pub fn apply(&self, x: &State) -> State {
        let mut next = [0.0; STATES];
        for (column, &x) in self.0.iter().zip(x.iter()) {
            for (sum, &entry) in next.iter_mut().zip(column) {
                *sum += entry * x;
            }
        }
        State::from(next)
    }
}
