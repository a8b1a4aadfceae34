//! Finite impulse response of the pitch rate by least squares over several sections together:
//!
//! ```text
//! q[k] = o_s + Σ_i w[i] u[k−L−i] + e[k],   i = 0..N−1
//! ŵ = (Φᵀ Φ + λ I)⁻¹ Φᵀ q
//! ```
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | w | taps | rad/s per unit of the input |
//! | L | lag of the first tap: 1 + input delay for a held input | samples |
//! | o_s | offset of section s (trim, gyro bias), eliminated by taking each section about its means | rad/s |
//! | λ | ridge, 1e-9 of the mean diagonal of Φᵀ Φ: it decides only directions that the input does not excite | |
//!
//! The window of a row may reach back within its run, before the section, for those inputs are known; it never
//! crosses the start of a run. ΦᵀΦ needs one correlation per lag: its other entries follow along the diagonals,
//! G\[i+1,j+1\] = G\[i,j\] + (product entering) − (product leaving). Cost: 8 N multiplications per sample, plus N²
//! per stretch of rows.
//!
//! Standard errors allow for coloured errors that do not depend on the input (Newey, West, 1987, with
//! 2 N lags and the regressor's correlation taken as stationary): (ΦᵀΦ)⁻¹ M (ΦᵀΦ)⁻¹,
//! M\[i,j\] = Σ_τ (1 − |τ|/2N) r_e(τ) R_u(τ+i−j). White-noise formulae are too small by a factor of several
//! where a gust moment acts.
//!
//! Source: Ljung, System Identification, 2nd ed., section 7.3.

mod stretch;

pub(super) use stretch::dot;

use crate::dataset::{Dataset, Place};
use crate::error::{Error, ErrorKind};
use crate::validate::vaf::vaf;
use core::ops::Range;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use stretch::{Correlations, Stretch, add_scaled};

/// Lags of the errors' correlation in M, in regressor lengths. With one, the window smears the slow errors' power over
/// fast directions and the standard errors come out 10 % too large.
const WINDOW: usize = 2;
/// λ against the mean diagonal of ΦᵀΦ.
const RIDGE: f64 = 1e-9;

/// A finite impulse response.
#[derive(Clone, Debug, PartialEq)]
pub struct Fir {
    /// w, rad/s per unit of the input.
    pub taps: Vec<f64>,
    /// Lag of the first tap, samples.
    pub first_lag: usize,
    /// Sample period, s.
    pub step: f64,
}

impl Fir {
    /// ŷ\[k\] = Σ w\[i\] u\[k−L−i\]; inputs before the slice count as zero.
    #[must_use]
    pub fn simulate(&self, u: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; u.len()];
        for (i, &w) in self.taps.iter().enumerate() {
            add_scaled(&mut y[(self.first_lag + i).min(u.len())..], w, u);
        }
        y
    }
}

/// A section to learn from: some rows of a run. All slices have the length of the run.
#[derive(Clone, Debug)]
pub struct Piece<'a> {
    /// Input, its unit.
    pub u: &'a [f64],
    /// Pitch rate, rad/s.
    pub y: &'a [f64],
    /// Where the supervisor overrode the excitation.
    pub supervised: &'a [bool],
    /// The rows of the section.
    pub rows: Range<usize>,
    /// Index of the run, which tells pieces of one run from those of another.
    pub run: usize,
    /// Sample period, s.
    pub step: f64,
}

/// The sections at `places`, as pieces.
///
/// # Errors
/// No pitch rate, no section, or sample periods that differ by more than 0.1 %.
pub fn pieces<'a>(data: &'a Dataset, places: &[Place]) -> Result<Vec<Piece<'a>>, Error> {
    let mut pieces = Vec::new();
    for place in places {
        let run = data.runs.get(place.run).ok_or_else(|| {
            let advice = "take the sections from this data set";
            Error::new(ErrorKind::Section, format!("section {} is of another data set", place.label), advice)
        })?;
        let y = run.rate.as_deref().ok_or_else(|| {
            let advice = "add q_rad_s; the other methods also take theta_rad";
            Error::new(ErrorKind::Column, "an impulse response needs the pitch rate", advice)
        })?;
        let (rows, supervised) = (place.rows.clone(), run.supervised.as_slice());
        pieces.push(Piece { u: &run.u, y, supervised, rows, run: place.run, step: run.step });
    }
    common_step(&pieces)?;
    Ok(pieces)
}

/// The sample period of all pieces, s.
///
/// # Errors
/// No piece, or periods that differ by more than 0.1 %.
pub(super) fn common_step(pieces: &[Piece]) -> Result<f64, Error> {
    let Some(first) = pieces.first() else {
        let advice = "name one or more sections of the recordings";
        return Err(Error::new(ErrorKind::Section, "no section to learn from", advice));
    };
    match pieces.iter().find(|p| (p.step / first.step - 1.0).abs() > 1e-3) {
        None => Ok(first.step),
        Some(other) => Err(Error::new(
            ErrorKind::Clock,
            format!("sample periods of {} s and {} s", first.step, other.step),
            "use recordings of one sample period together, the others apart",
        )),
    }
}

