//! The baseline of a diagnosis: the user's simulation, or the grey-box pitch model with values to start from.

use super::pitch::Term;
use super::plant::{Mount, Plant};
use crate::dataset::{Dataset, decorrelation};
use crate::recording::InputUnit;
use nalgebra::{Matrix3, Vector3};

/// The simulation in use: what a diagnosis starts from.
#[derive(Clone)]
pub struct Baseline {
    /// The plant. Its inertia is held; all else is estimated again, the mount under a prior.
    pub plant: Plant,
    /// Whether the loop delay is estimated (otherwise the model's value is trusted, and `extra_delay` questions it).
    pub delay_free: bool,
    /// Physics that the simulation already has, with its values.
    pub terms: Vec<Term>,
}

/// Iyy of the vehicle of the reference experiment, kg m² (Riccardi, Panizza, Lovera, ERF 2014).
const REFERENCE_INERTIA: f64 = 0.1705;
/// Loop delay adopted there, s.
const REFERENCE_DELAY: f64 = 0.06;
impl Baseline {
    /// Without a user's model: a recording whose input is blade pitch in rad is taken for the reference vehicle (known
    /// inertia, soft mount); any other rig has unknown inertia (moments per unit inertia) and a rigid IMU.
    /// The loop delay is estimated.
    pub fn from_data(data: &Dataset) -> Self {
        let plant = if data.input_unit == InputUnit::Rad {
            Plant {
                inertia: REFERENCE_INERTIA,
                dm_dq: -0.27,
                dm_du: 23.0,
                delay: REFERENCE_DELAY,
                mount: Some(Mount { stiffness: 3.8689, damping: 0.02639, inertia: 5e-4 }),
            }
        } else {
            regression(data)
        };
        Self { plant, delay_free: true, terms: Vec::new() }
    }
}

/// ∂M/∂u per unit inertia, roughly, by a regression of the measured motion alone: nothing is known of the plant there, and
/// no missing physics bends it by more than a small factor.
pub fn rough_gain(data: &Dataset) -> f64 {
    regression(data).dm_du
}

/// Values to start from for a rig of unknown inertia: least squares of
/// q[k+m] = a q[k] + b ū[k−d .. k−d+m] + c over the delay d, with m samples over which q decorrelates a little.
fn regression(data: &Dataset) -> Plant {
    let step = data.runs.first().map_or(0.02, |run| run.step);
    let rates: Vec<Vec<f64>> = data.runs.iter().map(crate::dataset::Run::rate_or_slope).collect();
    let stride = decorrelation(&rates).min((0.1 / step).ceil() as usize).max(1);
    let longest = (0.15 / step).ceil() as usize;
    let mut best = (f64::INFINITY, -1.0, 1.0, 0.0);
    for delay in 0..=longest {
        let Some((error, a, b)) = regress_at(data, &rates, stride, delay) else { continue };
        if error < best.0 {
            let a = a.clamp(0.05, 0.999);
            let decay = -a.ln() / (stride as f64 * step);
            best = (error, -decay, b * decay / (1.0 - a), delay as f64 * step);
        }
    }
    let (_, dm_dq, dm_du, delay) = best;
    Plant { inertia: 1.0, dm_dq, dm_du, delay, mount: None }
}

/// Mean square error, a and b of the regression for one delay.
fn regress_at(data: &Dataset, rates: &[Vec<f64>], stride: usize, delay: usize) -> Option<(f64, f64, f64)> {
    let (mut normal, mut right, mut power, mut count) = (Matrix3::zeros(), Vector3::zeros(), 0.0, 0.0);
    for (run, rate) in data.runs.iter().zip(rates) {
        for k in delay..run.len().saturating_sub(stride) {
            let input = run.u[k - delay..k - delay + stride].iter().sum::<f64>() / stride as f64;
            let row = Vector3::new(rate[k], input, 1.0);
            normal += row * row.transpose();
            right += row * rate[k + stride];
            power += rate[k + stride] * rate[k + stride];
            count += 1.0;
        }
    }
    let solution = normal.cholesky()?.solve(&right);
    Some(((power - solution.dot(&right)) / count, solution[0], solution[1]))
}
