//! Discrete-time state space with one input and one output:
//!
//! ```text
//! x[k+1] = A x[k] + B u[k−d]
//! y[k]   = C x[k] + D u[k−d]
//! ```
//!
//! Recordings hold u\[k\] over [t_k, t_k+1) and take y\[k\] at t_k, so a model of a held input has D = 0: u\[k\] acts on
//! y[k+1+d] at the earliest, with C B.

use crate::error::{Error, ErrorKind};
use nalgebra::{Complex, DMatrix, DVector, RowDVector, Schur};
use std::f64::consts::PI;

/// Rounds of the eigenvalue iteration; a model of the orders used here takes a few per eigenvalue.
const EIGENVALUE_ROUNDS: usize = 10_000;
/// Directions of x0 that show in a section less than this, against the best visible one, are left at zero.
const INVISIBLE: f64 = 1e-10;

/// A model, checked: shapes fit, every number is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    a: DMatrix<f64>,
    b: DVector<f64>,
    c: RowDVector<f64>,
    d: f64,
    step: f64,
    delay_samples: usize,
    poles: Vec<Complex<f64>>,
}

impl StateSpace {
    /// A model of order n: `a` n × n, `b` n × 1, `c` 1 × n, sample period `step` > 0 in s, input delay in samples.
    ///
    /// # Errors
    /// Shapes that do not fit, a number that is not finite, eigenvalues that cannot be computed.
    pub fn new(
        a: DMatrix<f64>,
        b: DVector<f64>,
        c: RowDVector<f64>,
        d: f64,
        step: f64,
        delay_samples: usize,
    ) -> Result<Self, Error> {
        let n = b.len();
        if n == 0 || a.shape() != (n, n) || c.len() != n {
            let found = format!("A is {} × {}, B {n} × 1, C 1 × {}", a.nrows(), a.ncols(), c.len());
            return Err(Error::new(ErrorKind::Model, found, "give matrices of one order, 1 or more")
                .expecting("A n × n, B n × 1, C 1 × n"));
        }
        let finite = a.iter().chain(&b).chain(&c).chain([&d, &step]).all(|x| x.is_finite());
        if !finite || step <= 0.0 {
            return Err(Error::new(
                ErrorKind::Model,
                format!("a state-space model with a step of {step} s, or an entry that is no finite number"),
                "check the data and the method that gave the model",
            ));
        }
        let mut poles = eigenvalues(&a)?;
        poles.sort_by(|p, q| q.norm().total_cmp(&p.norm()).then(p.arg().total_cmp(&q.arg())));
        Ok(Self { a, b, c, d, step, delay_samples, poles })
    }

