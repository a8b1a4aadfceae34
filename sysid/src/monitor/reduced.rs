//! A stable filter in balanced coordinates, reduced, and in blocks of two states.
//!
//! ```text
//! x⁺ = F x + B m,  y = C x      P = F P Fᵀ + B Bᵀ,  Q = Fᵀ Q F + Cᵀ C,   σ_i² = eigenvalues of P Q
//! ```
//!
//! Cutting the states with the smallest σ moves the output by at most 2 Σ σ_cut times the input's energy (Moore, IEEE
//! Transactions on Automatic Control 26, 1981; the bound: Al-Saggaf and Franklin, 1987).

use nalgebra::{Complex, DMatrix};

/// A filter with any number of inputs and outputs.
#[derive(Clone, Debug)]
pub struct Linear {
    /// F.
    pub f: DMatrix<f64>,
    /// B, a column for each input.
    pub b: DMatrix<f64>,
    /// C, a row for each output.
    pub c: DMatrix<f64>,
}

/// States with a σ below this share of the largest show in nothing.
const NEGLIGIBLE: f64 = 1e-7;

impl Linear {
    /// The filter with at most `most` states, and the bound on the error. `None` where it is not stable.
    pub fn reduced(&self, most: usize) -> Option<(Self, f64)> {
        let p = gramian(&self.f, &(&self.b * self.b.transpose()))?;
        let q = gramian(&self.f.transpose(), &(self.c.transpose() * &self.c))?;
        let (r, s) = (root(&p), root(&q));
        let svd = (s.transpose() * &r).svd(true, true);
        let (u, v, sigma) = (svd.u?, svd.v_t?.transpose(), svd.singular_values);
        let kept = sigma.iter().filter(|&&s| s > NEGLIGIBLE * sigma[0]).count().min(most);
        let error = 2.0 * sigma.iter().skip(kept).sum::<f64>();
        let scale = DMatrix::from_diagonal(&sigma.rows(0, kept).map(|s| 1.0 / s.sqrt()));
        let out = &r * v.columns(0, kept) * &scale;
        let into = scale * u.columns(0, kept).transpose() * s.transpose();
        Some((Self { f: &into * &self.f * &out, b: into * &self.b, c: &self.c * out }, error))
    }

    /// The same filter with a block-diagonal F, blocks of two, an odd state with a still one beside it. `None` where poles
    /// cannot be told apart.
    pub fn in_blocks(&self) -> Option<Self> {
        let n = self.f.nrows();
        let mut poles: Vec<Complex<f64>> = self.f.complex_eigenvalues().iter().copied().collect();
        poles.sort_by(|a, b| {
            (a.re, a.im.abs()).partial_cmp(&(b.re, b.im.abs())).unwrap_or(core::cmp::Ordering::Equal)
        });
        let (complex, real): (Vec<_>, Vec<_>) = poles.into_iter().partition(|pole| pole.im.abs() > 1e-12);
        let pairs =
            complex.iter().filter(|pole| pole.im > 0.0).map(|pole| (2.0 * pole.re, pole.norm_sqr(), 2));
        let beside = real.chunks(2).map(|chunk| match chunk {
            [a, b] => (a.re + b.re, a.re * b.re, 2),
            [a, ..] => (a.re, 0.0, 1),
            [] => (0.0, 0.0, 0),
        });
        let blocks: Vec<(f64, f64, usize)> = pairs.chain(beside).collect();
        let mut basis = DMatrix::zeros(n, n);
        let mut at = 0;
        for (sum, product, size) in &blocks {
            // the invariant subspace: the kernel of F² − sum F + product, or of F − sum
            let kernel = if *size == 2 {
                &self.f * &self.f - &self.f * *sum + DMatrix::identity(n, n) * *product
            } else {
                &self.f - DMatrix::identity(n, n) * *sum
            };
            let svd = kernel.svd(false, true);
            let v = svd.v_t?;
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j]));
            for row in order.into_iter().take(*size) {
                basis.set_column(at, &v.row(row).transpose());
                at += 1;
            }
        }
        if at != n {
            return None;
        }
        let into = basis.clone().try_inverse()?;
        let mut f = &into * &self.f * &basis;
        let (b, c) = (&into * &self.b, &self.c * &basis);
        // what lies outside the blocks is rounding
        let mut place = 0;
        let mut own = DMatrix::from_element(n, n, false);
        for (.., size) in &blocks {
            own.view_mut((place, place), (*size, *size)).fill(true);
            place += size;
        }
        let left = f.zip_map(&own, |value, own| if own { 0.0 } else { value }).amax();
        f.zip_apply(&own, |value, own| {
            if !own {
                *value = 0.0;
            }
        });
        (left < 1e-6 && f.iter().chain(&b).chain(&c).all(|x| x.is_finite())).then_some(Self { f, b, c })
    }
}

