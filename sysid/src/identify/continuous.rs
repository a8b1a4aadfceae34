//! Continuous-time state spaces, and the way between them and sampled models of a held or an interpolated input:
//!
//! ```text
//! ẋ = A x + B u(t−τ),  y = C x + D u(t−τ)
//! [Φ Γ; 0 I] = exp([A B; 0 0] T)          [A B; 0 0] = log([Φ Γ; 0 I]) / T
//! ```
//!
//! With Ψ = ∫₀ᵀ e^As ds and R = ∫₀ᵀ e^A(T−s) s ds / T, a straight input between samples is Γ = Ψ² B / T and D + C R B in
//! place of Γ = Ψ B and D (Franklin, Powell, Workman, Digital Control of Dynamic Systems, 3rd edition, section 6.3.2).
//!
//! The logarithm is taken by inverse scaling and squaring: square roots (Denman, Beavers, Applied Mathematics and
//! Computation 2, 1976) until the matrix is within 1/4 of the identity, there the diagonal Padé approximant as partial
//! fractions, log(I+X) = Σ_j w_j X (I + x_j X)⁻¹ with the nodes and weights of Gauss–Legendre quadrature on \[0, 1\]
//! (Higham, Functions of Matrices, SIAM 2008, section 11.4).
//!
//! A sampled pole on the negative real axis has no real logarithm: it alternates from sample to sample, which no real
//! pole of a held input can do. Nor has a pole at zero, which is a delay. [`to_continuous`] then names the pole.

use crate::error::{Error, ErrorKind};
use crate::linalg::{eigenvalues, left_singular};
use crate::model::state_space::StateSpace;
use nalgebra::{Complex, DMatrix, DVector};

/// Distance from the identity below which the approximant is exact to rounding.
const NEAR_IDENTITY: f64 = 0.25;
/// Square roots at most: enough for poles of 1e-300.
const MOST_ROOTS: usize = 100;
/// Steps of one square root at most; near the negative axis it takes about 40.
const MOST_STEPS: usize = 200;
/// A pole whose angle is within this of π counts as negative.
const ON_THE_AXIS: f64 = 1e-9;
/// A delay below this is the rounding of two others, s.
const SHORTEST_DELAY_S: f64 = 1e-6;
/// A pole below this counts as zero.
const ZERO: f64 = 1e-12;
/// Largest relative error of exp(log M).
const LARGEST_ERROR: f64 = 1e-8;
/// Halves of the nodes (distance from the middle of \[−1, 1\]) and weights of eight-point Gauss–Legendre quadrature.
const GAUSS_8: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// A continuous-time model with m inputs and p outputs, checked: shapes fit, every number is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct ContinuousStateSpace {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    delay: f64,
}

impl ContinuousStateSpace {
    /// A model of order n: `a` n × n per second, `b` n × m, `c` p × n, `d` p × m, input delay `delay` ≥ 0 in s.
    ///
    /// # Errors
    /// Shapes that do not fit, a number that is not finite, a negative delay.
    pub fn new(
        a: DMatrix<f64>,
        b: DMatrix<f64>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
        delay: f64,
    ) -> Result<Self, Error> {
        let (n, m, p) = (a.nrows(), b.ncols(), c.nrows());
        let fits = a.ncols() == n && b.nrows() == n && c.ncols() == n && d.shape() == (p, m);
        if !fits || n == 0 || m == 0 || p == 0 {
            let shapes = [&a, &b, &c, &d].map(|x| format!("{} × {}", x.nrows(), x.ncols()));
            let found = format!("A is {}, B {}, C {}, D {}", shapes[0], shapes[1], shapes[2], shapes[3]);
            return Err(Error::new(ErrorKind::Model, found, "give matrices of one order, 1 or more")
                .expecting("A n × n, B n × m, C p × n, D p × m"));
        }
        let finite = [&a, &b, &c, &d].iter().all(|x| x.iter().all(|x| x.is_finite()));
        if !finite || !delay.is_finite() || delay < 0.0 {
            let found = format!("a model with a delay of {delay} s, or an entry that is no finite number");
            return Err(Error::new(
                ErrorKind::Model,
                found,
                "check the data and the method that gave the model",
            ));
        }
        Ok(Self { a, b, c, d, delay })
    }

