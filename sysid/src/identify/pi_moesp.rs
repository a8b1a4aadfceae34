//! Subspace identification with past inputs as instruments (PI-MOESP), and with past outputs beside them (PO-MOESP).
//!
//! ```text
//! [U_f; W; Y_f] = L Qᵀ                       LQ factors, L lower triangular; W = U_p, or [U_p; Y_p]
//! L_Y,W = U Σ Vᵀ                             the part of Y_f that the instruments explain beyond U_f
//! C = first row of U_n,   A = U_n↑⁺ U_n↓     U_n: first n columns;  ↑, ↓: without the last, first row
//! B, D, x0: least squares on the free run    (`input_fit`)
//! ```
//!
//! | symbol | meaning | range |
//! | --- | --- | --- |
//! | n | order | 1 to 5 |
//! | i | block size: rows of past and of future | n + 1 to 200 |
//! | d | input delay | samples |
//!
//! L comes from the Gram matrix by Cholesky's method, which squares the condition number. A factor whose smallest
//! pivot keeps less than 1e-10 of its diagonal is replaced by the triangular factor of the Hankel matrix itself.
//!
//! U_n has orthonormal columns, so U_n↑ᵀU_n↑ = I − l lᵀ with l its last row, and A of every lower order is a corner of
//! U↑ᵀU↓ times (I + l lᵀ / (1 − lᵀl)).
//!
//! Source: Verhaegen, Subspace model identification part 3, Int. J. Control 58, 1993 (PI-MOESP); Verhaegen,
//! Identification of the deterministic part of MIMO state space models, Automatica 30, 1994 (PO-MOESP).

use super::block_hankel::{Correlations, Instruments, Stretch, columns, stretches, transposed};
use super::fir::{Piece, common_step};
use super::input_fit::{HIGHEST_ORDER, free_run_squares, input_matrices};
use crate::error::{Error, ErrorKind};
use crate::linalg::{cholesky, leading_left_singular, solve_lower, upper_factor};
use crate::model::state_space::StateSpace;
use core::ops::RangeInclusive;
use nalgebra::{DMatrix, DVector};

/// Largest block size.
pub const LARGEST_BLOCK: usize = 200;
/// Least share of its diagonal that a pivot of the Gram matrix must keep; below, rounding takes its sixth digit.
const SHAKY: f64 = 1e-10;
/// Least share of its column that a diagonal entry of the triangular factor must keep for the input to count as exciting.
const SILENT: f64 = 1e-11;
/// Singular values below this share of the first are rounding.
const ROUNDING: f64 = 1e-13;
/// Models within this many points of VAF of the best count as equally good.
const AS_GOOD: f64 = 0.5;

/// How to identify, apart from order and block size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// PI-MOESP or PO-MOESP.
    pub instruments: Instruments,
    /// d, samples.
    pub delay_samples: usize,
    /// Whether u\[k−d\] acts on y\[k\] (D): with a held input it does where the delay is shorter than d samples by a
    /// fraction of one.
    pub direct: bool,
    /// Whether each stretch has an unknown offset (trim, gyro bias).
    pub offset: bool,
    /// Whether the input is held between samples, or straight.
    pub held_input: bool,
    /// Also use rows where the supervisor acted. Its feedback correlates u with the disturbance and biases the model.
    pub use_supervised: bool,
}

impl Default for Method {
    /// PI-MOESP, a delay of three samples (0.06 s) or a little less, offsets, a held input, without supervised rows.
    fn default() -> Self {
        let instruments = Instruments::PastInputs;
        Self {
            instruments,
            delay_samples: 3,
            direct: true,
            offset: true,
            held_input: true,
            use_supervised: false,
        }
    }
}

impl Method {
    fn stretches(&self, pieces: &[Piece], block_size: usize) -> Result<Vec<Stretch>, Error> {
        stretches(pieces, self.delay_samples, self.use_supervised, self.offset, 2 * block_size)
    }
}

