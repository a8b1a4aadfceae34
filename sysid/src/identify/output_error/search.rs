//! Gauss–Newton with Levenberg's damping over the parameters; each section's initial state and offset are eliminated
//! from its normal equations, exactly, for the free run is linear in them (variable projection; Golub, Pereyra, SIAM
//! Journal on Numerical Analysis 10, 1973).

use super::rows::{Section, Sensitivities};
use crate::identify::input_fit::eliminate;
use crate::linalg::gram;
use crate::model::plant::{Mount, Plant};
use crate::model::sampled::{Parameter, SampledPlant};
use core::f64::consts::TAU;
use nalgebra::{DMatrix, DVector, Vector4};

/// Steps at most.
const MOST_STEPS: usize = 40;
/// A step is the last when it lowers N V by less than this many noise variances.
const SETTLED: f64 = 1e-7;
/// Errors beyond this multiple of the output's power are those of a run that has diverged: nothing can be eliminated
/// from them.
const DIVERGED: f64 = 1e8;
/// Share of the output's power that errors cannot fall below.
const ROUNDING: f64 = 1e-15;
/// A parameter this close to a bound, as a share of its range, stands on it.
const HAIR: f64 = 1e-9;

/// A parameter that is searched, within bounds; the mount's on the logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coordinate {
    pub parameter: Parameter,
    pub bounds: [f64; 2],
}

/// Data, and what is held while searching.
pub(super) struct Problem<'a> {
    pub sections: Vec<Section<'a>>,
    pub start: Plant,
    pub step: f64,
    pub held_input: bool,
    pub angle: bool,
    pub coordinates: Vec<Coordinate>,
}

/// A point of the search, with the normal equations there.
#[derive(Clone)]
pub(super) struct At {
    pub theta: Vec<f64>,
    /// Initial states by section.
    pub x0: Vec<Vector4<f64>>,
    /// Offsets by section.
    pub offsets: Vec<f64>,
    /// Normal equations by section with initial state and offset eliminated.
    eliminated: Vec<DMatrix<f64>>,
    /// JᵀJ of the parameters, Jᵀe.
    pub hessian: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Sum of squares of the whitened errors.
    pub squares: f64,
    /// Rows in it.
    pub rows: usize,
}

impl<'a> Problem<'a> {
    /// The plant with `theta` in place of its parameters.
    pub fn plant(&self, theta: &[f64]) -> Plant {
        let mut plant = self.start;
        let mut mode_and_damping = plant.mount.map(|m| {
            let omega = (m.stiffness / m.inertia).sqrt();
            [omega, m.damping / (2.0 * omega * m.inertia)]
        });
        for (c, value) in self.coordinates.iter().zip(theta) {
            match (c.parameter, &mut mode_and_damping) {
                (Parameter::DmDq, _) => plant.dm_dq = *value,
                (Parameter::DmDu, _) => plant.dm_du = *value,
                (Parameter::Delay, _) => plant.delay = *value,
                (Parameter::MountMode, Some(mount)) => mount[0] = value.exp(),
                (Parameter::MountDamping, Some(mount)) => mount[1] = value.exp(),
                _ => {}
            }
        }
        plant.mount = plant
            .mount
            .zip(mode_and_damping)
            .map(|(mount, [omega, damping])| Mount::from_mode(omega / TAU, damping, mount.inertia));
        plant
    }

