//! Can a random function explain what is left? The score test for a variance component.
//!
//! Let the model lack Σ_j b_j f_j with independent b_j of the variance τ, and let z_j be what the feature f_j, passed through
//! the predictor, does to the white innovations e. With z̃_j, z_j less what the derivatives J of the fitted unknowns explain
//! of it, of unit length, the derivative of the likelihood with respect to τ at τ = 0 is, but for a constant,
//!
//! ```text
//! Q = Σ_j s_j²,   s_j = z̃_jᵀ e,   E Q = tr Σ,   var Q = 2 tr Σ²,   Σ = z̃ᵀ z̃
//! ```
//!
//! and Q a mixture of χ²(1) with the eigenvalues of Σ as weights (Lin, Biometrika 84, 1997; Wu et al., American Journal of
//! Human Genetics 89, 2011). A feature is known before the row that it acts on, so that the s_j stay martingales where the
//! features depend on the motion. Where sums over blocks are more uneven than Σ says, Σ grows by that factor κ. The best
//! ridge function of the features gains
//!
//! ```text
//! sᵀ (Σ + λI)⁻¹ s/κ − tr (Σ + λI)⁻¹ Σ
//! ```

use super::p_values::{divisor, mixture_tail};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Values that are gathered before they are multiplied: memory does not grow with the rows.
const BATCH: usize = 256;
/// A feature of whose power the unknowns leave less than this share is one of them but for numerical derivatives.
const LEAST_SHARE: f64 = 1e-3;
/// λ relative to the largest eigenvalue of Σ: directions that the data hardly show are not asked for.
const RIDGE: f64 = 0.1;
/// Relative part added to the unknowns' information, so that it can be inverted where two are nearly one.
const HAIR: f64 = 1e-9;
/// Steps of the power iteration for the largest eigenvalue: enough for a tenth of it.
const POWER_STEPS: usize = 30;

/// What the rows add up to; a row is (z_1 .. z_m, J_1 .. J_n, e).
pub struct Sums {
    features: usize,
    size: usize,
    batch: DMatrix<f64>,
    filled: usize,
    products: DMatrix<f64>,
    /// For every block: Σ (z, J) e and Σ z².
    blocks: Vec<(DVector<f64>, f64)>,
    last_block: Option<usize>,
}

/// What comes out.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// (Q/κ − E Q) / √(var Q).
    pub statistic: f64,
    /// Of Q/κ.
    pub p_value: f64,
    /// 2 ln likelihood that the ridge function gains.
    pub closes: f64,
    /// Coefficients of the ridge function, feature by feature.
    pub coefficients: Vec<f64>,
}

impl Sums {
    /// For `features` features beside `unknowns` unknowns.
    pub fn new(features: usize, unknowns: usize) -> Self {
        let size = features + unknowns + 1;
        Self {
            features,
            size,
            batch: DMatrix::zeros(size, BATCH),
            filled: 0,
            products: DMatrix::zeros(size, size),
            blocks: Vec::new(),
            last_block: None,
        }
    }

    /// Adds one value of the innovations `e` in `block`, with the features' responses `z` and the unknowns' `slopes`.
    pub fn add(&mut self, block: usize, z: &[f64], slopes: impl Iterator<Item = f64>, e: f64) {
        let mut column = self.batch.column_mut(self.filled);
        column.rows_mut(0, self.features).copy_from_slice(z);
        let rest = column.iter_mut().skip(self.features);
        for (entry, value) in rest.zip(slopes.chain([e])) {
            *entry = value;
        }
        if self.last_block != Some(block) {
            self.last_block = Some(block);
            self.blocks.push((DVector::zeros(self.size), 0.0));
        }
        if let Some((scores, power)) = self.blocks.last_mut() {
            scores.axpy(e, &column, 1.0);
            *power += z.iter().map(|z| z * z).sum::<f64>();
        }
        self.filled += 1;
        if self.filled == BATCH {
            self.multiply();
        }
    }

    fn multiply(&mut self) {
        let filled = self.batch.columns(0, self.filled);
        self.products.gemm(1.0, &filled, &filled.transpose(), 1.0);
        self.filled = 0;
    }