/// An identified model.
#[derive(Clone, Debug, PartialEq)]
pub struct SubspaceModel {
    /// The model; it may be unstable.
    pub model: StateSpace,
    /// Singular values of L_Y,W, falling: the order shows as a gap.
    pub singular_values: Vec<f64>,
    /// Columns of the Hankel matrices.
    pub columns: usize,
}

/// Identifies one model of order n = `order` with block size i = `block_size` from `pieces`.
///
/// # Errors
/// Options out of range, pieces too short for the block size, an input that does not excite it, an order beyond what
/// the data show, an unstable model whose free run overflows.
pub fn identify(
    pieces: &[Piece],
    order: usize,
    block_size: usize,
    method: &Method,
) -> Result<SubspaceModel, Error> {
    let step = common_step(pieces)?;
    check_ranges(&(order..=order), &(block_size..=block_size))?;
    let stretches = method.stretches(pieces, block_size)?;
    let correlations = Correlations::new(&stretches, block_size, method.instruments, method.offset);
    let subspace = Subspace::of(&stretches, &correlations, block_size, method)?;
    let model = subspace.model(order, &stretches, step, method)?;
    Ok(SubspaceModel { model, singular_values: subspace.values, columns: columns(&stretches, block_size) })
}

/// One cell of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// n.
    pub order: usize,
    /// i.
    pub block_size: usize,
    /// Largest magnitude of the poles; `None` where there is no model (see `obstacle`).
    pub spectral_radius: Option<f64>,
    /// Free-run VAF on the validation data, per cent; stable models only.
    pub vaf: Option<f64>,
    /// The model; stable ones only.
    pub model: Option<StateSpace>,
    /// Why there is no model.
    pub obstacle: Option<String>,
}

/// All candidates, and the choice among them.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Order by order, and by block size within.
    pub candidates: Vec<Candidate>,
    /// Index of the stable candidate with the largest VAF.
    pub best: usize,
    /// What was chosen, and how flat the choice was: two sentences for people.
    pub reason: String,
}

impl Grid {
    /// The chosen model, with n, i and its VAF in per cent.
    #[must_use]
    pub fn chosen(&self) -> Option<(&StateSpace, usize, usize, f64)> {
        let best = self.candidates.get(self.best)?;
        Some((best.model.as_ref()?, best.order, best.block_size, best.vaf?))
    }
}

/// Identifies from `pieces` with every order and block size, and scores each stable model by its free run from rest
/// over each of `validation`, all together.
///
/// # Errors
/// Options out of range, no stable model; a cell without a model only says so in the table.
pub fn search(
    pieces: &[Piece],
    validation: &[Piece],
    orders: RangeInclusive<usize>,
    block_sizes: RangeInclusive<usize>,
    method: &Method,
) -> Result<Grid, Error> {
    let step = common_step(pieces)?;
    common_step(&[pieces, validation].concat())?;
    check_ranges(&orders, &block_sizes)?;
    check_validation(validation)?;
    let stretches = method.stretches(pieces, *block_sizes.start())?;
    let correlations = Correlations::new(&stretches, *block_sizes.end(), method.instruments, method.offset);
    let mut candidates = Vec::new();
    for i in block_sizes {
        let subspace = Subspace::of(&stretches, &correlations, i, method);
        for order in orders.clone().take_while(|n| *n < i) {
            let model = match &subspace {
                Ok(subspace) => subspace.model(order, &stretches, step, method),
                Err(error) => Err(error.clone()),
            };
            candidates.push(Candidate::scored(order, i, model, validation));
        }
    }
    candidates.sort_by_key(|candidate| (candidate.order, candidate.block_size));
    choose(candidates)
}

impl Candidate {
    fn scored(
        order: usize,
        block_size: usize,
        model: Result<StateSpace, Error>,
        validation: &[Piece],
    ) -> Self {
        let empty = Self { order, block_size, spectral_radius: None, vaf: None, model: None, obstacle: None };
        match model {
            Err(error) => Self { obstacle: Some(error.found.into()), ..empty },
            Ok(model) => {
                let spectral_radius = Some(model.spectral_radius());
                if !model.is_stable() {
                    return Self { spectral_radius, ..empty };
                }
                let vaf = Some(free_run_vaf(&model, validation));
                Self { spectral_radius, vaf, model: Some(model), ..empty }
            }
        }
    }
}

