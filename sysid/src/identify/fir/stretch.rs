//! The rows of one section: their normal equations and the correlation of what is left over.

use super::{FirOptions, Piece, WINDOW};
use core::ops::Range;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Rows at a time, so that what one pass over the lags reads stays in the cache.
const CHUNK: usize = 2048;

/// A piece cut to what its windows reach, about the means of its used rows.
pub(super) struct Stretch {
    u: Vec<f64>,
    y: Vec<f64>,
    /// Means taken off.
    level: [f64; 2],
    /// Used rows, as ranges without a hole.
    blocks: Vec<Range<usize>>,
    taps: usize,
    lag: usize,
}

impl Stretch {
    pub fn new(piece: &Piece, options: &FirOptions) -> Self {
        let window = options.taps + options.first_lag - 1;
        let length = piece.u.len().min(piece.y.len()).min(piece.supervised.len());
        let end = piece.rows.end.min(length);
        let from = piece.rows.start.saturating_sub(window).min(end);
        let mut blocks: Vec<Range<usize>> = Vec::new();
        for k in piece.rows.start.max(from + window)..end {
            if piece.supervised[k] && !options.use_supervised {
                continue;
            }
            let k = k - from;
            match blocks.last_mut() {
                Some(block) if block.end == k => block.end = k + 1,
                _ => blocks.push(k..k + 1),
            }
        }
        let centred = |signal: &[f64]| {
            let mean = mean_over(&signal[from..end], &blocks);
            (signal[from..end].iter().map(|x| x - mean).collect::<Vec<f64>>(), mean)
        };
        let ((u, u_level), (y, y_level)) = (centred(piece.u), centred(piece.y));
        Self { u, y, level: [u_level, y_level], blocks, taps: options.taps, lag: options.first_lag }
    }

    pub fn count(&self) -> usize {
        self.blocks.iter().map(Range::len).sum()
    }

    /// Chunks of the blocks.
    fn chunks(&self) -> impl Iterator<Item = Range<usize>> {
        self.blocks
            .iter()
            .flat_map(|block| block.clone().step_by(CHUNK).map(|start| start..(start + CHUNK).min(block.end)))
    }

    /// The inputs that tap `i` meets in `rows`.
    fn input(&self, rows: &Range<usize>, i: usize) -> &[f64] {
        &self.u[rows.start - self.lag - i..rows.end - self.lag - i]
    }

    /// Adds ΦᵀΦ and Φᵀy, taken about the means of Φ and y.
    pub fn add_normal_equations(&self, gram: &mut DMatrix<f64>, cross: &mut DVector<f64>) {
        let n = self.taps;
        let mut own = DMatrix::<f64>::zeros(n, n);
        for rows in self.chunks() {
            let newest = self.input(&rows, 0);
            for i in 0..n {
                own[(i, 0)] += dot(newest, self.input(&rows, i));
                cross[i] += dot(&self.y[rows.clone()], self.input(&rows, i));
            }
        }
        for block in &self.blocks {
            for j in 1..n {
                let (enters, leaves) = (block.start - self.lag, block.end - self.lag);
                let (new, old) = (self.u[enters - j], self.u[leaves - j]);
                for i in j..n {
                    own[(i, j)] += self.u[enters - i] * new - self.u[leaves - i] * old;
                }
            }
        }
        for j in 1..n {
            for i in j..n {
                own[(i, j)] += own[(i - 1, j - 1)];
            }
        }
        let sums = self.regressor_sums();
        let count = self.count().max(1) as f64;
        for j in 0..n {
            for i in 0..n {
                gram[(i, j)] += own[(i.max(j), i.min(j))] - sums[i] * sums[j] / count;
            }
        }
    }