    /// The test. `None` where no feature is left beside the unknowns, or numbers are not finite.
    pub fn outcome(mut self) -> Option<Outcome> {
        self.multiply();
        let (m, n) = (self.features, self.size - self.features - 1);
        let moving: Vec<usize> = (m..m + n).filter(|&i| self.products[(i, i)] > 0.0).collect();
        // everything in units of its own length
        let length = |i: usize| self.products[(i, i)].sqrt();
        let unknowns = DMatrix::from_fn(moving.len(), moving.len(), |a, b| {
            let (i, j) = (moving[a], moving[b]);
            self.products[(i, j)] / (length(i) * length(j)) + if a == b { HAIR } else { 0.0 }
        });
        let across =
            DMatrix::from_fn(moving.len(), m, |a, j| self.products[(moving[a], j)] / length(moving[a]));
        // z̃ = z − J x
        let x = finite(unknowns)?.solve(&across);
        let z = self.products.view((0, 0), (m, m)) - across.tr_mul(&x);
        let kept: Vec<usize> = (0..m).filter(|&j| z[(j, j)] > LEAST_SHARE * self.products[(j, j)]).collect();
        let norms: Vec<f64> = kept.iter().map(|&j| z[(j, j)].sqrt()).collect();
        let sigma =
            DMatrix::from_fn(kept.len(), kept.len(), |a, b| z[(kept[a], kept[b])] / (norms[a] * norms[b]));
        let project = |scores: &DVector<f64>| {
            let of_unknowns =
                DVector::from_iterator(moving.len(), moving.iter().map(|&i| scores[i] / length(i)));
            let less = x.tr_mul(&of_unknowns);
            DVector::from_iterator(
                kept.len(),
                kept.iter().zip(&norms).map(|(&j, norm)| (scores[j] - less[j]) / norm),
            )
        };
        let s = project(&self.products.column(m + n).into_owned());
        let square = &sigma * &sigma;
        let cumulants = [sigma.trace(), square.trace(), square.dot(&sigma)];
        let power: f64 = self.blocks.iter().map(|b| b.1).sum();
        // about what a moment that is there adds to each block
        let left_over =
            |(scores, own): &(DVector<f64>, f64)| (project(scores) - &s * (own / power)).norm_squared();
        let uneven = self.blocks.iter().map(left_over).sum::<f64>() / cumulants[0];
        let directions = cumulants[0] * cumulants[0] / cumulants[1];
        let kappa = divisor(uneven, directions * (self.blocks.len().max(2) - 1) as f64);
        let q = s.norm_squared() / kappa;
        let lambda = RIDGE * largest(&sigma);
        let mut ridge = sigma;
        for i in 0..kept.len() {
            ridge[(i, i)] += lambda;
        }
        let solver = finite(ridge)?;
        let b = solver.solve(&s);
        let freedom = kept.len() as f64 - lambda * solver.inverse().trace();
        let mut coefficients = vec![0.0; m];
        for ((&j, norm), b) in kept.iter().zip(&norms).zip(b.iter()) {
            coefficients[j] = b / norm;
        }
        Some(Outcome {
            statistic: (q - cumulants[0]) / (2.0 * cumulants[1]).sqrt(),
            p_value: mixture_tail(q, cumulants),
            closes: (s.dot(&b) / kappa - freedom).max(0.0),
            coefficients,
        })
        .filter(|outcome| outcome.statistic.is_finite())
    }
}

fn finite(matrix: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    matrix.cholesky().filter(|c| c.l_dirty().iter().all(|x| x.is_finite()))
}

/// The largest eigenvalue of a symmetric matrix (von Mises, 1929).
fn largest(matrix: &DMatrix<f64>) -> f64 {
    let mut x = DVector::from_fn(matrix.nrows(), |i, _| 1.0 + 0.1 * (i % 7) as f64);
    let mut size = 0.0;
    for _ in 0..POWER_STEPS {
        x = matrix * x.normalize();
        size = x.norm();
    }
    size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_unknowns_explain_is_no_finding_and_what_they_do_not_is() {
        // feature 1 is the unknown, feature 2 a third of the errors
        let wave = |k: usize, period: usize| (k as f64 * std::f64::consts::TAU / period as f64).sin();
        let run = |of_errors: [f64; 2]| {
            let mut sums = Sums::new(2, 1);
            for k in 0..3000 {
                let noise = ((k * 7919 + k * k * 104_729) % 1000) as f64 / 288.7 - 1.73;
                let [a, b] = [wave(k, 40), wave(k, 70)];
                sums.add(k / 150, &[a, b], [a].into_iter(), noise + of_errors[0] * a + of_errors[1] * b);
            }
            sums.outcome().unwrap()
        };
        assert!(run([0.0, 0.0]).p_value > 0.01 && run([0.5, 0.0]).p_value > 0.01);
        let found = run([0.0, 0.5]);
        assert!(found.p_value < 1e-6 && found.closes > 100.0, "{found:?}");
        // the ridge takes a tenth
        assert!(found.coefficients[0] == 0.0 && (found.coefficients[1] - 0.45).abs() < 0.06, "{found:?}");
    }
}