    /// The same over the first part of each section, in all about `rows`; `None` where there are not twice as many.
    pub fn shortened(&self, rows: usize) -> Option<Self> {
        let all: usize = self.sections.iter().map(|s| s.rows.len()).sum();
        if all < 2 * rows {
            return None;
        }
        let cut = |s: &Section<'a>| {
            let kept = (s.rows.len() * rows / all).max(40).min(s.rows.len());
            Section { rows: s.rows.start..s.rows.start + kept, ..s.clone() }
        };
        Some(Self {
            sections: self.sections.iter().map(cut).collect(),
            coordinates: self.coordinates.clone(),
            ..*self
        })
    }

    /// The coordinates' values of `plant`, within their bounds.
    pub fn theta(&self, plant: &Plant) -> Vec<f64> {
        let mount = plant.mount.map(|m| {
            let omega = (m.stiffness / m.inertia).sqrt();
            [omega.ln(), (m.damping / (2.0 * omega * m.inertia)).ln()]
        });
        let value = |c: &Coordinate| {
            let value = match c.parameter {
                Parameter::DmDq => plant.dm_dq,
                Parameter::DmDu => plant.dm_du,
                Parameter::Delay => plant.delay,
                Parameter::MountMode => mount.map_or(0.0, |m| m[0]),
                Parameter::MountDamping => mount.map_or(0.0, |m| m[1]),
                Parameter::MountInertia => plant.mount.map_or(0.0, |m| m.inertia.ln()),
            };
            value.clamp(c.bounds[0], c.bounds[1])
        };
        self.coordinates.iter().map(value).collect()
    }

    /// Sums of squares below this are rounding.
    fn rounding(&self) -> f64 {
        let power = |s: &Section| s.y[s.rows.clone()].iter().map(|y| y * y).sum::<f64>();
        ROUNDING * self.sections.iter().map(power).sum::<f64>() + f64::MIN_POSITIVE
    }

    /// Number of states.
    pub fn order(&self) -> usize {
        SampledPlant::new(&self.start, self.step, self.held_input).order(self.angle)
    }

    pub fn parameters(&self) -> Vec<Parameter> {
        self.coordinates.iter().map(|c| c.parameter).collect()
    }

    pub fn sensitivities(&self, theta: &[f64], parameters: &[Parameter]) -> Sensitivities {
        Sensitivities::new(
            &SampledPlant::new(&self.plant(theta), self.step, self.held_input),
            self.angle,
            parameters,
        )
    }

    /// The normal equations at `theta`, linearised about the initial states `x0`; `None` where the free run overflows.
    pub fn at(&self, theta: &[f64], x0: &[Vector4<f64>], ar: &[f64]) -> Option<At> {
        let model = self.sensitivities(theta, &self.parameters());
        let (nuisance, unknowns, width) = (model.order + 1, theta.len(), model.width());
        let mut total = DMatrix::zeros(unknowns + 1, unknowns + 1);
        let (mut eliminated, mut rows, mut raw) = (Vec::with_capacity(self.sections.len()), 0, 0.0);
        for (section, x0) in self.sections.iter().zip(x0) {
            let mut products = DMatrix::zeros(width, width);
            model.rows(section, x0, ar, &mut |some| {
                products += gram(some, width);
            });
            raw += products[(width - 1, width - 1)];
            eliminate(&mut products, nuisance);
            total += products.view((nuisance, nuisance), (unknowns + 1, unknowns + 1));
            rows += section.rows.len().saturating_sub(ar.len());
            eliminated.push(products);
        }
        let squares = total[(unknowns, unknowns)].max(self.rounding());
        if !total.iter().all(|x| x.is_finite()) || raw > DIVERGED / ROUNDING * self.rounding() {
            return None;
        }
        let mut hessian = total.view((0, 0), (unknowns, unknowns)).into_owned();
        hessian.fill_upper_triangle_with_lower_triangle();
        let gradient = DVector::from_fn(unknowns, |i, _| total[(unknowns, i)]);
        let mut at = At {
            theta: theta.to_vec(),
            x0: x0.to_vec(),
            offsets: vec![0.0; x0.len()],
            eliminated,
            hessian,
            gradient,
            squares,
            rows,
        };
        at.resolve(model.order);
        Some(at)
    }

    /// Parameters that may move: not on a bound that the gradient pushes against.
    pub fn free(&self, at: &At) -> Vec<usize> {
        let may_move = |i: &usize| {
            let [low, high] = self.coordinates[*i].bounds;
            let hair = HAIR * (high - low).min(1.0);
            let outward = |to_low: bool| (at.gradient[*i] < 0.0) == to_low;
            !(at.theta[*i] <= low + hair && outward(true) || at.theta[*i] >= high - hair && outward(false))
        };
        (0..at.theta.len()).filter(may_move).collect()
    }

    /// Whether a parameter stands on a bound.
    pub fn on_bound(&self, theta: &[f64], i: usize) -> bool {
        let [low, high] = self.coordinates[i].bounds;
        let hair = HAIR * (high - low).min(1.0);
        theta[i] <= low + hair || theta[i] >= high - hair
    }

    /// The minimum from `theta`, and whether the search settled there.
    pub fn minimise(&self, theta: &[f64], x0: &[Vector4<f64>], ar: &[f64]) -> Option<(At, bool)> {
        let mut at = self.at(theta, x0, ar)?;
        let mut damping = 0.0;
        for _ in 0..MOST_STEPS {
            let free = self.free(&at);
            let Some(step) = damped_step(&at, &free, damping) else {
                damping = next_damping(damping)?;
                continue;
            };
            let trial: Vec<f64> = at
                .theta
                .iter()
                .zip(&step)
                .zip(&self.coordinates)
                .map(|((theta, step), c)| (theta + step).clamp(c.bounds[0], c.bounds[1]))
                .collect();
            let variance = at.squares / at.rows as f64;
            let promised = free.iter().map(|&i| step[i] * at.gradient[i]).sum::<f64>();
            match self.at(&trial, &at.x0, ar) {
                Some(next) if next.squares <= at.squares => {
                    at = next;
                    damping *= 0.1;
                    if promised <= SETTLED * variance {
                        return Some((at, true));
                    }
                }
                _ if promised <= SETTLED * variance => return Some((at, true)),
                _ => match next_damping(damping) {
                    Some(more) => damping = more,
                    None => return Some((at, false)),
                },
            }
        }
        Some((at, false))
    }
}