    /// A, n × n.
    #[must_use]
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }
    /// B, n × 1.
    #[must_use]
    pub fn b(&self) -> &DVector<f64> {
        &self.b
    }
    /// C, 1 × n.
    #[must_use]
    pub fn c(&self) -> &RowDVector<f64> {
        &self.c
    }
    /// D.
    #[must_use]
    pub fn d(&self) -> f64 {
        self.d
    }
    /// Sample period, s.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }
    /// d, samples.
    #[must_use]
    pub fn delay_samples(&self) -> usize {
        self.delay_samples
    }
    /// Number of states n, at least 1.
    #[must_use]
    pub fn order(&self) -> usize {
        self.b.len()
    }

    /// Eigenvalues of A, the largest in magnitude first; of a pair the one below the real axis first.
    #[must_use]
    pub fn poles(&self) -> &[Complex<f64>] {
        &self.poles
    }

    /// Largest magnitude of the poles.
    #[must_use]
    pub fn spectral_radius(&self) -> f64 {
        self.poles.first().map_or(0.0, |pole| pole.norm())
    }

    /// Whether all poles lie inside the unit circle.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.spectral_radius() < 1.0
    }

    /// Free run over the input `u` from x\[0\] = `x0`, zero where not given; entries that `x0` lacks are zero.
    /// The d inputs before the slice count as zero.
    ///
    /// An unstable model may overflow; from there on the output is infinite, never NaN.
    #[must_use]
    pub fn simulate(&self, u: &[f64], x0: Option<&DVector<f64>>) -> Vec<f64> {
        let n = self.order();
        let mut x = x0.map_or_else(|| DVector::zeros(n), |x0| x0.clone().resize_vertically(n, 0.0));
        let mut next = DVector::zeros(n);
        let mut y = Vec::with_capacity(u.len());
        let delayed = std::iter::repeat_n(0.0, self.delay_samples).chain(u.iter().copied());
        for u in delayed.take(u.len()) {
            let output = self.c.tr_dot(&x) + self.d * u;
            if !output.is_finite() {
                break;
            }
            y.push(output);
            next.copy_from(&self.b);
            next.gemv(1.0, &self.a, &x, u);
            std::mem::swap(&mut x, &mut next);
        }
        y.resize(u.len(), f64::INFINITY);
        y
    }

    /// First `n` samples of the response to a unit pulse of one sample: zero for k < d, D at k = d, C A^(k−d−1) B after.
    #[must_use]
    pub fn impulse_response(&self, n: usize) -> Vec<f64> {
        let mut pulse = vec![0.0; n];
        if let Some(first) = pulse.first_mut() {
            *first = 1.0;
        }
        self.simulate(&pulse, None)
    }

    /// Response from the input's samples to the output's at `omega` rad/s, |ω| ≤ π/T:
    /// (C (zI − A)⁻¹ B + D) z^−d with z = e^jωT. `None` beyond this range, and exactly at a pole.
    #[must_use]
    pub fn frequency_response(&self, omega: f64) -> Option<Complex<f64>> {
        let angle = omega * self.step;
        if angle.is_nan() || angle.abs() > PI * (1.0 + f64::EPSILON) {
            return None;
        }
        let z = Complex::cis(angle);
        let n = self.order();
        let shifted = DMatrix::from_diagonal_element(n, n, z) - self.a.map(Complex::from);
        let states = shifted.lu().solve(&self.b.map(Complex::from))?;
        let direct: Complex<f64> = self.c.iter().zip(&states).map(|(c, x)| x * *c).sum();
        let response = (direct + self.d) * Complex::cis(-angle * self.delay_samples as f64);
        (response.re.is_finite() && response.im.is_finite()).then_some(response)
    }

    /// x\[0\] of the section (`u`, `y`) by least squares on the free run: the x0 that minimises var(y − ŷ), and so
    /// maximises the section's VAF; a constant offset does not count there and is free here.
    ///
    /// Directions that the section does not show stay at zero.
    ///
    /// # Errors
    /// `u` and `y` of different length or with fewer than n + 2 samples, a model whose free run overflows.
    pub fn initial_state(&self, u: &[f64], y: &[f64]) -> Result<DVector<f64>, Error> {
        let n = self.order();
        if u.len() != y.len() || y.len() < n + 2 {
            let found = format!("{} samples of the input, {} of the output", u.len(), y.len());
            return Err(Error::new(ErrorKind::TooShort, found, "give both over one whole section")
                .expecting(format!("as many of each, at least {}", n + 2)));
        }
        let mut left = DVector::from_column_slice(y) - DVector::from_vec(self.simulate(u, None));
        let mut shown = DMatrix::zeros(y.len(), n);
        let mut row = self.c.clone();
        for mut k in shown.row_iter_mut() {
            k.copy_from(&row);
            row *= &self.a;
        }
        left.add_scalar_mut(-left.mean());
        for mut column in shown.column_iter_mut() {
            let mean = column.mean();
            column.add_scalar_mut(-mean);
        }
        let overflow = || {
            Error::new(
                ErrorKind::Numerical,
                format!("the free run of a model with spectral radius {} overflows", self.spectral_radius()),
                "use a stable model, or a shorter section",
            )
        };
        if !left.iter().chain(shown.iter()).all(|x| x.is_finite()) {
            return Err(overflow());
        }
        let qr = shown.col_piv_qr();
        let (r, mut x0) = (qr.r(), DVector::zeros(n));
        let visible = r.diagonal().iter().take_while(|size| size.abs() > INVISIBLE * r[(0, 0)].abs()).count();
        let target = qr.q().tr_mul(&left);
        let known = r.view((0, 0), (visible, visible)).solve_upper_triangular(&target.rows(0, visible));
        x0.rows_mut(0, visible).copy_from(&known.ok_or_else(overflow)?);
        qr.p().inv_permute_rows(&mut x0);
        if x0.iter().all(|x| x.is_finite()) { Ok(x0) } else { Err(overflow()) }
    }
}

