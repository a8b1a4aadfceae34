//! min over p of max_k f_k(p) within bounds, for few unknowns and many f_k that lie along a curve.
//!
//! ```text
//! h = argmin  max_j (f_j + g_jᵀ h) + ½ hᵀ W⁻¹ h,   low ≤ p + h ≤ high,   j over the peaks of k ↦ f_k and their neighbours
//! p ← p + α h,  α = 1, ½, ¼, … until max_k f_k falls enough
//! W ← inverse of the updated Hessian, with s = α h, y = Σ_j λ_j (g_j(p+s) − g_j(p))
//! ```
//!
//! The quadratic programme is solved in its multipliers (λ on the simplex, one more for each bound) by an active set.
//!
//! Source: Han, Variable metric methods for minimizing a class of nondifferentiable functions, Mathematical Programming
//! 20, 1981; Powell's damping of the update, in Numerical Analysis Dundee 1977, Lecture Notes in Mathematics 630.

use nalgebra::{DMatrix, DVector};

/// Iterations at most.
const MOST_ITERATIONS: usize = 100;
/// Expected relative fall at which the search ends.
const SMALLEST_FALL: f64 = 1e-8;
/// Share of the expected fall that a step must bring.
const ENOUGH: f64 = 1e-4;
/// Peaks below this share of the largest take no part.
const FLOOR: f64 = 0.3;
/// Neighbours below this share of the largest take no part.
const NEAR: f64 = 0.9;
/// Length of the first step.
const FIRST_STEP: f64 = 0.25;
/// Least slope of an unknown, against the largest of all, that counts in the first step.
const SMALLEST_SLOPE: f64 = 1e-6;
/// Halvings of a step at most.
const MOST_HALVINGS: i32 = 30;
/// Constraints added at most in one quadratic programme.
const MOST_CHANGES: usize = 40;
/// Violation, against the largest f_k, at which a quadratic programme is solved.
const SETTLED: f64 = 1e-12;
/// Ridge of the dual, against its largest entry.
const RIDGE: f64 = 1e-12;

/// What is minimised.
pub struct Curve<'a> {
    /// All f_k(p), not negative, in an order in which neighbours are alike.
    pub values: &'a dyn Fn(&[f64]) -> Vec<f64>,
    /// g_k(p).
    pub gradient: &'a dyn Fn(&[f64], usize) -> Vec<f64>,
    /// Bounds of each unknown.
    pub bounds: &'a [[f64; 2]],
}

/// The smallest max_k f_k found from `start`, and where.
pub fn minimise(curve: &Curve, start: &[f64]) -> (f64, Vec<f64>) {
    let n = start.len();
    let within =
        |p: DVector<f64>| DVector::from_fn(n, |i, _| p[i].clamp(curve.bounds[i][0], curve.bounds[i][1]));
    let mut p = within(DVector::from_column_slice(start));
    let mut values = (curve.values)(p.as_slice());
    let mut hessian: Option<DMatrix<f64>> = None;
    let mut at_fresh_start = f64::INFINITY;
    for _ in 0..MOST_ITERATIONS {
        let largest = maximum(&values);
        let active = peaks_and_neighbours(&values, largest);
        let slopes = slopes(curve, &p, &active);
        let fresh = hessian.is_none();
        let b = hessian.take().unwrap_or_else(|| first_hessian(&slopes));
        let Some(inverse) = b.clone().try_inverse() else { break };
        let sizes = DVector::from_iterator(active.len(), active.iter().map(|&k| values[k]));
        let room: Vec<[f64; 2]> =
            curve.bounds.iter().zip(&p).map(|([low, high], p)| [low - p, high - p]).collect();
        let dual = Dual::new(&sizes, &slopes, &inverse, &room);
        let multipliers = dual.solve();
        let h = -(&inverse * (&dual.columns * &multipliers));
        let lambda = multipliers.rows(0, active.len()).into_owned();
        let fall = largest - (&sizes + slopes.tr_mul(&h)).max();
        // also where a value is no finite number
        let small = fall.is_nan() || fall <= SMALLEST_FALL * largest;
        let halvings = if small { 0 } else { MOST_HALVINGS };
        let step = (0..halvings).map(|i| 0.5_f64.powi(i)).find_map(|alpha| {
            let next = within(&p + &h * alpha);
            let found = (curve.values)(next.as_slice());
            (maximum(&found) <= largest - ENOUGH * alpha * fall).then_some((next, found))
        });
        // what the updates have gathered may mislead: only a fresh start that finds nothing ends the search
        let Some((next, found)) = step else {
            if fresh || largest > at_fresh_start * (1.0 - SMALLEST_FALL) {
                break;
            }
            continue;
        };
        if fresh {
            at_fresh_start = largest;
        }
        let change = (self::slopes(curve, &next, &active) - &slopes) * &lambda;
        hessian = Some(updated(b, &(&next - &p), &change));
        (p, values) = (next, found);
    }
    (maximum(&values), p.as_slice().to_vec())
}

