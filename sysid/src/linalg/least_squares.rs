//! Linear least squares of more rows than are kept, by the normal equations.

use nalgebra::{DMatrix, DVector};

/// Added to the normal matrix, of its mean diagonal: it decides only directions that the rows do not excite.
const RIDGE: f64 = 1e-10;

/// The weights w of least Σ (y − wᵀ x)² over `rows` (x, y) with x of `columns` values; `None` where no row says anything.
pub fn least_squares(
    columns: usize,
    rows: impl Iterator<Item = (DVector<f64>, f64)>,
) -> Option<DVector<f64>> {
    let mut normal = DMatrix::<f64>::zeros(columns, columns);
    let mut right = DVector::<f64>::zeros(columns);
    for (x, y) in rows {
        normal.ger(1.0, &x, &x, 1.0);
        right.axpy(y, &x, 1.0);
    }
    if normal.trace() <= 0.0 {
        return None;
    }
    let ridge = RIDGE * normal.trace() / columns as f64;
    for i in 0..columns {
        normal[(i, i)] += ridge;
    }
    Some(normal.cholesky()?.solve(&right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_nothing_is_none() {
        let line = |k: u32| (DVector::from_vec(vec![1.0, f64::from(k)]), 2.0 - 0.5 * f64::from(k));
        let weights = least_squares(2, (0..10).map(line)).unwrap();
        assert!((weights[0] - 2.0).abs() < 1e-6 && (weights[1] + 0.5).abs() < 1e-6, "{weights}");
        assert!(
            least_squares(2, std::iter::empty()).is_none() && least_squares(0, std::iter::empty()).is_none()
        );
    }
}
