//! Decompositions of dense matrices, always sequential so that results repeat.
//!
//! nalgebra's, but for the singular value decomposition: that of nalgebra 0.35 returns vectors that do not reproduce the
//! matrix for about one in a hundred matrices of deficient rank.

pub mod least_squares;

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DMatrixView, Schur, SymmetricEigen};

/// Singular values above this share of the largest keep six digits of their vectors when squared.
const SAFE_TO_SQUARE: f64 = 1e-5;
/// Sweeps of rotations until rows are at right angles; half of these have been enough for any matrix.
const MOST_SWEEPS: usize = 40;
/// Iterations of an eigenvalue search for each row.
const MOST_ITERATIONS: usize = 100;

fn finite(a: &DMatrix<f64>) -> bool {
    a.iter().all(|x| x.is_finite())
}

/// Left singular vectors (as columns) and singular values of `a`, the largest first. `None` for entries that are not
/// finite.
///
/// Columns of R of aᵀ = Q R, which are the rows of a seen from Q, are turned against one another until all are at right angles (Hestenes, Journal of the SIAM 6,
/// 1958): the rotations together are the vectors, orthonormal whatever the rank.
pub(crate) fn left_singular(a: &DMatrix<f64>) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let (rows, columns) = a.shape();
    if rows.min(columns) == 0 || !finite(a) {
        return None;
    }
    if rows > columns {
        let factors = a.clone().qr();
        let (vectors, values) = left_singular(&factors.r())?;
        return Some((factors.q() * vectors, values));
    }
    let lower = a.transpose().qr().r();
    let (mut work, mut turned) = (lower, DMatrix::<f64>::identity(rows, rows));
    let small = f64::EPSILON * work.norm();
    for _ in 0..MOST_SWEEPS {
        let mut most = 0.0_f64;
        for p in 0..rows {
            for q in p + 1..rows {
                let (x, y, xy) = (
                    work.column(p).norm_squared(),
                    work.column(q).norm_squared(),
                    work.column(p).dot(&work.column(q)),
                );
                if xy.abs() <= f64::EPSILON * (x * y).sqrt() || x.max(y).sqrt() <= small {
                    continue;
                }
                most = most.max(xy.abs() / (x * y).sqrt());
                let slope = (y - x) / (2.0 * xy);
                let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                turn(&mut work, p, q, cosine, cosine * tangent);
                turn(&mut turned, p, q, cosine, cosine * tangent);
            }
        }
        if most <= f64::EPSILON * rows as f64 {
            break;
        }
    }
    let sizes: Vec<f64> = work.column_iter().map(|column| column.norm()).collect();
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by(|&p, &q| sizes[q].total_cmp(&sizes[p]));
    let vectors = DMatrix::from_fn(rows, rows, |i, j| turned[(i, order[j])]);
    Some((vectors, order.into_iter().map(|p| sizes[p]).collect()))
}