/// Each unknown's own steepest slope over the length of the first step.
fn first_hessian(slopes: &DMatrix<f64>) -> DMatrix<f64> {
    let floor = SMALLEST_SLOPE * slopes.amax();
    let steepest = slopes.row_iter().map(|row| row.amax().max(floor) / FIRST_STEP);
    DMatrix::from_diagonal(&DVector::from_iterator(slopes.nrows(), steepest))
}

/// The largest; infinite where one is no number.
fn maximum(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| if v.is_nan() { f64::INFINITY } else { v.max(largest) })
}

fn slopes(curve: &Curve, p: &DVector<f64>, active: &[usize]) -> DMatrix<f64> {
    let mut slopes = DMatrix::zeros(p.len(), active.len());
    for (&k, mut column) in active.iter().zip(slopes.column_iter_mut()) {
        column.copy_from_slice(&(curve.gradient)(p.as_slice(), k));
    }
    slopes
}

fn peaks_and_neighbours(values: &[f64], largest: f64) -> Vec<usize> {
    let last = values.len().saturating_sub(1);
    let is_peak = |k: usize| {
        values[k] >= FLOOR * largest
            && (k == 0 || values[k] >= values[k - 1])
            && (k == last || values[k] >= values[k + 1])
    };
    let beside = |k: usize| (k.saturating_sub(1)..=(k + 1).min(last)).any(is_peak);
    (0..values.len()).filter(|&k| is_peak(k) || (values[k] >= NEAR * largest && beside(k))).collect()
}

/// B with the curvature that the step `s` has shown.
fn updated(b: DMatrix<f64>, s: &DVector<f64>, y: &DVector<f64>) -> DMatrix<f64> {
    let bs = &b * s;
    let (curvature, shown) = (s.dot(&bs), s.dot(y));
    let share = if shown >= 0.2 * curvature { 1.0 } else { 0.8 * curvature / (curvature - shown) };
    let r = y * share + &bs * (1.0 - share);
    let next = &b - &bs * bs.transpose() / curvature + &r * r.transpose() / s.dot(&r);
    if next.iter().all(|x| x.is_finite()) { next } else { b }
}

/// The dual of the quadratic programme: min ½ xᵀ Q x − cᵀ x, x ≥ 0, Σ x = 1 over the peaks' multipliers; the rest of x
/// are those of the bounds.
struct Dual {
    /// Slopes of the peaks, then of the bounds, as columns.
    columns: DMatrix<f64>,
    q: DMatrix<f64>,
    c: DVector<f64>,
    /// Number of peaks.
    peaks: usize,
}

impl Dual {
    fn new(sizes: &DVector<f64>, slopes: &DMatrix<f64>, inverse: &DMatrix<f64>, room: &[[f64; 2]]) -> Self {
        let (n, m) = slopes.shape();
        let mut columns = DMatrix::zeros(n, m + 2 * n);
        let mut c = DVector::zeros(m + 2 * n);
        columns.columns_mut(0, m).copy_from(slopes);
        c.rows_mut(0, m).copy_from(sizes);
        for (i, [low, high]) in room.iter().enumerate() {
            // in the unit of the sizes, so that one tolerance serves all
            let unit = slopes.row(i).amax().max(f64::MIN_POSITIVE);
            for (k, sign, distance) in [(m + 2 * i, -1.0, -low), (m + 2 * i + 1, 1.0, *high)] {
                columns[(i, k)] = sign * unit;
                c[k] = -unit * distance;
            }
        }
        let mut q = columns.tr_mul(&(inverse * &columns));
        // neighbours on a peak have nearly the same slope
        let ridge = RIDGE * q.amax();
        for k in 0..q.nrows() {
            q[(k, k)] += ridge;
        }
        Self { columns, q, c, peaks: m }
    }