fn eigenvalues(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, Error> {
    let schur = Schur::try_new(a.clone(), f64::EPSILON, EIGENVALUE_ROUNDS);
    let values = schur.map(|schur| schur.complex_eigenvalues());
    let finite = values.filter(|values| values.iter().all(|v| v.re.is_finite() && v.im.is_finite()));
    finite.map(|values| values.iter().copied().collect()).ok_or_else(|| {
        let advice = "scale the signals to SI units, or choose a lower order";
        Error::new(ErrorKind::Numerical, "the eigenvalues of A could not be computed", advice)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector(x: &[f64]) -> DVector<f64> {
        DVector::from_column_slice(x)
    }

    /// Damped rotation: C Aⁱ B = rⁱ cos(iφ).
    fn rotation(radius: f64, angle: f64, delay: usize) -> StateSpace {
        let (re, im) = (radius * angle.cos(), radius * angle.sin());
        let a = DMatrix::from_row_slice(2, 2, &[re, -im, im, re]);
        StateSpace::new(a, vector(&[1.0, 0.0]), RowDVector::from_row_slice(&[1.0, 0.0]), 0.0, 0.02, delay)
            .unwrap()
    }

    #[test]
    fn pulse_and_free_response_meet_the_closed_form() {
        let model = rotation(0.9, 0.4, 3);
        let pulse = model.impulse_response(40);
        let free = model.simulate(&[0.0; 40], Some(&vector(&[0.0, 2.0])));
        for k in 0..40 {
            let i = k as i32 - 4;
            let expected = if i < 0 { 0.0 } else { 0.9_f64.powi(i) * (0.4 * f64::from(i)).cos() };
            assert!((pulse[k] - expected).abs() < 1e-14, "{k}");
            assert!((free[k] + 2.0 * 0.9_f64.powi(k as i32) * (0.4 * k as f64).sin()).abs() < 1e-14, "{k}");
        }
    }

    #[test]
    fn first_order_step_and_frequency_response_meet_the_closed_form() {
        let one = RowDVector::from_element(1, 1.0);
        let model =
            StateSpace::new(DMatrix::from_element(1, 1, 0.8), vector(&[0.5]), one, 0.25, 0.02, 2).unwrap();
        let step = model.simulate(&[1.0; 30], None);
        assert_eq!(step[..2], [0.0, 0.0]);
        for (k, y) in step[2..].iter().enumerate() {
            assert!((y - (0.25 + 0.5 * (1.0 - 0.8_f64.powi(k as i32)) / 0.2)).abs() < 1e-14);
        }
        for omega in [0.0, 1.0, 30.0, -30.0, PI / 0.02] {
            let z = Complex::cis(omega * 0.02);
            let expected = (Complex::from(0.5) / (z - 0.8) + 0.25) / (z * z);
            assert!((model.frequency_response(omega).unwrap() - expected).norm() < 1e-14);
        }
        assert!(model.frequency_response(200.0).is_none() && model.frequency_response(f64::NAN).is_none());
    }

    #[test]
    fn poles_tell_stability() {
        let model = rotation(0.9, 0.4, 0);
        assert!((model.poles()[0] - Complex::from_polar(0.9, -0.4)).norm() < 1e-14);
        assert!((model.poles()[1] - Complex::from_polar(0.9, 0.4)).norm() < 1e-14);
        assert!(model.is_stable() && (model.spectral_radius() - 0.9).abs() < 1e-14);
        assert!(!rotation(1.01, 0.4, 0).is_stable());
    }

    #[test]
    fn an_unstable_free_run_overflows_to_infinity_and_not_to_nan() {
        let y = rotation(2.0, 0.4, 0).simulate(&[1.0; 3000], None);
        assert!(y[..900].iter().all(|y| y.is_finite()));
        assert!(y.iter().all(|y| !y.is_nan()) && y[2999] == f64::INFINITY);
        let error = rotation(2.0, 0.4, 0).initial_state(&[1.0; 3000], &[0.0; 3000]).unwrap_err();
        assert!(error.to_string().contains("overflows"), "{error}");
    }

    #[test]
    fn the_initial_state_is_recovered_whatever_the_offset() {
        let model = rotation(0.97, 0.3, 1);
        let u: Vec<f64> =
            (0..300).map(|k| (0.1 * f64::from(k) * (1.0 + 0.01 * f64::from(k))).sin()).collect();
        let truth = vector(&[0.7, -1.3]);
        let y: Vec<f64> = model.simulate(&u, Some(&truth)).iter().map(|y| y + 5.0).collect();
        assert!((model.initial_state(&u, &y).unwrap() - &truth).norm() < 1e-10);
        assert!(model.initial_state(&u, &y[1..]).is_err() && model.initial_state(&u[..3], &y[..3]).is_err());
    }

    #[test]
    fn a_state_that_does_not_show_stays_at_zero() {
        let c = RowDVector::from_row_slice(&[1.0, 0.0]);
        let a = DMatrix::from_row_slice(2, 2, &[0.9, 0.0, 0.0, 0.5]);
        let model = StateSpace::new(a, vector(&[1.0, 1.0]), c, 0.0, 0.02, 0).unwrap();
        let u = [0.0; 50];
        let y = model.simulate(&u, Some(&vector(&[2.0, 7.0])));
        assert!((model.initial_state(&u, &y).unwrap() - vector(&[2.0, 0.0])).norm() < 1e-10);
    }

    #[test]
    fn shapes_and_numbers_are_checked() {
        let c = || RowDVector::from_element(1, 1.0);
        assert!(
            StateSpace::new(DMatrix::from_row_slice(1, 2, &[0.1, 0.2]), vector(&[1.0]), c(), 0.0, 0.02, 0)
                .is_err()
        );
        assert!(
            StateSpace::new(DMatrix::from_element(1, 1, f64::NAN), vector(&[1.0]), c(), 0.0, 0.02, 0)
                .is_err()
        );
        assert!(StateSpace::new(DMatrix::from_element(1, 1, 0.1), vector(&[1.0]), c(), 0.0, 0.0, 0).is_err());
        let empty = RowDVector::zeros(0);
        assert!(StateSpace::new(DMatrix::zeros(0, 0), DVector::zeros(0), empty, 0.0, 0.02, 0).is_err());
    }
}
