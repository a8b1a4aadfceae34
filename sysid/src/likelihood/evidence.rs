//! What the data say of a fitted model: information, scores by block, and the evidence for its terms.
//!
//! In the coordinates z of the search, with the derivatives J_k = ∂e_k/∂z of the innovations and W = S⁻¹:
//!
//! ```text
//! s_k = J_kᵀ W e_k          H = Σ J_kᵀ W J_k (+ prior)          C = H⁻¹
//! s_b = Σ_{k in block b} s_k         V = C (Σ_b s_b s_bᵀ) C
//! ```
//!
//! With Gaussian errors that the model has, V = C. On real data a likelihood ratio for the terms ψ overstates, and is
//! divided by
//!
//! ```text
//! κ_ψ = max(1, tr(C_ψψ⁻¹ V_ψψ) / p)
//! ```
//!
//! (Kent, Biometrika 69, 1982; Chandler and Bate, Biometrika 94, 2007). The evidence of a model with the parameters ψ
//! of its terms is Laplace's, with priors that are even over the ranges of the catalogue (in z):
//!
//! ```text
//! ln E = −V(ẑ)/κ + ½ ln det(2π κ C_ψψ) − Σ ln(range of ψ_i)
//! ```

use super::fit::{Fit, weights};
use super::problem::Problem;
use crate::dataset::Place;
use crate::optim::chord::Chord;
use crate::optim::levenberg_marquardt::{Coordinate, inner, weigh};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix2};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Length of the blocks whose scores count as independent, s: several times the memory of a vehicle in the loop.
pub const BLOCK_S: f64 = 3.0;
/// Probability with which blocks that are what the model takes them for give no divisor above one.
const NO_DIVISOR: f64 = 0.9;
/// A linear parameter's prior is at most so many steps of its search wide (a shape's coefficient: ± one usual moment).
const WIDEST_PRIOR: f64 = 100.0;

/// Of an unknown that is bounded by zero: less is none, in its own unit.
const NONE: f64 = 1e-6;

/// Information and scores at a fit.
#[derive(Clone, Debug)]
pub struct Information {
    /// Unknowns that may move, by their place.
    free: Vec<usize>,
    /// Parameters of effects that are no unknowns.
    beyond: Vec<usize>,
    /// Parameters of effects whose zero is none of the effect's.
    anywhere: Vec<usize>,
    /// Of the free unknowns.
    hessian: DMatrix<f64>,
    covariance: DMatrix<f64>,
    /// V.
    by_blocks: DMatrix<f64>,
    blocks: usize,
    /// Those that stand at a bound which is zero, and their standard deviation, the free ones following.
    at_zero: Vec<(usize, f64)>,
    /// What each part of the data contributes.
    parts: Vec<Part>,
    coordinates: Vec<Coordinate>,
}

/// What the rows of one part contribute to H and to Σ s.
#[derive(Clone, Debug)]
struct Part {
    hessian: DMatrix<f64>,
    score: DVector<f64>,
}

/// Where an error belongs.
struct Row {
    /// Run, and block of it.
    block: (usize, usize),
    /// The part of the data.
    part: Option<usize>,
}

impl Information {
    /// At the minimum of `fit`; `parts` are the parts of the data that can be left out by [`Self::without`]. `None`
    /// where the fit has no finite derivatives, or they are not independent.
    pub fn new(problem: &Problem<'_>, fit: &Fit, parts: &[Vec<Place>]) -> Option<Self> {
        Self::with(problem, fit, problem.coordinates(&fit.effects), parts)
    }

    /// The same with `coordinates` of its own, whose priors are others.
    pub fn with(
        problem: &Problem<'_>,
        fit: &Fit,
        coordinates: Vec<Coordinate>,
        parts: &[Vec<Place>],
    ) -> Option<Self> {
        let values = &fit.minimum.values;
        let residuals = problem.prediction_errors(&fit.effects);
        let slopes = Chord::new(&residuals, problem.channels(), &coordinates, values)?.into_jacobian();
        let rows = problem.counted_rows().map(|(run, k)| {
            let holds = |places: &Vec<Place>| places.iter().any(|p| p.run == run && p.rows.contains(&k));
            let block = (k as f64 * problem.data.runs[run].step / BLOCK_S) as usize;
            Row { block: (run, block), part: parts.iter().position(holds) }
        });
        let information =
            Self::of_rows(coordinates, values, &slopes, &fit.minimum.residuals, rows, parts.len())?;
        let effects = fit.effects.iter().enumerate().map(|(i, effect)| (fit.own_range(problem, i), effect));
        let beyond = effects.clone().filter_map(|(own, effect)| {
            Some(own.start + effect.beyond_data(&values[own.clone()], &problem.sizes)?)
        });
        let anywhere = effects.filter_map(|(own, effect)| Some(own.start + effect.acts_at()?));
        Some(Self { beyond: beyond.collect(), anywhere: anywhere.collect(), ..information })
    }