/// What to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirOptions {
    /// N, 1 to 1000.
    pub taps: usize,
    /// L, 0 to 1000 samples.
    pub first_lag: usize,
    /// Also use rows where the supervisor acted. Its feedback correlates u with the disturbance and biases the taps.
    pub use_supervised: bool,
}

/// A fitted impulse response.
#[derive(Clone, Debug, PartialEq)]
pub struct FirFit {
    /// The response.
    pub fir: Fir,
    /// Standard error of each tap.
    pub deviations: Vec<f64>,
    /// o_s of each piece, rad/s.
    pub offsets: Vec<f64>,
    /// Standard deviation of e, rad/s.
    pub noise: f64,
    /// Rows that were used.
    pub rows: usize,
}

/// Fits one impulse response to all `pieces`.
///
/// # Errors
/// Options out of range, fewer usable rows than twice the unknowns, an input that does not excite the taps.
pub fn fit(pieces: &[Piece], options: &FirOptions) -> Result<FirFit, Error> {
    let step = common_step(pieces)?;
    let n = options.taps;
    if !(1..=1000).contains(&n) || options.first_lag > 1000 {
        let found = format!("{n} taps from lag {}", options.first_lag);
        return Err(Error::new(ErrorKind::Options, found, "choose 30 to 100 taps from lag 1 or later")
            .expecting("1 to 1000 taps, lag 0 to 1000"));
    }
    let stretches: Vec<Stretch> = pieces.iter().map(|piece| Stretch::new(piece, options)).collect();
    let rows: usize = stretches.iter().map(Stretch::count).sum();
    let unknowns = n + pieces.len();
    if rows < 2 * unknowns {
        let found = format!("{rows} rows whose whole window of {} inputs is known", n + options.first_lag);
        return Err(Error::new(ErrorKind::TooShort, found, "give longer sections or fewer taps")
            .expecting(format!("at least {} for {n} taps", 2 * unknowns)));
    }
    let mut gram = DMatrix::zeros(n, n);
    let mut cross = DVector::zeros(n);
    for stretch in &stretches {
        stretch.add_normal_equations(&mut gram, &mut cross);
    }
    if !cross.iter().all(|x| x.is_finite()) {
        let advice = "remove the rows with values that are no finite numbers";
        return Err(Error::new(ErrorKind::Value, "an input or pitch rate that is not finite", advice));
    }
    let factor = factorise(gram)?;
    let taps = factor.solve(&cross);
    let mut left = Correlations::new(n);
    for stretch in &stretches {
        left.add(stretch, &taps);
    }
    let free = (rows - unknowns) as f64;
    let noise = (left.error[0] / free).sqrt();
    let deviations = left.deviations(&factor, rows as f64 / free);
    let offsets = stretches.iter().map(|stretch| stretch.offset(&taps)).collect();
    let fir = Fir { taps: taps.as_slice().to_vec(), first_lag: options.first_lag, step };
    Ok(FirFit { fir, deviations, offsets, noise, rows })
}

/// VAF in per cent of an impulse response fitted to the very section that it is judged by: what no linear model of
/// that length driven by `u` can surpass, and optimistic, for N unknowns are fitted to the noise too. First lag 1; the
/// first N rows only fill the window.
///
/// # Errors
/// As [`fit`].
pub fn ceiling_vaf(u: &[f64], y: &[f64], taps: usize) -> Result<f64, Error> {
    let length = u.len().min(y.len());
    let (u, y) = (&u[..length], &y[..length]);
    let supervised = vec![false; length];
    let piece = Piece { u, y, supervised: &supervised, rows: 0..length, run: 0, step: 1.0 };
    let fitted = fit(&[piece], &FirOptions { taps, first_lag: 1, use_supervised: true })?;
    Ok(vaf(&y[taps..], &fitted.fir.simulate(u)[taps..]))
}

fn factorise(mut gram: DMatrix<f64>) -> Result<Cholesky<f64, Dyn>, Error> {
    let n = gram.nrows();
    let mean = gram.trace() / n as f64;
    let silent = || {
        let found = format!("the input does not excite {n} taps");
        Error::new(ErrorKind::Numerical, found, "use sections in which the input moves, or fewer taps")
    };
    if !mean.is_finite() || mean <= f64::MIN_POSITIVE {
        return Err(silent());
    }
    for i in 0..n {
        gram[(i, i)] += RIDGE * mean;
    }
    Cholesky::new(gram).ok_or_else(silent)
}
