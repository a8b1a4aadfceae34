//! The baseline of a diagnosis: the user's simulation, or the grey-box pitch model with values to start from.

mod driven;

use super::pitch::Term;
use super::plant::Plant;
use crate::dataset::{Dataset, decorrelation};
use nalgebra::{Matrix2, Matrix3, Matrix4, Matrix4x2, Vector2, Vector3, Vector4};

/// The simulation in use: what a diagnosis starts from.
#[derive(Clone)]
pub struct Baseline {
    /// The plant. Its inertia is held; all else is estimated again, the mount under a prior.
    pub plant: Plant,
    /// Whether the loop delay is estimated (otherwise the model's value is trusted, and `extra_delay` questions it).
    pub delay_free: bool,
    /// Whether the input is known to come before the motion that it causes: where the loop is closed, what the controller makes of
    /// a row's motion stands in the same row, and a fit that lets the motion come first finds the controller's inverse.
    pub input_first: bool,
    /// Physics that the simulation already has, with its values.
    pub terms: Vec<Term>,
    /// Ids of those that are held at their values: more than these data are known to say so.
    pub held: Vec<&'static str>,
}

/// What an answer says where there is no model.
pub const ASSUMED: &str = "no model was given: the inertia is not known, so every moment is given per unit inertia (rad/s²), and the \
                           IMU is taken for rigidly mounted; give yours with --model";

impl Baseline {
    /// Without a user's model: unit inertia (moments per unit inertia) and a rigid IMU. The loop delay is estimated.
    pub fn from_data(data: &Dataset) -> Self {
        let plant = regression(data);
        Self { plant, delay_free: true, input_first: false, terms: Vec::new(), held: Vec::new() }
    }
}

/// ∂M/∂u per unit inertia, roughly, by a regression of the measured motion alone: nothing is known of the plant there, and
/// no missing physics bends it by more than a small factor.
pub fn rough_gain(data: &Dataset) -> Option<f64> {
    let [turning, _] = regressions(data);
    turning.error.is_finite().then_some(turning.dm_du)
}

/// Share of the error of the rate alone that angle and rate may leave where the vehicle swings.
const SWINGS: f64 = 0.5;
/// Ratios of two gains, in ln, that missing physics and the errors of a model explain.
pub const TOLERABLE: f64 = 1.5;

/// Whether `dm_du`, per unit inertia, is near enough to what a regression finds to be the start of a search: a placeholder is
/// not.
pub fn is_likely_gain(data: &Dataset, dm_du: f64) -> bool {
    let known: Vec<Regression> =
        regressions(data).into_iter().filter(|found| found.error.is_finite()).collect();
    known.is_empty() || known.iter().any(|found| (found.dm_du / dm_du).abs().ln().abs() < TOLERABLE)
}

/// The vehicle as the regression of angle and rate has it (without a measured angle the rate's sum is taken for one), or a simulation
/// of the angle (`driven`); `None` where these leave more than half of what they do without a stiffness: nothing swings.
pub fn swing_of(data: &Dataset) -> Option<Regression> {
    let swings = |[turning, swinging]: [Regression; 2]| {
        (swinging.error < SWINGS * turning.error && swinging.stiffness > 0.0).then_some(swinging)
    };
    swings(regressions(data)).or_else(|| driven::driven(data).and_then(swings))
}

/// Values to start from for a rig of unknown inertia: least squares over m samples, over which q decorrelates a little, and over
/// the delay d, of
///
/// ```text
/// q[k+m] = a q[k] + b ū[k−d .. k−d+m] + c
/// ```
///
/// or, where the angle's share in it halves the error, of angle and rate together: a plant that swings has a damping and a gain
/// that the first line does not show.
fn regression(data: &Dataset) -> Plant {
    let [turning, swinging] = regressions(data);
    let best = if data.has_angle && swinging.error < SWINGS * turning.error { swinging } else { turning };
    Plant { inertia: 1.0, dm_dq: best.dm_dq, dm_du: best.dm_du, delay: best.delay, mount: None }
}

/// What a regression has found, per unit inertia.
pub struct Regression {
    /// Mean square error of the rate; infinite where there is no such plant.
    error: f64,
    /// ∂M/∂q, 1/s.
    pub dm_dq: f64,
    /// ∂M/∂u, rad/s² per unit of the input.
    pub dm_du: f64,
    /// −∂M/∂θ, 1/s².
    pub stiffness: f64,
    /// Loop delay, s.
    pub delay: f64,
}