    /// From the derivatives of the errors, coordinate by coordinate; `rows` says where each error belongs.
    fn of_rows(
        coordinates: Vec<Coordinate>,
        values: &[f64],
        slopes: &[Vec<[f64; 2]>],
        errors: &[[f64; 2]],
        rows: impl Iterator<Item = Row>,
        parts: usize,
    ) -> Option<Self> {
        let (weight, _) = weights(errors);
        let moves = |i: &usize| {
            let bounds = coordinates[*i].bounds;
            let hair = 1e-6 * (bounds[1] - bounds[0]);
            values[*i] > bounds[0] + hair
                && values[*i] < bounds[1] - hair
                && slopes[*i].iter().any(|e| e[0] != 0.0 || e[1] != 0.0)
        };
        let free: Vec<usize> = (0..slopes.len()).filter(moves).collect();
        let n = free.len();
        let zero = || Part { hessian: DMatrix::zeros(n, n), score: DVector::zeros(n) };
        let mut whole = zero();
        let mut of_parts: Vec<Part> = (0..parts).map(|_| zero()).collect();
        let (mut by_blocks, mut block, mut blocks) = (DMatrix::zeros(n, n), DVector::zeros(n), 0);
        let mut current = None;
        let (mut row_hessian, mut row_score) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (index, Row { block: this, part }) in rows.enumerate() {
            if Some(this) != current {
                if current.is_some() {
                    by_blocks.ger(1.0, &block, &block, 1.0);
                    blocks += 1;
                }
                block.fill(0.0);
                current = Some(this);
            }
            row(slopes, &free, index, &weight, &errors[index], &mut row_hessian, &mut row_score);
            whole.hessian += &row_hessian;
            whole.score += &row_score;
            block += &row_score;
            if let Some(part) = part {
                of_parts[part].hessian += &row_hessian;
                of_parts[part].score += &row_score;
            }
        }
        by_blocks.ger(1.0, &block, &block, 1.0);
        blocks += 1;
        for (a, &i) in free.iter().enumerate() {
            if let Some((_, deviation)) = coordinates[i].prior {
                whole.hessian[(a, a)] += 1.0 / (deviation * deviation);
            }
        }
        let covariance = factor(&whole.hessian)?.inverse();
        // with the curvature that a step away from the bound shows
        let is_none = |i: &usize| {
            let bounds = coordinates[*i].bounds;
            bounds[0] != bounds[1] && bounds.contains(&0.0) && values[*i].abs() < NONE
        };
        let at_zero = (0..slopes.len()).filter(|i| !moves(i) && is_none(i)).filter_map(|i| {
            let product = |j: usize| -> f64 {
                let pairs = slopes[i].iter().zip(&slopes[j]);
                pairs.map(|(a, b)| inner(a, &weigh(&weight, b))).sum()
            };
            let across = DVector::from_fn(n, |a, _| product(free[a]));
            let left = product(i) - across.dot(&(&covariance * &across));
            (left > 0.0).then(|| (i, left.sqrt().recip()))
        });
        let at_zero: Vec<(usize, f64)> = at_zero.collect();
        let by_blocks = &covariance * by_blocks * &covariance;
        Some(Self {
            free,
            beyond: Vec::new(),
            anywhere: Vec::new(),
            hessian: whole.hessian,
            covariance,
            by_blocks,
            blocks,
            at_zero,
            parts: of_parts,
            coordinates,
        })
    }

    /// Whether the unknown at `place` moves: it stands at no bound, and the innovations depend on it.
    pub fn moves(&self, place: usize) -> bool {
        self.free.contains(&place)
    }

    /// Places of `own` among the free unknowns; `None` where one of them does not move.
    fn places(&self, own: impl Iterator<Item = usize>) -> Option<Vec<usize>> {
        let unknown = own.filter(|i| !self.beyond.contains(i));
        unknown.map(|i| self.free.iter().position(|&j| j == i)).collect()
    }

