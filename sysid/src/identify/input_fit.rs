//! B, D and the initial states by least squares on the free run, once A and C are known:
//!
//! ```text
//! y[k] = Bᵀ φ[k] + D u[k] + x0_sᵀ γ[k] + o_s + e[k]
//! φ[k+1] = Aᵀ φ[k] + Cᵀ u[k],  φ[0] = 0          γ[k+1] = Aᵀ γ[k],  γ[0] = Cᵀ
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | φ, γ | n × 1: what B and x0 contribute to the output at sample k |
//! | x0_s, o_s | initial state and offset of stretch s: eliminated from its normal equations, so a joint costs nothing |
//!
//! Cost per sample: 2 n² multiplications for the regressors, (2n+3)²/2 for the normal equations.
//!
//! Source: Verhaegen, Dewilde, Subspace model identification part 1, Int. J. Control 56, 1992, section 5.

use super::block_hankel::Stretch;
use crate::error::{Error, ErrorKind};
use crate::linalg::{eigenvalues, gram};
use crate::model::state_space::StateSpace;
use nalgebra::{DMatrix, DVector, RowDVector};

/// Highest order the kernels are made for.
pub const HIGHEST_ORDER: usize = 5;
/// Rows at a time, so that they stay in the cache.
const CHUNK: usize = 512;
/// A response to the initial state below this has died away; it starts at 1 or less.
const DECAYED: f64 = 1e-60;
/// A direction of an initial state or offset that keeps less than this share of its square after the others are taken
/// out shows nothing of its own.
const NOTHING_LEFT: f64 = 1e-12;

/// B and D of the model with `a` (n × n, n up to [`HIGHEST_ORDER`]) and `c`; D only if `direct`, else 0; o_s only if
/// `offset`.
///
/// # Errors
/// A free run that overflows, or an input that does not show all of B.
pub(super) fn input_matrices(
    a: &DMatrix<f64>,
    c: &RowDVector<f64>,
    direct: bool,
    offset: bool,
    stretches: &[Stretch],
) -> Result<(DVector<f64>, f64), Error> {
    let n = c.len();
    let unknowns = n + usize::from(direct);
    let width = n + 1 + unknowns + 1;
    let mut total = DMatrix::zeros(unknowns + 1, unknowns + 1);
    for stretch in stretches {
        let mut products = normal_equations(a, c, width, stretch);
        eliminate(&mut products, if offset { n + 1 } else { n });
        total += products.view((n + 1, n + 1), (unknowns + 1, unknowns + 1));
    }
    if !total.iter().all(|x| x.is_finite()) {
        return Err(diverging());
    }
    let solution = solve(&total, unknowns).ok_or_else(|| {
        let radius = eigenvalues(a).unwrap_or_default().iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        if radius >= 1.0 {
            return diverging();
        }
        let found = format!("the input does not excite {n} states");
        Error::new(ErrorKind::Numerical, found, "use sections in which the input moves, or a lower order")
    })?;
    Ok((solution.rows(0, n).into_owned(), if direct { solution[n] } else { 0.0 }))
}

fn diverging() -> Error {
    let found = "the model is unstable, and its free run over the data overflows";
    Error::new(ErrorKind::Numerical, found, "choose another order or block size")
}

/// Zᵀ Z (lower half) of the rows (γ, 1, φ, u if D is wanted, y) over a stretch.
fn normal_equations(a: &DMatrix<f64>, c: &RowDVector<f64>, width: usize, stretch: &Stretch) -> DMatrix<f64> {
    match c.len() {
        1 => normal_equations_order::<1>(a, c, width, stretch),
        2 => normal_equations_order::<2>(a, c, width, stretch),
        3 => normal_equations_order::<3>(a, c, width, stretch),
        4 => normal_equations_order::<4>(a, c, width, stretch),
        _ => normal_equations_order::<5>(a, c, width, stretch),
    }
}