/// Σ Fᵏ W Fᵏᵀ by doubling. `None` where the sum does not end.
fn gramian(f: &DMatrix<f64>, w: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (mut f, mut sum) = (f.clone(), w.clone());
    for _ in 0..60 {
        let more = &f * &sum * f.transpose();
        sum += &more;
        f = &f * &f;
        if !sum.iter().all(|x| x.is_finite()) {
            return None;
        }
        if more.amax() <= 1e-14 * sum.amax() {
            return Some(sum);
        }
    }
    None
}

/// A with A Aᵀ = `matrix`, symmetric and positive but for rounding.
fn root(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = ((matrix + matrix.transpose()) * 0.5).symmetric_eigen();
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulses(filter: &Linear, count: usize) -> Vec<DMatrix<f64>> {
        let mut x = filter.b.clone();
        let mut all = Vec::new();
        for _ in 0..count {
            all.push(&filter.c * &x);
            x = &filter.f * x;
        }
        all
    }

    /// Two oscillations, a pair of equal real poles with a chain between them, and a state that shows in nothing.
    fn filter() -> Linear {
        let mut f = DMatrix::zeros(7, 7);
        for (at, radius, angle) in [(0, 0.95, 0.2_f64), (2, 0.7, 1.1)] {
            let (sin, cos) = (radius * angle.sin(), radius * angle.cos());
            f.view_mut((at, at), (2, 2)).copy_from_slice(&[cos, sin, -sin, cos]);
        }
        (f[(4, 4)], f[(4, 5)], f[(5, 5)], f[(6, 6)]) = (0.9, 1.0, 0.9, 0.5);
        let b = DMatrix::from_fn(7, 2, |i, j| 0.3 + 0.1 * (i as f64) - 0.2 * (j as f64));
        let mut c = DMatrix::from_fn(2, 7, |i, j| 0.5 - 0.1 * (i as f64) + 0.05 * (j as f64));
        c.column_mut(6).fill(0.0);
        Linear { f, b, c }
    }

    #[test]
    fn what_does_not_show_is_cut_and_the_response_stays() {
        let full = filter();
        let (reduced, error) = full.reduced(6).unwrap();
        assert_eq!(reduced.f.nrows(), 6);
        assert!(error < 1e-6, "{error}");
        let blocks = reduced.in_blocks().unwrap();
        for (a, b) in pulses(&full, 80).iter().zip(&pulses(&blocks, 80)) {
            assert!((a - b).amax() < 1e-6, "{a} {b}");
        }
        let f = &blocks.f;
        for i in 0..6 {
            for j in 0..6 {
                assert!(i / 2 == j / 2 || f[(i, j)] == 0.0);
            }
        }
    }

    #[test]
    fn a_shorter_one_is_off_by_no_more_than_its_bound() {
        let full = filter();
        let (reduced, bound) = full.reduced(3).unwrap();
        let (a, b) = (pulses(&full, 400), pulses(&reduced, 400));
        let input = |k: usize, j: usize| ((k * (j + 3)) as f64 * 0.37).sin();
        let (mut energy, mut error) = (0.0, 0.0);
        for k in 0..400 {
            let mut off = [0.0; 2];
            for (i, off) in off.iter_mut().enumerate() {
                for m in 0..=k {
                    *off += (0..2).map(|j| (a[m][(i, j)] - b[m][(i, j)]) * input(k - m, j)).sum::<f64>();
                }
            }
            error += off.iter().map(|x| x * x).sum::<f64>();
            energy += (0..2).map(|j| input(k, j).powi(2)).sum::<f64>();
        }
        assert!(error.sqrt() <= bound * energy.sqrt() && bound > 0.0, "{error} {bound}");
    }

    #[test]
    fn a_filter_that_grows_is_refused() {
        let mut full = filter();
        full.f[(6, 6)] = 1.01;
        assert!(full.reduced(6).is_none());
    }
}
