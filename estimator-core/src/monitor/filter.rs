//! The predictor's poles as filters of six states in three blocks of two, one for the command, one for the readings, and one for
//! every cause whose trace moves.
//!
//! ```text
//! x[k+1] = F x[k] + d m[k],      F = Φ (I − K C), block-diagonal, 2 × 2 real blocks
//! ```
//!
//! What a moment or an addition to a measurement that the model lacks leaves in the innovations is C x of such a filter
//! (Willsky and Jones, IEEE Transactions on Automatic Control 21, 1976), so predictor and causes share F and C: block by block,
//! with its coefficients read once for all filters.

use super::model::MonitorModel;

/// States of a filter.
pub const STATES: usize = 6;
/// Blocks of two states.
pub const BLOCKS: usize = STATES / 2;
/// Filters of a bank.
pub const FILTERS: usize = 7;
/// So many of them, the first, are driven by a moment, the others by an addition to the rate.
const BY_MOMENT: usize = 5;

/// F, row by row in each block.
pub type Transition = [[f32; 4]; BLOCKS];
/// A column d.
pub type Column = [f32; STATES];
/// The rows of C, whitened, one for each channel.
pub type Rows = [[f32; STATES]; 2];

/// What drives the filters of a bank in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drive {
    /// Moments of command, lag, damping, friction and stiffness; then what is added to the rate: the reading, and that of a scale.
    pub inputs: [f32; FILTERS],
    /// θ, beside the rate's reading.
    pub theta: f32,
}

/// The states of all filters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bank {
    x: [[[f32; 2]; FILTERS]; BLOCKS],
}

impl Bank {
    /// F x + d m of every filter.
    #[inline]
    pub fn advance(&mut self, model: &MonitorModel, drive: &Drive) {
        let [rate, angle] = &model.correction;
        let columns = [&model.moment, rate, angle].map(|column| column.as_chunks::<2>().0);
        let [moments, rates, angles] = columns;
        let blocks = self.x.iter_mut().zip(&model.transition).zip(moments.iter().zip(rates).zip(angles));
        for ((states, [f00, f01, f10, f11]), ((moment, rate), [l0, l1])) in blocks {
            for (place, ([a, b], m)) in states.iter_mut().zip(drive.inputs).enumerate() {
                let [d0, d1] = if place < BY_MOMENT { moment } else { rate };
                (*a, *b) = (f00 * *a + f01 * *b + d0 * m, f10 * *a + f11 * *b + d1 * m);
            }
            let [_, _, _, _, _, [a, b], _] = states;
            *a += l0 * drive.theta;
            *b += l1 * drive.theta;
        }
    }

    /// C x of every filter.
    #[inline]
    #[must_use]
    pub fn outputs(&self, rows: &Rows) -> [[f32; 2]; FILTERS] {
        let mut outputs = [[0.0; 2]; FILTERS];
        let [rows_q, rows_t] = rows.each_ref().map(|row| row.as_chunks::<2>().0);
        for (states, ([q0, q1], [t0, t1])) in self.x.iter().zip(rows_q.iter().zip(rows_t)) {
            for ([q, t], [a, b]) in outputs.iter_mut().zip(states) {
                *q += q0 * a + q1 * b;
                *t += t0 * a + t1 * b;
            }
        }
        outputs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_of_two_is_the_matrix_that_it_says() {
        let model = MonitorModel {
            transition: [[0.5, 0.1, -0.2, 0.7], [0.9, 0.0, 0.0, 0.0], [0.0; 4]],
            moment: [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
            correction: [[3.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 4.0]],
            output: [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0, 0.0, 1.0]],
            ..MonitorModel::EMPTY
        };
        let mut bank = Bank::default();
        bank.advance(&model, &Drive { inputs: [1.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0], theta: 1.0 });
        let found = bank.outputs(&model.output);
        assert_eq!(found[..3], [[1.0, 3.0], [0.0, 0.0], [2.0, 6.0]]);
        assert_eq!(found[3..], [[0.0, 0.0], [0.0, 0.0], [3.0, 4.0], [0.0, 0.0]]);
        bank.advance(&model, &Drive::default());
        assert_eq!(bank.outputs(&model.output)[0], [0.5 + 0.1 * 2.0, -0.2 + 0.7 * 2.0 + 0.9]);
    }
}