/// VAF over several sections together: 100·max(0, 1 − Σ‖e_s‖²/Σ‖y_s‖²), each about its mean.
fn free_run_vaf(model: &StateSpace, sections: &[Piece]) -> f64 {
    let [total, left] = sections.iter().fold([0.0; 2], |[total, left], piece| {
        let squares = free_run_squares(model, &piece.u[piece.rows.clone()], &piece.y[piece.rows.clone()]);
        [total + squares[0], left + squares[1]]
    });
    if total > 0.0 && left.is_finite() { 100.0 * (1.0 - left / total).max(0.0) } else { 0.0 }
}

fn choose(candidates: Vec<Candidate>) -> Result<Grid, Error> {
    let score = |candidate: &Candidate| candidate.vaf.unwrap_or(f64::NEG_INFINITY);
    let stable = candidates.iter().filter(|candidate| candidate.vaf.is_some()).count();
    // the first of equals: the lowest order
    let best = (0..candidates.len())
        .fold(0, |best, k| if score(&candidates[k]) > score(&candidates[best]) { k } else { best });
    let Some(chosen) = candidates.get(best).filter(|_| stable > 0) else {
        let obstacle = candidates.iter().find_map(|candidate| candidate.obstacle.clone());
        let found = format!(
            "none of {} models is stable{}",
            candidates.len(),
            obstacle.map_or_else(String::new, |o| format!(": {o}"))
        );
        let advice = "give longer sections in which the input moves, or smaller block sizes";
        return Err(Error::new(ErrorKind::Numerical, found, advice));
    };
    let (order, block, vaf) = (chosen.order, chosen.block_size, score(chosen));
    let equals: Vec<&Candidate> = candidates.iter().filter(|c| score(c) >= vaf - AS_GOOD).collect();
    let lowest = equals.first().map_or(order, |c| c.order);
    let reason = format!(
        "n = {order}, i = {block} has the largest validation VAF, {vaf:.2} %, of {stable} stable models; {} of {} are \
         unstable or have no model. Within {AS_GOOD} points of it, itself included: {} of the stable ones, down to \
         n = {lowest}; the choice is {}.",
        candidates.len() - stable,
        candidates.len(),
        equals.len(),
        if 4 * equals.len() > stable { "flat" } else { "clear" },
    );
    Ok(Grid { candidates, best, reason })
}

fn check_ranges(orders: &RangeInclusive<usize>, block_sizes: &RangeInclusive<usize>) -> Result<(), Error> {
    let (n, i) = ([*orders.start(), *orders.end()], [*block_sizes.start(), *block_sizes.end()]);
    if n[0] >= 1
        && n[0] <= n[1]
        && n[1] <= HIGHEST_ORDER
        && i[0] > n[0]
        && i[0] <= i[1]
        && i[1] <= LARGEST_BLOCK
    {
        return Ok(());
    }
    let found = format!("orders {} to {} with block sizes {} to {}", n[0], n[1], i[0], i[1]);
    Err(Error::new(ErrorKind::Options, found, "choose orders 1 to 5 and block sizes 10 to 50").expecting(
        format!("orders 1 to {HIGHEST_ORDER}, block sizes above the order and up to {LARGEST_BLOCK}"),
    ))
}

fn check_validation(validation: &[Piece]) -> Result<(), Error> {
    let unusable = |what: &str| {
        Err(Error::new(
            ErrorKind::Section,
            what,
            "name a section that was not learnt from, in which the vehicle moves",
        ))
    };
    if validation.is_empty() {
        return unusable("no section to validate on");
    }
    for piece in validation {
        let rows = piece.u.get(piece.rows.clone()).zip(piece.y.get(piece.rows.clone()));
        match rows {
            Some((u, y)) if u.iter().chain(y).all(|x| x.is_finite()) => {}
            Some(_) => return unusable("a validation section with values that are not finite"),
            None => return unusable("a validation section that ends after its run"),
        }
    }
    Ok(())
}

