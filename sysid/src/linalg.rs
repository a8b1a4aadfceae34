//! Decompositions of dense matrices: nalgebra's matrices, faer's algorithms, always sequential so that results repeat.
//!
//! nalgebra 0.35's own singular value decomposition returns vectors that do not reproduce the matrix for about one in a
//! hundred matrices of deficient rank.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{LltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::evd::{
    ComputeEigenvectors, evd_real, evd_scratch, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::qr::no_pivoting::factor::{qr_in_place, qr_in_place_scratch, recommended_block_size};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix};

/// Singular values above this share of the largest keep six digits of their vectors when squared.
const SAFE_TO_SQUARE: f64 = 1e-5;

fn view(a: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

fn view_mut(a: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = a.shape();
    MatMut::from_column_major_slice_mut(a.as_mut_slice(), rows, columns)
}

fn finite(a: &DMatrix<f64>) -> bool {
    a.iter().all(|x| x.is_finite())
}

fn with_room<T>(room: StackReq, work: impl FnOnce(&mut MemStack) -> T) -> T {
    work(MemStack::new(&mut MemBuffer::new(room)))
}

/// Left singular vectors (as columns) and singular values of `a`, the largest first. `None` for entries that are not
/// finite.
pub(crate) fn left_singular(a: &DMatrix<f64>) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let (rows, columns) = a.shape();
    let size = rows.min(columns);
    if size == 0 || !finite(a) {
        return None;
    }
    let (mut vectors, mut values) = (DMatrix::zeros(rows, size), Diag::zeros(size));
    let (left, right) = (ComputeSvdVectors::Thin, ComputeSvdVectors::No);
    let room = svd_scratch::<f64>(rows, columns, left, right, Par::Seq, Default::default());
    with_room(room, |stack| {
        let u = Some(view_mut(&mut vectors));
        svd(view(a), values.as_mut(), u, None, Par::Seq, stack, Default::default())
    })
    .ok()?;
    let values = values.column_vector().iter().copied().collect();
    Some((vectors, values))
}

/// The first `count` left singular vectors of `a` (as columns), and all singular values, the largest first; faster than
/// [`left_singular`] where none of the first is below 1e-5 of the largest, for then they are eigenvectors of a aᵀ.
pub(crate) fn leading_left_singular(a: &DMatrix<f64>, count: usize) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let n = a.nrows();
    if n < count || a.ncols() < n || !finite(a) {
        return None;
    }
    let mut square = DMatrix::zeros(n, n);
    matmul(view_mut(&mut square), Accum::Replace, view(a), view(a).transpose(), 1.0, Par::Seq);
    let (mut vectors, mut values) = (DMatrix::zeros(n, n), Diag::zeros(n));
    let room = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    let found = with_room(room, |stack| {
        let u = Some(view_mut(&mut vectors));
        self_adjoint_evd(view(&square), values.as_mut(), u, Par::Seq, stack, Default::default())
    });
    let values: Vec<f64> = values.column_vector().iter().rev().map(|v| v.max(0.0).sqrt()).collect();
    if found.is_err() || count == 0 || values[count - 1] <= SAFE_TO_SQUARE * values[0] {
        return left_singular(a).map(|(vectors, values)| (vectors.columns(0, count).into_owned(), values));
    }
    Some((DMatrix::from_fn(n, count, |i, j| vectors[(i, n - 1 - j)]), values))
}

/// L with L Lᵀ = `a`, from its lower half; `None` where `a` is not positive definite.
pub(crate) fn cholesky(mut a: DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !finite(&a) {
        return None;
    }
    let room = cholesky_in_place_scratch::<f64>(a.nrows(), Par::Seq, Default::default());
    let factored = with_room(room, |stack| {
        let plain = LltRegularization::default();
        cholesky_in_place(view_mut(&mut a), plain, Par::Seq, stack, Default::default())
    });
    factored.ok().map(|_| a)
}

/// b ← L⁻¹ b; what stands above the diagonal of `l` is not read.
pub(crate) fn solve_lower(l: &DMatrix<f64>, b: &mut DMatrix<f64>) {
    solve_lower_triangular_in_place(view(l), view_mut(b), Par::Seq);
}

/// R of `a` = Q R, with as many rows as columns; `a` has at least as many rows as columns. Below the diagonal of the
/// result stand zeros.
pub(crate) fn upper_factor(mut a: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (rows, columns) = a.shape();
    if rows < columns || columns == 0 || !finite(&a) {
        return None;
    }
    let block = recommended_block_size::<f64>(rows, columns);
    let mut reflectors = Mat::<f64>::zeros(block, columns);
    let room = qr_in_place_scratch::<f64>(rows, columns, block, Par::Seq, Default::default());
    with_room(room, |stack| {
        qr_in_place(view_mut(&mut a), reflectors.as_mut(), Par::Seq, stack, Default::default());
    });
    Some(a.view((0, 0), (columns, columns)).upper_triangle())
}

/// Aᵀ A.
pub(crate) fn gram(a: MatRef<'_, f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.ncols(), a.ncols());
    matmul(view_mut(&mut product), Accum::Replace, a.transpose(), a, 1.0, Par::Seq);
    product
}

/// Eigenvalues of the square `a`, balanced first (Parlett, Reinsch, Numerische Mathematik 13, 1969), for companion and
/// Hamiltonian matrices mix sizes; in no particular order. `None` where an entry is not finite or the iteration fails.
pub(crate) fn eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let n = a.nrows();
    if n == 0 || !a.is_square() || !finite(a) {
        return None;
    }
    let mut balanced = a.clone();
    let _scales = balance_parlett_reinsch(&mut balanced);
    let (mut re, mut im) = (Diag::zeros(n), Diag::zeros(n));
    let none = ComputeEigenvectors::No;
    with_room(evd_scratch::<f64>(n, none, none, Par::Seq, Default::default()), |stack| {
        evd_real(view(&balanced), re.as_mut(), im.as_mut(), None, None, Par::Seq, stack, Default::default())
    })
    .ok()?;
    let pairs = re.column_vector().iter().zip(im.column_vector().iter());
    let values: Vec<Complex<f64>> = pairs.map(|(re, im)| Complex::new(*re, *im)).collect();
    values.iter().all(|v| v.re.is_finite() && v.im.is_finite()).then_some(values)
}