    /// A, n × n, 1/s.
    #[must_use]
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }
    /// B, n × m.
    #[must_use]
    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }
    /// C, p × n.
    #[must_use]
    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }
    /// D, p × m.
    #[must_use]
    pub fn d(&self) -> &DMatrix<f64> {
        &self.d
    }
    /// τ, s.
    #[must_use]
    pub fn delay(&self) -> f64 {
        self.delay
    }
    /// Number of states n.
    #[must_use]
    pub fn order(&self) -> usize {
        self.a.nrows()
    }

    /// Eigenvalues of A, rad/s, the rightmost first.
    ///
    /// # Errors
    /// Eigenvalues that cannot be computed.
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, Error> {
        let mut poles = eigenvalues(&self.a).ok_or_else(|| {
            let advice = "scale the signals to SI units, or choose a lower order";
            Error::new(ErrorKind::Numerical, "the eigenvalues of A could not be computed", advice)
        })?;
        poles.sort_by(|p, q| q.re.total_cmp(&p.re).then(p.im.total_cmp(&q.im)));
        Ok(poles)
    }

    /// C (jωI − A)⁻¹ B + D at `omega` rad/s, without the delay; `None` at a pole on the axis. Infinite `omega` gives D.
    #[must_use]
    pub fn response_without_delay(&self, omega: f64) -> Option<DMatrix<Complex<f64>>> {
        let direct = self.d.map(Complex::from);
        if omega.is_infinite() {
            return Some(direct);
        }
        let n = self.order();
        let shifted =
            DMatrix::from_diagonal_element(n, n, Complex::new(0.0, omega)) - self.a.map(Complex::from);
        let states = shifted.lu().solve(&self.b.map(Complex::from))?;
        let response = self.c.map(Complex::from) * states + direct;
        response.iter().all(|x| x.re.is_finite() && x.im.is_finite()).then_some(response)
    }

    /// The response at `omega` rad/s with the delay, e^−jωτ.
    #[must_use]
    pub fn frequency_response(&self, omega: f64) -> Option<DMatrix<Complex<f64>>> {
        self.response_without_delay(omega).map(|response| response * Complex::cis(-omega * self.delay))
    }

    /// Largest singular value of the response at `omega` rad/s.
    #[must_use]
    pub fn gain(&self, omega: f64) -> Option<f64> {
        let response = self.response_without_delay(omega)?;
        if response.len() == 1 {
            return Some(response[0].norm());
        }
        // the singular values of X + jY are those of [X −Y; Y X], each twice
        let (p, m) = response.shape();
        let real = DMatrix::from_fn(2 * p, 2 * m, |r, s| {
            let z = response[(r % p, s % m)];
            match (r < p, s < m) {
                (true, false) => -z.im,
                (false, true) => z.im,
                _ => z.re,
            }
        });
        left_singular(&real).and_then(|(_, values)| values.first().copied())
    }

    /// The same response with a delay of `delay` s at most: what its own has beyond becomes an all-pass,
    /// (1 − s h/2)/(1 + s h/2) with h = τ − `delay`.
    ///
    /// # Errors
    /// A delay that is negative or no number, more than one input or output.
    pub fn with_delay(&self, delay: f64) -> Result<Self, Error> {
        let (n, late) = (self.order(), self.delay - delay);
        if self.d.len() != 1 || delay.is_nan() || delay < 0.0 {
            let found =
                format!("{} inputs, {} outputs, a delay of {delay} s", self.b.ncols(), self.c.nrows());
            return Err(Error::new(ErrorKind::Model, found, "give a model with one input and one output")
                .expecting("one of each and a delay of 0 or more"));
        }
        if late < SHORTEST_DELAY_S {
            return Ok(self.clone());
        }
        // ẋ = −2/h x + 4/h u, v = x − u
        let pole = 2.0 / late;
        let mut a = DMatrix::zeros(n + 1, n + 1);
        a.view_mut((0, 0), (n, n)).copy_from(&self.a);
        a.view_mut((0, n), (n, 1)).copy_from(&self.b);
        a[(n, n)] = -pole;
        let b = (-&self.b).insert_row(n, 2.0 * pole);
        let c = self.c.clone().insert_column(n, self.d[0]);
        Self::new(a, b, c, -&self.d, delay)
    }

    /// The model of the samples, T = `step` s, for an input held over each step; the delay is rounded to samples.
    ///
    /// # Errors
    /// More than one input or output, or a step that is not positive and finite.
    pub fn sampled(&self, step: f64) -> Result<StateSpace, Error> {
        let n = self.order();
        if self.d.len() != 1 || !step.is_finite() || step <= 0.0 {
            let found = format!("{} inputs, {} outputs, a step of {step} s", self.b.ncols(), self.c.nrows());
            return Err(Error::new(ErrorKind::Model, found, "sample a model with one input and one output")
                .expecting("one of each and a positive step"));
        }
        let mut block = DMatrix::zeros(n + 1, n + 1);
        block.view_mut((0, 0), (n, n)).copy_from(&(&self.a * step));
        block.view_mut((0, n), (n, 1)).copy_from(&(&self.b * step));
        let whole = block.exp();
        let a = whole.view((0, 0), (n, n)).into_owned();
        let b = DVector::from_fn(n, |r, _| whole[(r, n)]);
        let delay_samples = (self.delay / step).round() as usize;
        StateSpace::new(a, b, self.c.row(0).into_owned(), self.d[0], step, delay_samples)
    }
}