/// The column space of L_Y,W for one block size.
struct Subspace {
    /// First columns of U, up to the highest order.
    vectors: DMatrix<f64>,
    values: Vec<f64>,
    /// U↑ᵀ U↓.
    shifted: DMatrix<f64>,
}

impl Subspace {
    fn of(stretches: &[Stretch], shared: &Correlations, i: usize, method: &Method) -> Result<Self, Error> {
        let width = if method.instruments == Instruments::PastInputs { 3 * i } else { 4 * i };
        let count = columns(stretches, i);
        if count < width {
            let found = format!("{count} windows of {} samples without a joint", 2 * i);
            return Err(Error::new(
                ErrorKind::TooShort,
                found,
                "give longer sections, or a smaller block size",
            )
            .expecting(format!("at least {width} for block size {i}")));
        }
        let explained = match by_gram(shared, i) {
            Some(explained) => explained,
            None => by_hankel(stretches, i, method)?,
        };
        let kept = HIGHEST_ORDER.min(i - 1);
        let (vectors, values) = leading_left_singular(&explained, kept).ok_or_else(|| overflow(i))?;
        let shifted = vectors.rows(0, i - 1).tr_mul(&vectors.rows(1, i - 1));
        Ok(Self { vectors, values, shifted })
    }

    fn model(
        &self,
        n: usize,
        stretches: &[Stretch],
        step: f64,
        method: &Method,
    ) -> Result<StateSpace, Error> {
        let last = self.vectors.row(self.vectors.nrows() - 1).columns(0, n).transpose();
        let left = 1.0 - last.norm_squared();
        if n > self.values.len() || self.values[n - 1] <= ROUNDING * self.values[0] || left <= ROUNDING {
            let found = format!("order {n} exceeds what the data show");
            return Err(Error::new(ErrorKind::Numerical, found, "choose a lower order"));
        }
        let corner = self.shifted.view((0, 0), (n, n));
        let a = corner + &last * (last.tr_mul(&corner) / left);
        let c = self.vectors.row(0).columns(0, n).into_owned();
        let (b, d): (DVector<f64>, f64) = input_matrices(&a, &c, method.direct, method.offset, stretches)?;
        StateSpace::new(a, b, c, d, step, method.delay_samples)
    }
}

fn overflow(i: usize) -> Error {
    let found = format!("the factors for block size {i} are no finite numbers");
    Error::new(ErrorKind::Numerical, found, "check the units of the columns")
}

/// L_Y,W from the Gram matrix; `None` where the input part is too close to singular.
fn by_gram(shared: &Correlations, i: usize) -> Option<DMatrix<f64>> {
    let (own, mut cross) = shared.gram(i);
    let whole = own.diagonal();
    let factor = cholesky(own)?;
    let safe = factor.diagonal().iter().zip(&whole).all(|(pivot, whole)| pivot * pivot > SHAKY * whole);
    solve_lower(&factor, &mut cross);
    safe.then(|| cross.rows(i, cross.nrows() - i).transpose())
}

/// L_Y,W from the Hankel matrix itself.
fn by_hankel(stretches: &[Stretch], i: usize, method: &Method) -> Result<DMatrix<f64>, Error> {
    let factor = upper_factor(transposed(stretches, i, method.instruments, method.offset))
        .ok_or_else(|| overflow(i))?;
    let inputs = (0..2 * i).all(|k| factor[(k, k)].abs() > SILENT * factor.column(k).norm());
    if !inputs {
        let found = format!("the input does not excite block size {i}");
        let advice = "use sections in which the input switches often, or a smaller block size";
        return Err(Error::new(ErrorKind::Numerical, found, advice));
    }
    let width = factor.ncols() - i;
    Ok(factor.view((i, width), (width - i, i)).transpose())
}
