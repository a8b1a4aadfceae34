//! The loop delay by profile likelihood: for each τ everything else is fitted again,
//!
//! ```text
//! D(τ) = N ln V(τ) − min N ln V,    95 %: D(τ) ≤ 3.84 (χ² with one degree of freedom)
//! ```
//!
//! with the noise model held at that of the best fit, so that D is a likelihood ratio. Unlike a standard error it
//! shows a second minimum, and a side to which the data set no limit.

use super::{LONGEST_DELAY_S, Noise, Options, best, no_fit, problem};
use crate::error::Error;
use crate::identify::fir::Piece;
use crate::model::plant::Plant;
use rayon::prelude::*;
use serde::Serialize;

/// 95 % quantile of χ² with one degree of freedom.
const LIMIT: f64 = 3.841_458_820_694_124;
/// Steps of τ in a sample.
const PER_SAMPLE: f64 = 2.0;
/// Steps that place an end of the interval.
const END_STEPS: usize = 6;
/// D this close to its limit is at it.
const AT_LIMIT: f64 = 0.05;

/// The profile.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DelayProfile {
    /// τ (s) and D(τ).
    pub points: Vec<[f64; 2]>,
    /// τ where D is least, s.
    pub best_s: f64,
    /// Where D stays below its limit around it, s; an end at 0 or at the last point is open.
    pub ci95_s: [f64; 2],
}

/// The profile over 0 to the best delay and twice as far, half a sample apart.
///
/// # Errors
/// As [`super::fit`].
pub fn delay_profile(pieces: &[Piece], start: &Plant, options: &Options) -> Result<DelayProfile, Error> {
    let free = Options { free_delay: true, noise: Noise::Coloured, ..*options };
    let whole = problem(pieces, start, &free)?;
    let (at, _, ar, _) = best(&whole, &free).ok_or_else(no_fit)?;
    let plant = whole.plant(&at.theta);
    let least = at.rows as f64 * at.squares.ln();
    let deviance = |delay: f64| -> Option<f64> {
        let held = problem(pieces, &Plant { delay, ..plant }, &Options { free_delay: false, ..free }).ok()?;
        let (at, _) = held.minimise(&held.theta(&held.start), &at.x0, &ar)?;
        Some((at.rows as f64 * at.squares.ln() - least).max(0.0))
    };
    let step = whole.step / PER_SAMPLE;
    let last = (2.0 * plant.delay + 4.0 * whole.step).min(LONGEST_DELAY_S);
    let points: Vec<[f64; 2]> = (0..=(last / step) as usize)
        .into_par_iter()
        .filter_map(|i| Some([i as f64 * step, deviance(i as f64 * step)?]))
        .collect();
    let end = |direction: f64| {
        let beyond = points
            .iter()
            .filter(|p| (p[0] - plant.delay) * direction > 0.0 && p[1] > LIMIT)
            .min_by(|a, b| (a[0] - plant.delay).abs().total_cmp(&(b[0] - plant.delay).abs()));
        let Some(beyond) = beyond else { return if direction < 0.0 { 0.0 } else { last } };
        // √D is nearly straight: regula falsi on it, kept within the bracket
        let (mut inside, mut outside) = ([plant.delay, 0.0], *beyond);
        for _ in 0..END_STEPS {
            let share = (LIMIT.sqrt() - inside[1].sqrt()) / (outside[1].sqrt() - inside[1].sqrt());
            let middle = inside[0] + share.clamp(0.05, 0.95) * (outside[0] - inside[0]);
            match deviance(middle) {
                Some(d) if (d - LIMIT).abs() < AT_LIMIT => return middle,
                Some(d) if d <= LIMIT => inside = [middle, d],
                other => outside = [middle, other.unwrap_or(outside[1])],
            }
        }
        inside[0]
    };
    Ok(DelayProfile { best_s: plant.delay, ci95_s: [end(-1.0), end(1.0)], points })
}