/// The continuous-time model whose samples, with the input `held` or else straight between them, `model` describes.
///
/// # Errors
/// A pole at zero or on the negative real axis, which has no real logarithm; poles so close to it that the result
/// would not reproduce the model.
pub fn to_continuous(model: &StateSpace, held: bool) -> Result<ContinuousStateSpace, Error> {
    let n = model.order();
    if let Some(pole) = model.poles().iter().find(|pole| without_logarithm(pole)) {
        let kind = if pole.norm() < ZERO {
            "which is a delay of one sample"
        } else {
            "which alternates from sample to sample"
        };
        let found =
            format!("a pole at {:.4}, {kind}: there is no continuous-time model of a held input", pole.re);
        return Err(Error::new(ErrorKind::Numerical, found, "choose another order or block size")
            .expecting("poles off the negative real axis"));
    }
    // B at the size of the rest: it only rides along, and must not cost square roots
    let size = model.b().norm().max(f64::MIN_POSITIVE);
    let mut block = DMatrix::identity(n + 1, n + 1);
    block.view_mut((0, 0), (n, n)).copy_from(model.a());
    block.view_mut((0, n), (n, 1)).copy_from(&(model.b() / size));
    let inaccurate = || {
        let found = "the matrix logarithm of the model is not accurate: a pole lies too close to the negative real axis";
        Error::new(ErrorKind::Numerical, found, "choose another order or block size")
    };
    let whole = logarithm(&block).ok_or_else(inaccurate)?;
    if (whole.exp() - &block).amax() > LARGEST_ERROR * block.amax() {
        return Err(inaccurate());
    }
    let step = model.step();
    let a: DMatrix<f64> = whole.view((0, 0), (n, n)) / step;
    let mut b = whole.view((0, n), (n, 1)) * (size / step);
    let c = DMatrix::from_row_slice(1, n, model.c().transpose().as_slice());
    let mut d = DMatrix::from_element(1, 1, model.d());
    if !held {
        let [hold, ramp] = hold_and_ramp(&a, step);
        b = hold.lu().solve(&(b * step)).ok_or_else(inaccurate)?;
        d -= &c * ramp * &b;
    }
    ContinuousStateSpace::new(a, b, c, d, model.delay_samples() as f64 * step)
}

/// Ψ and R of a step.
fn hold_and_ramp(a: &DMatrix<f64>, step: f64) -> [DMatrix<f64>; 2] {
    let n = a.nrows();
    let mut block = DMatrix::zeros(3 * n, 3 * n);
    block.view_mut((0, 0), (n, n)).copy_from(&(a * step));
    for row in 0..2 * n {
        block[(row, row + n)] = 1.0;
    }
    let whole = block.exp();
    [n, 2 * n].map(|column| whole.view((0, column), (n, n)) * step)
}

