//! The predictor's poles as a filter of six states in three blocks of two.
//!
//! ```text
//! x[k+1] = F x[k] + d m[k],      F = Φ (I − K C), block-diagonal, 2 × 2 real blocks
//! ```
//!
//! What a moment or an addition to a measurement that the model lacks leaves in the innovations is C x of such a filter
//! (Willsky and Jones, IEEE Transactions on Automatic Control 21, 1976), so predictor and causes share F and C.
//!
//! Cost: 18 multiplications to advance, 12 for the output.

/// States of a filter.
pub const STATES: usize = 6;
/// Blocks of two states.
pub const BLOCKS: usize = STATES / 2;

/// F, row by row in each block.
pub type Transition = [[f32; 4]; BLOCKS];
/// A column d.
pub type Column = [f32; STATES];
/// The rows of C, whitened, one for each channel.
pub type Rows = [[f32; STATES]; 2];

/// The states of one filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Filter {
    x: Column,
}

impl Filter {
    /// F x + d m.
    #[inline]
    pub fn advance(&mut self, transition: &Transition, column: &Column, m: f32) {
        let (pairs, _) = self.x.as_chunks_mut::<2>();
        let (columns, _) = column.as_chunks::<2>();
        for ((pair, [f00, f01, f10, f11]), [d0, d1]) in pairs.iter_mut().zip(transition).zip(columns) {
            let [a, b] = *pair;
            *pair = [f00 * a + f01 * b + d0 * m, f10 * a + f11 * b + d1 * m];
        }
    }

    /// Adds d m.
    #[inline]
    pub fn add(&mut self, column: &Column, m: f32) {
        self.x.iter_mut().zip(column).for_each(|(x, d)| *x += d * m);
    }

    /// C x.
    #[inline]
    #[must_use]
    pub fn output(&self, rows: &Rows) -> [f32; 2] {
        rows.map(|row| {
            let [a, b, c, d, e, f] = row;
            let [x0, x1, x2, x3, x4, x5] = self.x;
            (a * x0 + b * x1) + (c * x2 + d * x3) + (e * x4 + f * x5)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_of_two_is_the_matrix_that_it_says() {
        let transition = [[0.5, 0.1, -0.2, 0.7], [0.9, 0.0, 0.0, 0.0], [0.0; 4]];
        let column = [1.0, 2.0, 1.0, 0.0, 0.0, 0.0];
        let rows = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0, 0.0, 0.0]];
        let mut filter = Filter::default();
        filter.advance(&transition, &column, 1.0);
        assert_eq!(filter.output(&rows), [1.0, 3.0]);
        filter.advance(&transition, &column, 0.0);
        assert_eq!(filter.output(&rows), [0.5 + 0.1 * 2.0, -0.2 + 0.7 * 2.0 + 0.9]);
    }
}
