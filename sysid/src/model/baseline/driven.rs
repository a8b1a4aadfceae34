//! What the command turns about the angle at which it rests, found by its simulation: a drive that holds a position moves within a
//! few rows, and a regression of rates that are differences of angles does not see how.
//!
//! ```text
//! w'' = u(t − d) − k w − c w',    θ ≈ b w + const      k, c and d of a grid, b by least squares over all rows
//! ```

use super::Regression;
use crate::dataset::{Dataset, Run};
use nalgebra::{Matrix3, Vector3};

/// Frequencies √k of the grid, rad/s, from a period of the longest run to a radian a row at most.
const FREQUENCIES: usize = 12;
const QUICKEST_ROW: f64 = 1.0;
/// Damping ratios with a stiffness,
const RATIOS: [f64; 5] = [0.1, 0.3, 0.6, 1.0, 1.6];
/// and c without one, 1/s.
const DAMPINGS: [f64; 6] = [0.0, 0.3, 1.0, 3.0, 10.0, 30.0];
/// Longest delay and the least between two that are tried, s.
const LONGEST_DELAY: f64 = 0.3;
const APART: f64 = 0.02;

/// Without a stiffness, and with one: the best of the grid; `None` where there is no angle or nothing moves.
pub(super) fn driven(data: &Dataset) -> Option<[Regression; 2]> {
    if !data.has_angle || !data.input_changes() {
        return None;
    }
    let longest = data.runs.iter().max_by_key(|run| run.len())?;
    let slowest = std::f64::consts::TAU / (longest.len() as f64 * longest.step);
    let ratio = (QUICKEST_ROW / longest.step / slowest).powf(1.0 / (FREQUENCIES - 1) as f64);
    let swings = (0..FREQUENCIES).flat_map(|i| {
        let omega = slowest * ratio.powi(i as i32);
        RATIOS.map(|zeta| [omega * omega, 2.0 * zeta * omega])
    });
    let best = |plants: Vec<[f64; 2]>| {
        let told = plants.into_iter().filter_map(|plant| best_delay(data, plant));
        told.min_by(|a, b| a.error.total_cmp(&b.error))
    };
    Some([best(DAMPINGS.map(|c| [0.0, c]).to_vec())?, best(swings.collect())?])
}

/// One plant of the grid with the delay that tells most.
fn best_delay(data: &Dataset, [stiffness, damping]: [f64; 2]) -> Option<Regression> {
    let motions: Vec<Vec<f64>> = data.runs.iter().map(|run| motion(run, stiffness, damping)).collect();
    let step = data.runs.first()?.step;
    let stride = (APART / step).ceil().max(1.0) as usize;
    let longest = (LONGEST_DELAY / step) as usize;
    let told = (0..=longest).step_by(stride).filter_map(|rows| {
        let (gain, error) = scaled(data, &motions, rows)?;
        let delay = rows as f64 * step;
        Some(Regression { error, dm_dq: -damping, dm_du: gain, stiffness, delay })
    });
    told.min_by(|a, b| a.error.total_cmp(&b.error))
}

/// w of every row, which begins at rest under the first input.
fn motion(run: &Run, stiffness: f64, damping: f64) -> Vec<f64> {
    let generator = Matrix3::new(0.0, 1.0, 0.0, -stiffness, -damping, 1.0, 0.0, 0.0, 0.0);
    let step = (generator * run.step).exp();
    let begin = if stiffness > 0.0 { run.u[0] / stiffness } else { 0.0 };
    let mut state = Vector3::new(begin, 0.0, 0.0);
    let next = |&u: &f64| {
        let now = state[0];
        state[2] = u;
        state = step * state;
        now
    };
    run.u.iter().map(next).collect()
}

/// b, and the mean square of what it leaves of the angle, where w comes `rows` later.
fn scaled(data: &Dataset, motions: &[Vec<f64>], rows: usize) -> Option<(f64, f64)> {
    let (mut power, mut product, mut square, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (run, motion) in data.runs.iter().zip(motions) {
        let angle = run.angle.as_deref()?.get(rows..).unwrap_or_default();
        let n = angle.len() as f64;
        let mean = |signal: &[f64]| signal.iter().take(angle.len()).sum::<f64>() / n.max(1.0);
        let (of_angle, of_motion) = (mean(angle), mean(motion));
        for (y, w) in angle.iter().zip(motion) {
            let (y, w) = (y - of_angle, w - of_motion);
            power += y * y;
            product += y * w;
            square += w * w;
        }
        count += n;
    }
    let gain = product / square;
    gain.is_finite().then(|| (gain, (power - gain * product) / count))
}

#[cfg(test)]
mod tests {
    use super::super::swing_of;
    use super::*;
    use crate::diagnosis::data_checks::fixture::{Flight, STEP, flight};

    /// The angle, alone and read in every second row, of a drive that holds the position `gain` u: θ̈ = k (gain u − θ) − c θ̇.
    fn held(gain: f64, k: f64, c: f64) -> Dataset {
        let flown = flight(1, 0.0);
        let (mut angle, mut rate, fine) = (0.0, 0.0, 50);
        let dt = STEP / f64::from(fine);
        let mut theta: Vec<f64> = Vec::new();
        for (row, u) in flown.u.iter().enumerate() {
            theta.push(if row % 2 == 0 { angle } else { theta[row - 1] });
            for _ in 0..fine {
                rate += dt * (k * (gain * u - angle) - c * rate);
                angle += dt * rate;
            }
        }
        let mut recording = Flight { theta: theta.clone(), ..flown }.recording();
        // beside a rate that is new in each row the readings would be joined
        (recording.q, recording.theta) = (None, Some(theta));
        Dataset::new(&[recording]).unwrap()
    }

    #[test]
    fn a_drive_that_holds_a_position_is_found_with_what_it_turns_per_command() {
        let data = held(2.0, 400.0, 32.0);
        let [turning, swinging] = driven(&data).unwrap();
        assert!(swinging.error < 0.1 * turning.error, "{} {}", swinging.error, turning.error);
        let found = swing_of(&data).unwrap();
        assert!((found.dm_du / found.stiffness - 2.0).abs() < 0.1, "{} {}", found.dm_du, found.stiffness);
        assert!((0.4..2.5).contains(&(found.stiffness / 400.0)), "{}", found.stiffness);
    }

    #[test]
    fn what_no_angle_shows_is_not_asked() {
        let mut recording = flight(1, 0.0).recording();
        recording.theta = None;
        assert!(driven(&Dataset::new(&[recording]).unwrap()).is_none());
    }
}