impl At {
    /// Initial states and offsets at these parameters.
    fn resolve(&mut self, order: usize) {
        for (section, products) in self.eliminated.iter().enumerate() {
            let found = explained_by_nuisance(products, order, products.nrows() - 1);
            for (r, delta) in found[..order].iter().enumerate() {
                self.x0[section][r] += delta;
            }
            self.offsets[section] = found[order];
        }
    }

    /// What initial state and offset of a section explain of the derivative to each parameter: coefficients of (γ, 1).
    pub fn projections(&self, section: usize, order: usize) -> Vec<Vec<f64>> {
        let products = &self.eliminated[section];
        (order + 1..products.nrows() - 1).map(|j| explained_by_nuisance(products, order, j)).collect()
    }
}

/// Coefficients of (γ, 1) in the regression of entry `target` of the rows on them, by substitution into the eliminated
/// equations; zero for one that shows nothing of its own.
fn explained_by_nuisance(products: &DMatrix<f64>, order: usize, target: usize) -> Vec<f64> {
    let mut found = vec![0.0; order + 1];
    for p in (0..=order).rev() {
        if products[(p, p)] > 0.0 {
            let later: f64 = (p + 1..=order).map(|j| products[(j, p)] * found[j]).sum();
            found[p] = (products[(target, p)] - later) / products[(p, p)];
        }
    }
    found
}

fn next_damping(damping: f64) -> Option<f64> {
    let more = if damping < 1e-4 { 1e-3 } else { 10.0 * damping };
    (more < 1e10).then_some(more)
}

/// (H + λ diag H) δ = g over the free parameters, scaled to a unit diagonal.
fn damped_step(at: &At, free: &[usize], damping: f64) -> Option<Vec<f64>> {
    let mut step = vec![0.0; at.theta.len()];
    let size = |i: usize| Some(at.hessian[(i, i)].sqrt()).filter(|s| *s > 0.0).unwrap_or(1.0);
    let scale: Vec<f64> = free.iter().map(|&i| size(i)).collect();
    let matrix = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        let entry = at.hessian[(free[a], free[b])] / (scale[a] * scale[b]);
        if a == b { entry + damping } else { entry }
    });
    let target = DVector::from_fn(free.len(), |a, _| at.gradient[free[a]] / scale[a]);
    let solution = matrix.cholesky()?.solve(&target);
    for (a, &i) in free.iter().enumerate() {
        step[i] = solution[a] / scale[a];
    }
    step.iter().all(|s| s.is_finite()).then_some(step)
}
