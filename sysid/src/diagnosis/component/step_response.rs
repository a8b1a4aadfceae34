//! The moment after a step of the command, over the time since.
//!
//! ```text
//! M_k = Σ_j s_j (u_{k−jw} − u_{k−(j+1)w}) + s_J u_{k−Jw}
//! ```
//!
//! s_j is the answer, per unit of the command, j w samples after the step.

use super::regression::Regression;
use super::{Branch, Stretch, regress};
use crate::model::plant::Plant;

/// Lags that are told apart.
const LAGS: usize = 20;
/// How far they reach, s: several time constants of a servo.
const REACH_S: f64 = 0.4;

/// What the data say, with the term and without it.
pub fn branch(stretches: &[Stretch<'_>], plant: &Plant, whitening: &[f64; 3]) -> Option<Branch> {
    let step = stretches.first()?.run.step;
    let width = (REACH_S / LAGS as f64 / step).round().max(1.0) as usize;
    let fill = |stretch: &Stretch<'_>, k: usize, f: &mut [f64]| {
        let u = |lag: usize| stretch.run.u[k.saturating_sub(lag * width)];
        for (j, f) in f.iter_mut().enumerate() {
            *f = if j + 1 < LAGS { u(j) - u(j + 1) } else { u(j) };
        }
    };
    let found = regress(stretches, LAGS, whitening, false, &fill).solve()?;
    let mut of_term = Regression::new(LAGS);
    let mut f = vec![0.0; LAGS];
    for stretch in stretches {
        for k in (0..stretch.rows.len().saturating_sub(1)).filter(|&k| stretch.counted[k + 1]) {
            fill(stretch, k, &mut f);
            of_term.add(0, &f, stretch.rows[k].part);
        }
    }
    let term = of_term.coefficients()?;
    let length = width as f64 * step;
    // The mean of the straight answer over the lags of one class.
    let straight =
        |j: usize| plant.dm_du * (((j + 1) as f64 * length - plant.delay) / length).clamp(0.0, 1.0);
    let at = |j: usize| (j as f64 + 0.5) * length;
    let end = at(LAGS - 1);
    let delay = plant.delay.clamp(0.0, end);
    Some(Branch {
        data: (0..LAGS).map(|j| [at(j), straight(j) + found.values[j], found.standard_errors[j]]).collect(),
        with: (0..LAGS).map(|j| [at(j), straight(j) + term[j]]).collect(),
        without: vec![[0.0, 0.0], [delay, 0.0], [delay, plant.dm_du], [end, plant.dm_du]],
    })
}
