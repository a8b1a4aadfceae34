//! Spectra of the motion, of what free runs leave of it, and of what the model's own disturbance and noise would leave.
//!
//! ```text
//! S_left(ω) = Σ_j |Σ_k h_j(k) e^{−iωkΔ}|² Δ/π
//! ```
//!
//! h_j: how the measured motion goes on after an innovation of one standard deviation, by the predictor's gain and the model's
//! free run (innovation form: Ljung, System Identification, 2nd ed., 1999, section 4.3).

use super::map::{Cell, map};
use super::traces::Trace;
use crate::dataset::{Beside, Run};
use crate::likelihood::fit::{Fit, covariance};
use crate::likelihood::problem::Problem;
use crate::model::pitch::Point;
use crate::validate::cross_spectrum::cross_spectrum;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Bands of a spectrum, evenly spaced on the logarithm.
const BANDS: usize = 36;
/// The free run after an innovation is followed this long, s, from so many rows of the test.
const FOLLOWED_S: f64 = 8.0;
const STARTS: usize = 24;

/// Power densities in the unit of the motion squared per rad/s, by frequency in rad/s.
#[derive(Clone, Debug, Default)]
pub struct Spectra {
    /// The motion.
    pub measured: Vec<[f64; 2]>,
    /// What the baseline's free runs leave.
    pub before: Vec<[f64; 2]>,
    /// What those of the extended model leave.
    pub after: Vec<[f64; 2]>,
    /// What the last model's disturbance and noise leave where it is right.
    pub background: Vec<[f64; 2]>,
    /// Over time and frequency, what the free runs of both leave in units of that.
    pub maps: [Vec<Cell>; 2],
}

/// The spectra over `traces`, each sampled every `step` s, with the background of `fit`.
pub fn spectra(problem: &Problem<'_>, fit: &Fit, traces: &[Trace]) -> Spectra {
    let Some(step) = problem.data.runs.first().map(|run| run.step) else { return Spectra::default() };
    let less = |of: fn(&Trace) -> &Vec<f64>| -> Vec<Vec<f64>> {
        traces.iter().map(|t| t.measured.iter().zip(of(t)).map(|(m, s)| m - s).collect()).collect()
    };
    let measured: Vec<Vec<f64>> = traces.iter().map(|trace| trace.measured.clone()).collect();
    let measured = density(&measured, step);
    let omegas = measured.iter().map(|[omega, _]| *omega).collect::<Vec<f64>>();
    let background = background_of(problem, fit, &omegas).unwrap_or_default();
    Spectra {
        before: density(&less(|trace| &trace.baseline), step),
        after: density(&less(|trace| &trace.extended), step),
        maps: [
            map(traces, |trace| &trace.baseline, &background),
            map(traces, |trace| &trace.extended, &background),
        ],
        background,
        measured,
    }
}

/// Power density of `signals` by bands: the mean of all lines in each.
fn density(signals: &[Vec<f64>], step: f64) -> Vec<[f64; 2]> {
    let pairs: Vec<[&[f64]; 2]> = signals.iter().map(|x| [x.as_slice(), x.as_slice()]).collect();
    let bins = cross_spectrum(&pairs, step).bins;
    let (Some(first), Some(last)) = (bins.first(), bins.last()) else { return Vec::new() };
    let ratio = last.omega_rad_s / first.omega_rad_s;
    let band = |omega: f64| (BANDS as f64 * (omega / first.omega_rad_s).ln() / ratio.ln()) as usize;
    bins.chunk_by(|a, b| band(a.omega_rad_s) == band(b.omega_rad_s))
        .map(|lines| {
            let mean = |of: fn(&_) -> f64| lines.iter().map(of).sum::<f64>() / lines.len() as f64;
            [mean(|line| line.omega_rad_s), mean(|line| line.output)]
        })
        .filter(|[_, power]| *power > 0.0)
        .collect()
}

