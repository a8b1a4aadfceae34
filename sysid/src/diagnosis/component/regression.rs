//! Generalised least squares by its normal equations, block by block.
//!
//! ```text
//! A = Σ z zᵀ     β = A⁻¹ Σ z e     cov β = κ σ² A⁻¹     σ² = Σ (e − zᵀβ)²/(n − m)     κ = max(1, Σ_b s_bᵀ A⁻¹ s_b/(m σ²))
//! ```
//!
//! s_b is the score of a block at β; where errors hang together within a block, κ says by how much.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// What the rows add up to.
#[derive(Clone, Debug)]
pub struct Regression {
    count: usize,
    blocks: Vec<Block>,
    last_block: Option<usize>,
}

#[derive(Clone, Debug)]
struct Block {
    /// Σ z zᵀ.
    information: DMatrix<f64>,
    /// Σ z e.
    score: DVector<f64>,
    /// Σ e².
    power: f64,
    rows: f64,
}

/// The coefficients with their standard errors.
#[derive(Clone, Debug)]
pub struct Solution {
    /// β.
    pub values: Vec<f64>,
    /// √(κ σ² (A⁻¹)_jj).
    pub standard_errors: Vec<f64>,
    /// κ σ² A⁻¹.
    covariance: DMatrix<f64>,
}

impl Solution {
    /// The same about the mean by `weights`, which add up to 1: what the data say of the coefficients against each other, whatever they
    /// have in common.
    pub fn about_the_mean(&self, weights: &[f64]) -> Self {
        let count = self.values.len();
        let less = DMatrix::from_fn(count, count, |i, j| f64::from(u8::from(i == j)) - weights[j]);
        let covariance = &less * &self.covariance * less.transpose();
        let values = less * DVector::from_column_slice(&self.values);
        let standard_errors = covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect();
        Self { values: values.iter().copied().collect(), standard_errors, covariance }
    }
}

impl Regression {
    /// For `count` coefficients.
    pub fn new(count: usize) -> Self {
        Self { count, blocks: Vec::new(), last_block: None }
    }

    /// Adds a white error `e` in `block` with what the features do to it.
    pub fn add(&mut self, block: usize, z: &[f64], e: f64) {
        if self.last_block != Some(block) {
            self.last_block = Some(block);
            self.blocks.push(Block::empty(self.count));
        }
        let Some(Block { information, score, power, rows }) = self.blocks.last_mut() else { return };
        for (j, b) in z.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            for (sum, a) in information.column_mut(j).iter_mut().zip(z) {
                *sum += a * b;
            }
            score[j] += b * e;
        }
        *power += e * e;
        *rows += 1.0;
    }

    /// The same with coefficients made one: the `j`-th becomes part of the one that `into` names.
    pub fn merged(&self, into: &[usize]) -> Self {
        let count = into.iter().max().map_or(0, |most| most + 1);
        let sum = DMatrix::from_fn(count, self.count, |i, j| f64::from(u8::from(into[j] == i)));
        let block = |b: &Block| Block {
            information: &sum * &b.information * sum.transpose(),
            score: &sum * &b.score,
            ..*b
        };
        Self { count, blocks: self.blocks.iter().map(block).collect(), last_block: self.last_block }
    }

    fn total(&self) -> Block {
        let mut all = Block::empty(self.count);
        for block in &self.blocks {
            all.information += &block.information;
            all.score += &block.score;
            all.power += block.power;
            all.rows += block.rows;
        }
        all
    }

    /// The coefficients alone, of values without noise.
    pub fn coefficients(&self) -> Option<Vec<f64>> {
        let all = self.total();
        let beta = finite(all.information)?.solve(&all.score);
        beta.iter().all(|b| b.is_finite()).then(|| beta.iter().copied().collect())
    }

    /// The coefficients with their standard errors. `None` where the data do not tell them all.
    pub fn solve(&self) -> Option<Solution> {
        let m = self.count;
        let all = self.total();
        let factor = finite(all.information)?;
        let beta = factor.solve(&all.score);
        let variance = (all.power - beta.dot(&all.score)) / (all.rows - m as f64);
        let uneven = |block: &Block| {
            let score = &block.score - &block.information * &beta;
            score.dot(&factor.solve(&score))
        };
        let kappa = self.blocks.iter().map(uneven).sum::<f64>() / (m as f64 * variance);
        let scale = kappa.max(1.0) * variance;
        let covariance = scale * factor.inverse();
        let standard_errors: Vec<f64> =
            covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
        let sound = standard_errors.iter().chain(beta.iter()).all(|x| x.is_finite());
        sound.then(|| Solution { values: beta.iter().copied().collect(), standard_errors, covariance })
    }
}

impl Block {
    fn empty(count: usize) -> Self {
        Self {
            information: DMatrix::zeros(count, count),
            score: DVector::zeros(count),
            power: 0.0,
            rows: 0.0,
        }
    }
}

fn finite(matrix: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    matrix.cholesky().filter(|c| c.l_dirty().iter().all(|x| x.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(k: usize) -> f64 {
        ((k * 7919 + k * k * 104_729) % 1000) as f64 / 288.7 - 1.73
    }

    fn regression(errors: impl Fn(usize) -> f64) -> Regression {
        let mut sums = Regression::new(3);
        for k in 0..3000 {
            let mut z = [0.0; 3];
            z[k % 3] = 1.0;
            sums.add(k / 100, &z, errors(k) + [0.5, -0.2, -0.2][k % 3]);
        }
        sums
    }

    #[test]
    fn means_of_groups_come_out_with_their_standard_errors() {
        let found = regression(noise).solve().unwrap();
        for (value, (error, truth)) in
            found.values.iter().zip(found.standard_errors.iter().zip([0.5, -0.2, -0.2]))
        {
            assert!((value - truth).abs() < 3.0 * error, "{value} ± {error}");
            assert!((error * 1000f64.sqrt() - 1.0).abs() < 0.25, "{error}");
        }
    }

    #[test]
    fn errors_that_hang_together_widen_the_standard_errors() {
        let alone = regression(noise).solve().unwrap().standard_errors[0];
        let together = regression(|k| noise(k) + noise(k / 100)).solve().unwrap().standard_errors[0];
        assert!(together > 3.0 * alone, "{alone} {together}");
    }

    #[test]
    fn about_the_mean_what_all_have_in_common_is_gone_with_its_error() {
        let third = [1.0 / 3.0; 3];
        let found = regression(|k| 7.0 + noise(k) + 3.0 * noise(k / 100)).solve().unwrap();
        let about = found.about_the_mean(&third);
        assert!(about.values.iter().sum::<f64>().abs() < 1e-9 && found.values[0] > 6.0);
        for (value, truth) in about.values.iter().zip([7.0 / 15.0, -7.0 / 30.0, -7.0 / 30.0]) {
            assert!((value - truth).abs() < 0.2, "{value}");
        }
        assert!(about.standard_errors[0] < found.standard_errors[0]);
    }

    #[test]
    fn merged_groups_have_the_mean_and_an_empty_one_no_answer() {
        let two = regression(noise).merged(&[0, 1, 1]).solve().unwrap();
        assert!((two.values[1] + 0.2).abs() < 3.0 * two.standard_errors[1]);
        let mut empty = Regression::new(2);
        (0..100).for_each(|k| empty.add(0, &[1.0, 0.0], noise(k)));
        assert!(empty.solve().is_none());
    }
}