/// Of the rate alone, and of angle and rate.
fn regressions(data: &Dataset) -> [Regression; 2] {
    let step = data.runs.first().map_or(0.02, |run| run.step);
    let rates: Vec<Vec<f64>> = data.runs.iter().map(crate::dataset::Run::rate_or_slope).collect();
    let stride = decorrelation(&rates).min((0.1 / step).ceil() as usize).max(1);
    let longest = (0.15 / step).ceil() as usize;
    let span = stride as f64 * step;
    let none = || Regression { error: f64::INFINITY, dm_dq: -1.0, dm_du: 1.0, stiffness: 0.0, delay: 0.0 };
    let angles: Vec<Vec<f64>> = data.runs.iter().map(crate::dataset::Run::angle_or_sum).collect();
    let mut best = [none(), none()];
    if !data.input_changes() {
        return best;
    }
    for rows in 0..=longest {
        let delay = rows as f64 * step;
        let of_rate = turning(data, &rates, stride, rows).map(|(error, [a, b])| {
            let a = a.clamp(0.05, 0.999);
            let decay = -a.ln() / span;
            Regression { error, dm_dq: -decay, dm_du: b * decay / (1.0 - a), stiffness: 0.0, delay }
        });
        let of_both = swing(data, &angles, &rates, stride, rows).and_then(|(error, transition, input)| {
            let [stiffness, dm_dq, dm_du] = continuous(&transition, &input, span)?;
            Some(Regression { error, dm_dq, dm_du, stiffness, delay })
        });
        for (best, found) in best.iter_mut().zip([of_rate, of_both]) {
            if let Some(found) = found
                && found.error < best.error
            {
                *best = found;
            }
        }
    }
    best
}

/// Rows of a regression: run, its rate, k and mean input there.
fn rows<'a>(
    data: &'a Dataset,
    rates: &'a [Vec<f64>],
    stride: usize,
    delay: usize,
) -> impl Iterator<Item = (usize, &'a [f64], usize, f64)> + 'a {
    data.runs.iter().zip(rates).enumerate().flat_map(move |(index, (run, rate))| {
        (delay..run.len().saturating_sub(stride)).map(move |k| {
            let input = run.u[k - delay..k - delay + stride].iter().sum::<f64>() / stride as f64;
            (index, rate.as_slice(), k, input)
        })
    })
}

/// Mean square error, a and b of the first regression for one delay.
fn turning(data: &Dataset, rates: &[Vec<f64>], stride: usize, delay: usize) -> Option<(f64, [f64; 2])> {
    let (mut normal, mut right, mut power, mut count) = (Matrix3::zeros(), Vector3::zeros(), 0.0, 0.0);
    for (_, rate, k, input) in rows(data, rates, stride, delay) {
        let row = Vector3::new(rate[k], input, 1.0);
        normal += row * row.transpose();
        right += row * rate[k + stride];
        power += rate[k + stride] * rate[k + stride];
        count += 1.0;
    }
    let solution = normal.cholesky()?.solve(&right);
    Some(((power - solution.dot(&right)) / count, [solution[0], solution[1]]))
}

/// Mean square error of the rate, transition of (θ, q) over the stride and what the input adds, for one delay.
fn swing(
    data: &Dataset,
    angles: &[Vec<f64>],
    rates: &[Vec<f64>],
    stride: usize,
    delay: usize,
) -> Option<(f64, Matrix2<f64>, Vector2<f64>)> {
    let (mut normal, mut right) = (Matrix4::zeros(), Matrix4x2::zeros());
    let (mut power, mut count) = (0.0, 0.0);
    for (run, rate, k, input) in rows(data, rates, stride, delay) {
        let angle = &angles[run];
        let row = Vector4::new(angle[k], rate[k], input, 1.0);
        let later = Vector2::new(angle[k + stride], rate[k + stride]);
        normal += row * row.transpose();
        right += row * later.transpose();
        power += later[1] * later[1];
        count += 1.0;
    }
    let solution = normal.cholesky()?.solve(&right);
    let error = (power - solution.column(1).dot(&right.column(1))) / count;
    let transition = solution.fixed_view::<2, 2>(0, 0).transpose();
    Some((error, transition, solution.row(2).transpose()))
}

/// −∂M/∂θ, ∂M/∂q and ∂M/∂u of the continuous plant whose angle and rate go over by `transition` within `span` s, the input adding
/// `input`: the logarithm of a matrix with a pair of complex eigenvalues. `None` where it does not swing.
fn continuous(transition: &Matrix2<f64>, input: &Vector2<f64>, span: f64) -> Option<[f64; 3]> {
    let (half, product) = (0.5 * transition.trace(), transition.determinant());
    let imaginary = (product - half * half).sqrt();
    if imaginary.is_nan() || imaginary <= 0.0 {
        return None;
    }
    let turn = imaginary.atan2(half) / imaginary;
    let generator = (Matrix2::identity() * (0.5 * product.ln())
        + (transition - Matrix2::identity() * half) * turn)
        / span;
    let gain = (transition - Matrix2::identity()).try_inverse()? * generator * input;
    Some([-generator[(1, 0)], generator[(1, 1)].min(0.0), gain[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plant_of_a_swing_is_found_again_from_its_transition() {
        // θ̈ = −40 θ − 0.6 θ̇ + 7 u, over 0.1 s
        let generator = Matrix2::new(0.0, 1.0, -40.0, -0.6);
        let transition = (generator * 0.1).exp();
        let input =
            generator.try_inverse().unwrap() * (transition - Matrix2::identity()) * Vector2::new(0.0, 7.0);
        let found = continuous(&transition, &input, 0.1).unwrap();
        assert!(found.iter().zip([40.0, -0.6, 7.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        assert!(continuous(&Matrix2::new(1.0, 0.1, 0.0, 0.9), &input, 0.1).is_none());
    }
}