/// Along the test, from rows of the longest run: a term that sticks at rest answers otherwise where it moves.
fn background_of(problem: &Problem<'_>, fit: &Fit, omegas: &[f64]) -> Option<Vec<[f64; 2]>> {
    let (index, run) = problem.data.runs.iter().enumerate().max_by_key(|(_, run)| run.len())?;
    let follow = ((FOLLOWED_S / run.step) as usize).min(run.len() / 2);
    let starts: Vec<usize> = (1..=STARTS).map(|i| i * (run.len() - follow) / (STARTS + 1)).collect();
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let model = problem.model(&unpacked, run.step)?;
    let gains = model.gain(&unpacked.disturbance, run)?;
    let mut points = Vec::new();
    let visit = |of: usize, k: usize, point: &Point| {
        if of == index && starts.contains(&k) {
            points.push((k, *point));
        }
    };
    problem.track(&unpacked, visit, &mut |_, _| {})?;
    let judged = usize::from(!problem.data.has_rate);
    let driven = model.driven(run);
    let from = |k: usize, point| -> Option<Vec<f64>> {
        Some(driven.simulate(k..k + follow, point)?.iter().map(|y| y[judged]).collect())
    };
    let factor = covariance(&fit.minimum.residuals);
    let [a, b, c] = [factor[(0, 0)], factor[(1, 0)], factor[(1, 1)]];
    // columns of the Cholesky factor; packed as the gains are: the one measured channel first
    let columns = [[a.sqrt(), b / a.sqrt()], [0.0, (c - b * b / a).max(0.0).sqrt()]];
    let mut powers = vec![0.0; omegas.len()];
    for (k, point) in &points {
        let as_it_was = from(*k, *point)?;
        for e in columns {
            let mut moved = *point;
            gains.begin.iter().zip(e).for_each(|(gain, e)| moved.x += *gain * e);
            let mut shown: Vec<f64> = from(*k, moved)?.iter().zip(&as_it_was).map(|(y, y0)| y - y0).collect();
            // at its own sample the innovation is all there is
            shown[0] = e[0];
            for (power, omega) in powers.iter_mut().zip(omegas) {
                let line: Complex<f64> = shown
                    .iter()
                    .enumerate()
                    .map(|(k, h)| Complex::cis(-omega * k as f64 * run.step) * h)
                    .sum();
                let step = run.step / run.measured_every() as f64;
                *power += line.norm_sqr() * step / (PI * points.len() as f64);
            }
        }
    }
    Some(omegas.iter().zip(powers).map(|(omega, power)| [*omega, power]).collect())
}

/// A run like `whole` that is at rest at first, with the input `u`.
pub fn at_rest(whole: &Run, u: Vec<f64>) -> Run {
    let rows = u.len();
    let zeros = |signal: &Option<Vec<f64>>| signal.as_ref().map(|_| vec![0.0; rows]);
    Run {
        origin: 0.0,
        start: 0.0,
        u,
        between: None,
        command_news: None,
        leads: false,
        rate: zeros(&whole.rate),
        angle: zeros(&whole.angle),
        rate_limit: f64::INFINITY,
        beside: Beside::default(),
        supervised: vec![false; rows],
        unmeasured: Vec::new(),
        sections: Vec::new(),
        recording: whole.recording,
        step: whole.step,
        held: whole.held,
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{asked, flight_with};
    use super::*;

    #[test]
    fn a_right_model_leaves_its_background() {
        asked(&flight_with(2, |_, _, _| 0.0), |problem, baseline| {
            let unpacked = problem.unpack(&baseline.effects, &baseline.minimum.values);
            let places = problem.data.places();
            let free = crate::likelihood::free_run::free_run(problem, &unpacked, &places).unwrap();
            let measured = problem.data.judged(&places[0]);
            let left: Vec<f64> = measured.iter().zip(&free[0]).map(|(m, s)| m - s).collect();
            let found = density(&[left], 0.02);
            let omegas: Vec<f64> = found.iter().map(|[omega, _]| *omega).collect();
            let expected = background_of(problem, baseline, &omegas).unwrap();
            let ratio: Vec<f64> = found.iter().zip(&expected).map(|(f, e)| (f[1] / e[1]).ln()).collect();
            let mean = ratio.iter().sum::<f64>() / ratio.len() as f64;
            assert!(mean.abs() < 0.25, "{mean}: {ratio:?}");
        });
    }
}