    /// x, by adding the most violated constraint and dropping those whose multiplier would turn negative.
    fn solve(&self) -> DVector<f64> {
        let largest = self.c.rows(0, self.peaks).imax();
        let (mut set, mut x) = (vec![largest], DVector::zeros(self.c.len()));
        x[largest] = 1.0;
        for _ in 0..MOST_CHANGES {
            let Some(nu) = self.settle(&mut set, &mut x) else { break };
            let left = &self.c - &self.q * &x;
            let violation = |k: usize| left[k] - if k < self.peaks { nu } else { 0.0 };
            let outside = (0..self.c.len()).filter(|k| !set.contains(k));
            let Some(worst) = outside.reduce(|a, b| if violation(b) > violation(a) { b } else { a }) else {
                break;
            };
            if violation(worst) <= SETTLED * self.c[largest] {
                break;
            }
            set.push(worst);
        }
        x
    }

    /// Minimises over the multipliers in `set`, which loses those that reach zero; gives the multiplier of Σ x = 1.
    fn settle(&self, set: &mut Vec<usize>, x: &mut DVector<f64>) -> Option<f64> {
        loop {
            let k = set.len();
            let counts = |r: usize| f64::from(u8::from(set[r] < self.peaks));
            let system = DMatrix::from_fn(k + 1, k + 1, |r, s| match (r < k, s < k) {
                (true, true) => self.q[(set[r], set[s])],
                (true, false) => counts(r),
                (false, true) => counts(s),
                (false, false) => 0.0,
            });
            let target = DVector::from_fn(k + 1, |r, _| if r < k { self.c[set[r]] } else { 1.0 });
            let solution = system.lu().solve(&target).filter(|s| s.iter().all(|x| x.is_finite()))?;
            let reach = |r: usize| {
                let (from, to) = (x[set[r]], solution[r]);
                if to < 0.0 { (from / (from - to)).max(0.0) } else { f64::INFINITY }
            };
            let (first, share) =
                (0..k).map(|r| (r, reach(r))).reduce(|a, b| if b.1 < a.1 { b } else { a })?;
            for (r, &j) in set.iter().enumerate() {
                x[j] += share.min(1.0) * (solution[r] - x[j]);
            }
            if share >= 1.0 {
                return Some(solution[k]);
            }
            x[set[first]] = 0.0;
            set.remove(first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_line_through_a_parabola_meets_chebyshev() {
        // best line to x² on [0, 1]: x − 1/8, error 1/8
        let x: Vec<f64> = (0..=200).map(|k| f64::from(k) / 200.0).collect();
        let error = |p: &[f64], x: f64| p[0] + p[1] * x - x * x;
        let values = |p: &[f64]| x.iter().map(|x| error(p, *x).abs()).collect();
        let gradient = |p: &[f64], k: usize| {
            let sign = error(p, x[k]).signum();
            vec![sign, sign * x[k]]
        };
        let bounds = [[-9.0, 9.0], [-9.0, 9.0]];
        let (value, p) =
            minimise(&Curve { values: &values, gradient: &gradient, bounds: &bounds }, &[3.0, -2.0]);
        assert!(
            (value - 0.125).abs() < 1e-9 && (p[0] + 0.125).abs() < 1e-6 && (p[1] - 1.0).abs() < 1e-6,
            "{value} {p:?}"
        );
        // with the slope held below 1/2 the ends decide: error of a + x/2 − x² is (1/2 + 1/16)/2
        let bounds = [[-9.0, 9.0], [-9.0, 0.5]];
        let (value, p) =
            minimise(&Curve { values: &values, gradient: &gradient, bounds: &bounds }, &[3.0, -2.0]);
        assert!((value - 0.28125).abs() < 1e-9 && (p[1] - 0.5).abs() < 1e-9, "{value} {p:?}");
    }

    #[test]
    fn a_smooth_minimum_without_a_corner() {
        let values = |p: &[f64]| vec![1.0 + (p[0] - 1.0).powi(2) + 10.0 * (p[1] + 2.0 * p[0]).powi(2)];
        let gradient = |p: &[f64], _: usize| {
            let cross = 20.0 * (p[1] + 2.0 * p[0]);
            vec![2.0 * (p[0] - 1.0) + 2.0 * cross, cross]
        };
        let bounds = [[-9.0, 9.0]; 2];
        let (value, p) =
            minimise(&Curve { values: &values, gradient: &gradient, bounds: &bounds }, &[5.0, 5.0]);
        assert!(
            value - 1.0 < 1e-8 && (p[0] - 1.0).abs() < 1e-3 && (p[1] + 2.0).abs() < 1e-3,
            "{value} {p:?}"
        );
    }
}