/// (x, y) ← (c x − s y, s x + c y) of two columns.
fn turn(a: &mut DMatrix<f64>, p: usize, q: usize, cosine: f64, sine: f64) {
    let rows = a.nrows();
    let (left, right) = a.as_mut_slice().split_at_mut(q * rows);
    for (x, y) in left[p * rows..(p + 1) * rows].iter_mut().zip(&mut right[..rows]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

/// The first `count` left singular vectors of `a` (as columns), and all singular values, the largest first; faster than
/// [`left_singular`] where none of the first is below 1e-5 of the largest, for then they are eigenvectors of a aᵀ.
pub(crate) fn leading_left_singular(a: &DMatrix<f64>, count: usize) -> Option<(DMatrix<f64>, Vec<f64>)> {
    let n = a.nrows();
    if n < count || a.ncols() < n || !finite(a) {
        return None;
    }
    let found = SymmetricEigen::try_new(a * a.transpose(), f64::EPSILON, MOST_ITERATIONS * n);
    let sorted = found.map(|found| {
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| found.eigenvalues[j].total_cmp(&found.eigenvalues[i]));
        let values: Vec<f64> = order.iter().map(|&i| found.eigenvalues[i].max(0.0).sqrt()).collect();
        (DMatrix::from_fn(n, count, |i, j| found.eigenvectors[(i, order[j])]), values)
    });
    match sorted {
        Some((vectors, values)) if count > 0 && values[count - 1] > SAFE_TO_SQUARE * values[0] => {
            Some((vectors, values))
        }
        _ => left_singular(a).map(|(vectors, values)| (vectors.columns(0, count).into_owned(), values)),
    }
}

/// L with L Lᵀ = `a`, from its lower half; `None` where `a` is not positive definite.
pub(crate) fn cholesky(a: DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !finite(&a) {
        return None;
    }
    a.cholesky().map(nalgebra::Cholesky::unpack)
}

/// b ← L⁻¹ b; what stands above the diagonal of `l` is not read.
pub(crate) fn solve_lower(l: &DMatrix<f64>, b: &mut DMatrix<f64>) {
    l.solve_lower_triangular_unchecked_mut(b);
}

/// R of `a` = Q R, with as many rows as columns; `a` has at least as many rows as columns. Below the diagonal of the
/// result stand zeros.
pub(crate) fn upper_factor(a: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (rows, columns) = a.shape();
    if rows < columns || columns == 0 || !finite(&a) {
        return None;
    }
    Some(a.qr().r())
}

/// Aᵀ A, of A with rows of `width`, one after the other.
pub(crate) fn gram(rows: &[f64], width: usize) -> DMatrix<f64> {
    let transposed = DMatrixView::from_slice(rows, width, rows.len() / width);
    transposed * transposed.transpose()
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
    let found = Schur::try_new(balanced, f64::EPSILON, MOST_ITERATIONS * n)?.complex_eigenvalues();
    found.iter().all(|v| v.re.is_finite() && v.im.is_finite()).then(|| found.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Of a rank that need not be full.
    fn drawn(seed: u64, rows: usize, columns: usize, rank: usize) -> DMatrix<f64> {
        let mut generator = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut of =
            |rows, columns| DMatrix::from_fn(rows, columns, |_, _| generator.random_range(-1.0..1.0));
        of(rows, rank) * of(rank, columns)
    }

    #[test]
    fn singular_vectors_reproduce_the_matrix_whatever_its_rank() {
        for seed in 0..300 {
            let [rows, columns] = [1 + seed as usize % 9, 1 + (seed / 9) as usize % 9];
            let rank = 1 + seed as usize % rows.min(columns);
            let a = drawn(seed, rows, columns, rank);
            let (u, values) = left_singular(&a).unwrap();
            assert_eq!((u.shape(), values.len()), ((rows, rows.min(columns)), rows.min(columns)));
            assert!((u.transpose() * &u - DMatrix::identity(values.len(), values.len())).norm() < 1e-12);
            assert!((&u * u.transpose() * &a - &a).norm() < 1e-12 * (1.0 + a.norm()), "{seed}");
            let sizes: f64 = values.iter().map(|v| v * v).sum();
            assert!((sizes - a.norm_squared()).abs() < 1e-11 * a.norm_squared());
            assert!(values.is_sorted_by(|a, b| a >= b));
            assert!(values[rank..].iter().all(|v| *v < 1e-12 * values[0]), "{values:?}");
            let image = u.transpose() * &a;
            for (i, value) in values.iter().enumerate() {
                assert!((image.row(i).norm() - value).abs() < 1e-12 * values[0]);
            }
        }
    }

    #[test]
    fn the_quick_way_gives_the_same_space() {
        let a = drawn(7, 6, 40, 6);
        let (u, values) = left_singular(&a).unwrap();
        let (quick, squared) = leading_left_singular(&a, 3).unwrap();
        assert!((u.columns(0, 3).transpose() * &quick).svd(false, false).singular_values.min() > 1.0 - 1e-9);
        assert!(values.iter().zip(&squared).all(|(a, b)| (a - b).abs() < 1e-7 * values[0]));
        assert!(leading_left_singular(&a, 7).is_none() && left_singular(&(a * f64::NAN)).is_none());
    }

    #[test]
    fn roots_of_a_polynomial_are_found() {
        // (x − 1)(x − 2)(x² + 1) with its coefficients in a companion matrix
        let coefficients = [-2.0, 3.0, -3.0, 3.0];
        let companion =
            DMatrix::from_fn(
                4,
                4,
                |i, j| {
                    if j == 3 { coefficients[i] } else { f64::from(u8::from(i == j + 1)) }
                },
            );
        let mut found = eigenvalues(&companion).unwrap();
        found.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        let expected = [(0.0, -1.0), (0.0, 1.0), (1.0, 0.0), (2.0, 0.0)];
        for (found, (re, im)) in found.iter().zip(expected) {
            assert!((found - Complex::new(re, im)).norm() < 1e-12, "{found}");
        }
    }
}