    /// κ of the unknowns `own`: one where the blocks' scores are no more uneven than chance makes them.
    pub fn divisor(&self, own: impl Iterator<Item = usize>) -> f64 {
        let Some(places) = self.places(own).filter(|places| !places.is_empty()) else { return 1.0 };
        let p = places.len();
        let cut = |m: &DMatrix<f64>| DMatrix::from_fn(p, p, |a, b| m[(places[a], places[b])]);
        let Some(solver) = factor(&cut(&self.covariance)) else { return 1.0 };
        let mean = solver.solve(&cut(&self.by_blocks)).trace() / p as f64;
        let freedom = (self.blocks * p) as f64;
        let chance = ChiSquared::new(freedom).map_or(1.0, |chi| chi.inverse_cdf(NO_DIVISOR) / freedom);
        (mean / chance).max(1.0)
    }

    /// ½ ln det(2π κ C_ψψ) − Σ ln(range of ψ_i) for the unknowns `own`, which is no more than 0: what the data have left of
    /// the prior. `None` where one of them stands at a bound: no candidate.
    pub fn occam(&self, own: impl Iterator<Item = usize>, divisor: f64) -> Option<f64> {
        let places = self.places(own)?;
        let p = places.len();
        let part = DMatrix::from_fn(p, p, |a, b| self.covariance[(places[a], places[b])]);
        let log_determinant = 2.0 * factor(&part)?.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        let ranges = places.iter().map(|&a| width(&self.coordinates[self.free[a]]).ln()).sum::<f64>();
        let posterior = 0.5 * (p as f64 * (std::f64::consts::TAU * divisor).ln() + log_determinant);
        Some((posterior - ranges).min(0.0))
    }

    /// Standard deviation of the unknown at `place` where it stands at a bound which is zero, as a damping that is none, in its own
    /// unit: what the curvature there gives, by as much more as the blocks' scores of the others are more uneven than chance makes
    /// them. `None` where it does not stand at one, or nothing depends on it.
    pub fn deviation_at_zero(&self, place: usize, values: &[f64]) -> Option<f64> {
        let (_, deviation) = self.at_zero.iter().find(|(i, _)| *i == place)?;
        let uneven = self.divisor(self.free.iter().copied()).sqrt();
        Some(deviation * uneven * self.coordinates[place].stretch(values[place]))
    }

    /// Standard deviation of every unknown in its own unit: the larger of that of the information and of the blocks;
    /// infinite where the unknown does not move.
    pub fn deviations(&self, values: &[f64]) -> Vec<f64> {
        let mut all = vec![f64::INFINITY; values.len()];
        for (a, &i) in self.free.iter().enumerate() {
            let variance = self.covariance[(a, a)].max(self.by_blocks[(a, a)]);
            all[i] = variance.max(0.0).sqrt() * self.coordinates[i].stretch(values[i]);
        }
        all
    }

    /// Standard deviation of a function of the unknowns with this `gradient`: the larger of that of the information and of
    /// the blocks, unknowns that do not move held; infinite where it depends on none that moves.
    pub fn deviation_along(&self, values: &[f64], gradient: &[f64]) -> f64 {
        let own = |(a, &i): (usize, &usize)| (a, gradient[i] * self.coordinates[i].stretch(values[i]));
        let own: Vec<(usize, f64)> =
            self.free.iter().enumerate().map(own).filter(|(_, g)| *g != 0.0).collect();
        if own.is_empty() {
            return f64::INFINITY;
        }
        let along = |matrix: &DMatrix<f64>| {
            let pairs = own.iter().flat_map(|(a, g)| own.iter().map(move |(b, h)| g * h * matrix[(*a, *b)]));
            pairs.sum::<f64>()
        };
        along(&self.covariance).max(along(&self.by_blocks)).max(0.0).sqrt()
    }

    /// How all unknowns move, in the coordinates of the search, when those of `own` that move are drawn from what the data leave of
    /// them and the others follow: for ξ ~ N(0, I) by R ξ, with R = C_·ν L⁻ᵀ and C_νν = L Lᵀ. A row for each unknown.
    pub fn spread(&self, own: impl Iterator<Item = usize>) -> Option<DMatrix<f64>> {
        let places: Vec<usize> = own.filter_map(|i| self.free.iter().position(|&j| j == i)).collect();
        let p = places.len();
        let root = factor(&DMatrix::from_fn(p, p, |a, b| self.covariance[(places[a], places[b])]))?;
        let across = DMatrix::from_fn(p, self.free.len(), |a, b| self.covariance[(places[a], b)]);
        let of_free = root.l().solve_lower_triangular(&across)?;
        let mut all = DMatrix::zeros(self.coordinates.len(), p);
        for (b, &i) in self.free.iter().enumerate() {
            all.row_mut(i).copy_from(&of_free.column(b).transpose());
        }
        Some(all)
    }