fn normal_equations_order<const N: usize>(
    a: &DMatrix<f64>,
    c: &RowDVector<f64>,
    width: usize,
    stretch: &Stretch,
) -> DMatrix<f64> {
    let columns: [[f64; N]; N] = std::array::from_fn(|s| std::array::from_fn(|r| a[(s, r)]));
    let c: [f64; N] = std::array::from_fn(|r| c[r]);
    let (mut phi, mut gamma) = ([0.0; N], c);
    let mut rows = vec![0.0; width * CHUNK.min(stretch.u.len())];
    let mut total = DMatrix::zeros(width, width);
    for (u, y) in stretch.u.chunks(CHUNK).zip(stretch.y.chunks(CHUNK)) {
        for ((row, u), y) in rows.chunks_exact_mut(width).zip(u).zip(y) {
            row[..N].copy_from_slice(&gamma);
            row[N] = 1.0;
            row[N + 1..=2 * N].copy_from_slice(&phi);
            row[width - 2] = if width == 2 * N + 3 { *u } else { phi[N - 1] };
            row[width - 1] = *y;
            phi = advance(&columns, &phi, &c.map(|c| c * u));
            gamma = advance(&columns, &gamma, &[0.0; N]);
        }
        total += gram(&rows[..width * u.len()], width);
        // on long records a decayed response would end in denormal numbers, which are slow
        if gamma.iter().all(|g| g.abs() < DECAYED) {
            gamma = [0.0; N];
        }
    }
    total
}

/// A x + b, A by columns.
fn advance<const N: usize>(columns: &[[f64; N]; N], x: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let mut next = *b;
    for (column, x) in columns.iter().zip(x) {
        for (next, a) in next.iter_mut().zip(column) {
            *next += a * x;
        }
    }
    next
}

/// Takes the first `count` unknowns out of the normal equations `s` (lower half). The column of one that shows nothing
/// of its own becomes zero.
pub(super) fn eliminate(s: &mut DMatrix<f64>, count: usize) {
    let size = s.nrows();
    let whole: Vec<f64> = s.diagonal().iter().copied().collect();
    for p in 0..count {
        let pivot = s[(p, p)];
        if pivot <= NOTHING_LEFT * whole[p] {
            s.view_mut((p, p), (size - p, 1)).fill(0.0);
            continue;
        }
        for j in p + 1..size {
            let factor = s[(j, p)] / pivot;
            for i in j..size {
                s[(i, j)] -= factor * s[(i, p)];
            }
        }
    }
}

/// Solves normal equations (lower half, right-hand side in the last row), scaled to a unit diagonal.
fn solve(s: &DMatrix<f64>, unknowns: usize) -> Option<DVector<f64>> {
    let scale = DVector::from_fn(unknowns, |i, _| s[(i, i)].max(f64::MIN_POSITIVE).sqrt());
    let matrix = DMatrix::from_fn(unknowns, unknowns, |i, j| s[(i.max(j), i.min(j))] / (scale[i] * scale[j]));
    let target = DVector::from_fn(unknowns, |i, _| s[(unknowns, i)] / scale[i]);
    let solution = matrix.cholesky()?.solve(&target).component_div(&scale);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

/// Sums over one validation section: squares of y and of y − ŷ about their means; ŷ is the free run of `model` from
/// rest over `u`, as [`StateSpace::simulate`] gives it.
pub(super) fn free_run_squares(model: &StateSpace, u: &[f64], y: &[f64]) -> [f64; 2] {
    match model.order() {
        1 => squares_order::<1>(model, u, y),
        2 => squares_order::<2>(model, u, y),
        3 => squares_order::<3>(model, u, y),
        4 => squares_order::<4>(model, u, y),
        _ => squares_order::<5>(model, u, y),
    }
}

fn squares_order<const N: usize>(model: &StateSpace, u: &[f64], y: &[f64]) -> [f64; 2] {
    let columns: [[f64; N]; N] = std::array::from_fn(|s| std::array::from_fn(|r| model.a()[(r, s)]));
    let (b, c): ([f64; N], [f64; N]) =
        (std::array::from_fn(|r| model.b()[r]), std::array::from_fn(|r| model.c()[r]));
    let mut x = [0.0; N];
    let mut sums = [0.0; 4];
    let delayed = std::iter::repeat_n(&0.0, model.delay_samples()).chain(u);
    for (u, y) in delayed.zip(y) {
        let simulated = model.d() * u + c.iter().zip(&x).map(|(c, x)| c * x).sum::<f64>();
        let error = y - simulated;
        for (sum, term) in sums.iter_mut().zip([*y, y * y, error, error * error]) {
            *sum += term;
        }
        x = advance(&columns, &x, &b.map(|b| b * u));
    }
    let count = y.len().max(1) as f64;
    [sums[1] - sums[0] * sums[0] / count, sums[3] - sums[2] * sums[2] / count]
}
