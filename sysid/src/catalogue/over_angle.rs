//! What is left, over the angle: where it repeats as the angle turns.

use super::spectral_lines::lines;
use crate::dataset::Amplitudes;
use crate::model::effect::ResidualMoment;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Bins of one turn, and the fewest and most of all that was turned.
const BINS_A_TURN: f64 = 256.0;
const FEWEST: f64 = 200.0;
const MOST: f64 = 16384.0;
/// The estimate of the moment trails the moment: by how much, s.
const TRAILS_S: [f64; 4] = [0.0, 0.03, 0.1, 0.25];

/// A moment that repeats with the angle: amplitude · sin(n θ + phase).
pub struct Ripple {
    pub amplitude: f64,
    /// Periods per turn.
    pub n: f64,
    /// Within one turn from zero, rad.
    pub phase: f64,
}

/// The angle that was turned through, rad; of one that rests, or is none, what leaves every range finite.
pub fn turned(data: &Amplitudes) -> f64 {
    data.turned.clamp(1e-3, 1e9)
}

/// Largest number of periods per turn that is looked for, where the angle turned through `turned` rad.
pub fn most_periods(turned: f64) -> f64 {
    0.4 * bins(turned) * TAU / turned
}

fn bins(turned: f64) -> f64 {
    (BINS_A_TURN * turned / TAU).clamp(FEWEST, MOST).floor()
}

/// The two numbers of periods per turn above `lowest` at which what is left, averaged over bins of the angle, stands out
/// most; the angle is taken as long before the moment as makes the line stand out most.
pub fn ripples(data: &Amplitudes, left: &ResidualMoment, lowest: f64) -> Vec<Ripple> {
    let mut found: Vec<(f64, Ripple)> = Vec::new();
    for trails in TRAILS_S {
        let late = (trails / left.step.max(data.step)).round() as usize;
        let Some((first, width, moments)) = by_angle(left, late) else { continue };
        for line in lines(&moments, width / TAU, lowest) {
            let phase = line.amplitude.arg() + FRAC_PI_2 - line.frequency * first;
            let ripple =
                Ripple { amplitude: line.amplitude.norm(), n: line.frequency, phase: phase.rem_euclid(TAU) };
            found.push((line.prominence, ripple));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let apart = TAU / turned(data);
    let mut kept: Vec<Ripple> = Vec::new();
    for (_, ripple) in found {
        if kept.len() < 2 && kept.iter().all(|other| (other.n - ripple.n).abs() > apart) {
            kept.push(ripple);
        }
    }
    kept
}

/// The middle of the first bin, the width of one, and the mean moment in each, zero where the angle never was; the angle is
/// that of `late` samples before. `None` without an angle that turns.
fn by_angle(left: &ResidualMoment, late: usize) -> Option<(f64, f64, Vec<f64>)> {
    let pairs = || left.angle.iter().zip(left.moment.iter().skip(late));
    let least = pairs().map(|(angle, _)| *angle).fold(f64::INFINITY, f64::min);
    let largest = pairs().map(|(angle, _)| *angle).fold(f64::NEG_INFINITY, f64::max);
    let turned = largest - least;
    if !(turned.is_finite() && turned > 0.0) {
        return None;
    }
    let count = bins(turned);
    let width = turned / count;
    let mut sums = vec![(0.0, 0.0); count as usize];
    let mean = left.moment.iter().sum::<f64>() / left.moment.len() as f64;
    for (angle, moment) in pairs() {
        let bin = (((angle - least) / width) as usize).min(sums.len() - 1);
        sums[bin].0 += moment - mean;
        sums[bin].1 += 1.0;
    }
    let means = sums.into_iter().map(|(sum, n): (f64, f64)| sum / n.max(1.0)).collect();
    Some((least + 0.5 * width, width, means))
}