    /// Whether one of the unknowns `own` that may have either sign has a 95 % interval that holds zero: then it is no term.
    pub fn holds_zero(&self, mut own: impl Iterator<Item = usize>, values: &[f64]) -> bool {
        let deviations = self.deviations(values);
        own.any(|i| {
            let [low, high] = self.coordinates[i].bounds;
            low < 0.0 && high > 0.0 && !self.anywhere.contains(&i) && values[i].abs() < 1.96 * deviations[i]
        })
    }

    /// The unknowns `own` as part `part` of the data has them, each with its standard deviation: one Gauss–Newton step of theirs
    /// alone from `values`, all else held. `None` where one of them does not move there.
    pub fn alone(
        &self,
        part: usize,
        own: impl Iterator<Item = usize> + Clone,
        values: &[f64],
    ) -> Option<Vec<(f64, f64)>> {
        let places =
            own.clone().map(|i| self.free.iter().position(|&j| j == i)).collect::<Option<Vec<usize>>>()?;
        let Part { hessian, score } = self.parts.get(part)?;
        let n = places.len();
        let solver = factor(&DMatrix::from_fn(n, n, |a, b| hessian[(places[a], places[b])]))?;
        let step = solver.solve(&DVector::from_fn(n, |a, _| score[places[a]]));
        let covariance = solver.inverse() * self.divisor(own.clone());
        let told = own.enumerate().map(|(a, i)| {
            let coordinate = &self.coordinates[i];
            let value = coordinate.outer(coordinate.inner(values[i]) - step[a].clamp(-3.0, 3.0));
            (value, covariance[(a, a)].sqrt() * coordinate.stretch(value))
        });
        Some(told.collect())
    }

    /// The unknowns fitted without part `part` of the data: one Gauss–Newton step from `values`, those that are `held` left
    /// where they are.
    pub fn without(&self, part: usize, values: &[f64], held: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut moved = values.to_vec();
        let Part { hessian, score } = &self.parts[part];
        let moving: Vec<usize> = (0..self.free.len()).filter(|&a| !held(self.free[a])).collect();
        let n = moving.len();
        let entry =
            |a: usize, b: usize| self.hessian[(moving[a], moving[b])] - hessian[(moving[a], moving[b])];
        let mut rest = DMatrix::from_fn(n, n, entry);
        for i in 0..n {
            rest[(i, i)] = rest[(i, i)] * (1.0 + 1e-9) + 1e-9;
        }
        let Some(solver) = factor(&rest) else { return moved };
        let step = solver.solve(&DVector::from_fn(n, |a, _| score[moving[a]]));
        for (step, &a) in step.iter().zip(&moving) {
            let i = self.free[a];
            let coordinate = &self.coordinates[i];
            // no unknown jumps further than in the search
            moved[i] = coordinate.outer(coordinate.inner(values[i]) + step.clamp(-3.0, 3.0));
        }
        moved
    }
}

fn factor(matrix: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    matrix.clone().cholesky().filter(|c| c.l_dirty().iter().all(|x| x.is_finite()))
}

/// Width of a parameter's prior, in the coordinate of the search.
pub fn width(coordinate: &Coordinate) -> f64 {
    let [low, high] = coordinate.bounds;
    let width = coordinate.inner(high) - coordinate.inner(low);
    if coordinate.log { width } else { width.min(WIDEST_PRIOR) }
}

/// J_kᵀ W J_k and J_kᵀ W e_k of one row.
fn row(
    slopes: &[Vec<[f64; 2]>],
    free: &[usize],
    index: usize,
    weight: &Matrix2<f64>,
    error: &[f64; 2],
    hessian: &mut DMatrix<f64>,
    score: &mut DVector<f64>,
) {
    let weighted_error = weigh(weight, error);
    for (a, &i) in free.iter().enumerate() {
        let slope = &slopes[i][index];
        let weighted = weigh(weight, slope);
        score[a] = inner(slope, &weighted_error);
        for (b, &j) in free.iter().enumerate().take(a + 1) {
            let entry = inner(&weighted, &slopes[j][index]);
            hessian[(a, b)] = entry;
            hessian[(b, a)] = entry;
        }
    }
}

#[cfg(test)]
mod tests;