/// Whether a sampled pole has no real logarithm.
fn without_logarithm(pole: &Complex<f64>) -> bool {
    pole.norm() < ZERO || (pole.re < 0.0 && pole.im.abs() <= ON_THE_AXIS * pole.norm())
}

/// log M; `None` where the square roots do not converge.
fn logarithm(m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = m.nrows();
    let identity = DMatrix::identity(n, n);
    let (mut root, mut factor) = (m.clone(), 1.0);
    for _ in 0..MOST_ROOTS {
        let x = &root - &identity;
        if x.norm() < NEAR_IDENTITY {
            return near_identity(&x).map(|log| log * factor);
        }
        root = square_root(&root)?;
        factor *= 2.0;
    }
    None
}

/// log(I + X) for small X.
fn near_identity(x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = x.nrows();
    let mut log = DMatrix::zeros(n, n);
    for [offset, weight] in GAUSS_8 {
        for node in [0.5 - 0.5 * offset, 0.5 + 0.5 * offset] {
            let denominator = DMatrix::identity(n, n) + x * node;
            log += denominator.lu().solve(x)? * (0.5 * weight);
        }
    }
    Some(log)
}

/// The square root with eigenvalues in the right half plane.
fn square_root(m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = m.nrows();
    let (mut x, mut y) = (m.clone(), DMatrix::identity(n, n));
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let next = (&x + y.clone().try_inverse()?) * 0.5;
        y = (&y + x.clone().try_inverse()?) * 0.5;
        let change = (&next - &x).norm() / next.norm();
        x = next;
        // quadratic at the end: once small, the first step that no longer shrinks is rounding
        if !change.is_finite() || change < 1e-15 || (change < 1e-8 && change >= last) {
            return change.is_finite().then_some(x);
        }
        last = change;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::RowDVector;

    #[test]
    fn first_order_closed_form() {
        let lag = ContinuousStateSpace::new(
            DMatrix::from_element(1, 1, -3.0),
            DMatrix::from_element(1, 1, 2.0),
            DMatrix::from_element(1, 1, 1.0),
            DMatrix::zeros(1, 1),
            0.06,
        )
        .unwrap();
        let sampled = lag.sampled(0.02).unwrap();
        assert!((sampled.a()[0] - (-0.06_f64).exp()).abs() < 1e-15 && sampled.delay_samples() == 3);
        assert!((sampled.b()[0] - 2.0 / 3.0 * (1.0 - (-0.06_f64).exp())).abs() < 1e-15);
        let back = to_continuous(&sampled, true).unwrap();
        assert!((back.a()[0] + 3.0).abs() < 1e-12 && (back.b()[0] - 2.0).abs() < 1e-12);
        let expected = Complex::from(2.0) / Complex::new(3.0, 5.0) * Complex::cis(-0.3);
        assert!((back.frequency_response(5.0).unwrap()[0] - expected).norm() < 1e-12);
    }

    #[test]
    fn a_defective_matrix_and_an_integrator_have_their_logarithm() {
        // double integrator: Φ = [1 T; 0 1], Γ = [T²/2; T]
        let t = 0.02;
        let a = DMatrix::from_row_slice(2, 2, &[1.0, t, 0.0, 1.0]);
        let b = DVector::from_column_slice(&[0.5 * t * t, t]);
        let model = StateSpace::new(a, b, RowDVector::from_row_slice(&[1.0, 0.0]), 0.0, t, 0).unwrap();
        let found = to_continuous(&model, true).unwrap();
        assert!((found.a() - DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0])).amax() < 1e-9);
        assert!((found.b() - DMatrix::from_column_slice(2, 1, &[0.0, 1.0])).amax() < 1e-9);
    }

    #[test]
    fn poles_without_a_logarithm_are_named() {
        for (pole, word) in [(-0.3125, "-0.3125"), (0.0, "delay of one sample")] {
            let a = DMatrix::from_row_slice(2, 2, &[0.9, 0.1, 0.0, pole]);
            let c = RowDVector::from_row_slice(&[1.0, 0.0]);
            let b = DVector::from_column_slice(&[1.0, 1.0]);
            let error = to_continuous(&StateSpace::new(a, b, c, 0.0, 0.02, 0).unwrap(), true).unwrap_err();
            assert!(error.to_string().contains(word), "{error}");
        }
    }
}