    /// Sum of the regressor over the used rows. y needs none, its mean is zero.
    fn regressor_sums(&self) -> DVector<f64> {
        let mut sums = DVector::zeros(self.taps);
        for block in &self.blocks {
            let mut sum: f64 = self.input(block, 0).iter().sum();
            for (i, total) in sums.iter_mut().enumerate() {
                *total += sum;
                if i + 1 < self.taps {
                    sum += self.u[block.start - 1 - self.lag - i] - self.u[block.end - 1 - self.lag - i];
                }
            }
        }
        sums
    }

    /// o_s of the signals about their means.
    fn centred_offset(&self, taps: &DVector<f64>) -> f64 {
        -self.regressor_sums().dot(taps) / self.count().max(1) as f64
    }

    pub fn offset(&self, taps: &DVector<f64>) -> f64 {
        self.level[1] + self.centred_offset(taps) - taps.sum() * self.level[0]
    }

    /// e on the used rows, zero elsewhere.
    fn errors(&self, taps: &DVector<f64>) -> Vec<f64> {
        let offset = self.centred_offset(taps);
        let mut errors = vec![0.0; self.y.len()];
        for rows in self.chunks() {
            let part = &mut errors[rows.clone()];
            for (e, y) in part.iter_mut().zip(&self.y[rows.clone()]) {
                *e = y - offset;
            }
            for (i, w) in taps.iter().enumerate() {
                add_scaled(part, -w, self.input(&rows, i));
            }
        }
        errors
    }
}

/// Sums of products of the errors, and of the inputs, at each lag.
pub(super) struct Correlations {
    pub error: Vec<f64>,
    input: Vec<f64>,
    /// Samples that `input` sums over.
    samples: usize,
}

impl Correlations {
    pub fn new(taps: usize) -> Self {
        let lags = WINDOW * taps;
        Self { error: vec![0.0; lags], input: vec![0.0; lags + taps], samples: 0 }
    }

    pub fn add(&mut self, stretch: &Stretch, taps: &DVector<f64>) {
        add_correlations(&mut self.error, &stretch.errors(taps));
        add_correlations(&mut self.input, &stretch.u);
        self.samples += stretch.u.len();
    }

    /// √diag((ΦᵀΦ)⁻¹ M (ΦᵀΦ)⁻¹); `inflation` is rows over rows less unknowns.
    pub fn deviations(&self, factor: &Cholesky<f64, Dyn>, inflation: f64) -> Vec<f64> {
        let (lags, n) = (self.error.len(), self.input.len() - self.error.len());
        let along_diagonal = |delta: usize| {
            let products = (0..2 * lags - 1).map(|shifted| {
                let lag = shifted.abs_diff(lags - 1);
                let weight = 1.0 - lag as f64 / lags as f64;
                weight * self.error[lag] * self.input[(shifted + delta).abs_diff(lags - 1)]
            });
            products.sum::<f64>() * inflation / self.samples as f64
        };
        let m: Vec<f64> = (0..n).map(along_diagonal).collect();
        let half = factor.solve(&DMatrix::from_fn(n, n, |i, j| m[i.abs_diff(j)]));
        let covariance = factor.solve(&half.transpose());
        covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect()
    }
}

fn add_correlations(sums: &mut [f64], x: &[f64]) {
    for start in (0..x.len()).step_by(CHUNK) {
        let end = (start + CHUNK).min(x.len());
        for (lag, sum) in sums.iter_mut().enumerate().take(end) {
            let from = start.max(lag);
            *sum += dot(&x[from..end], &x[from - lag..end - lag]);
        }
    }
}

fn mean_over(x: &[f64], blocks: &[Range<usize>]) -> f64 {
    let count: usize = blocks.iter().map(Range::len).sum();
    let sum: f64 = blocks.iter().map(|block| x[block.clone()].iter().sum::<f64>()).sum();
    sum / count.max(1) as f64
}

/// aᵀ b in eight partial sums, which the compiler can keep side by side.
pub(in crate::identify) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a8, a_rest) = a.as_chunks::<8>();
    let (b8, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a8.iter().zip(b8) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// y ← y + g x over the shorter length.
pub(super) fn add_scaled(y: &mut [f64], g: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += g * x;
    }
}
