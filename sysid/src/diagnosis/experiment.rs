//! The next experiment: the excitation that would best tell two candidates apart.
//!
//! Candidate A's model flies each excitation without noise; candidate B's predictor, its plant fitted again, looks on.
//! What its innovations keep, weighed with the innovations' covariance, is the expected likelihood ratio.

use super::answer::NextExperiment;
use super::posterior::is_shape;
use crate::dataset::Run;
use crate::estimate::digits;
use crate::likelihood::fit::Fit;
use crate::likelihood::fit::weights;
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Dwell ranges of the paper's four campaigns, s.
const DWELLS: [[f64; 2]; 4] = [[0.05, 0.1], [0.1, 0.2], [0.2, 0.4], [0.4, 0.8]];
/// Amplitudes tried, relative to the amplitude of the recording at hand.
const AMPLITUDES: [f64; 3] = [0.8, 1.0, 1.25];
/// Length of an excitation that is flown, s.
const DURATION_S: f64 = 25.0;
/// 2 ln(likelihood ratio) that decides: odds of 400 to 1.
const DECISIVE: f64 = 12.0;
/// One for which the longest test is worth its while: odds of twenty to one.
const TELLING: f64 = 6.0;
/// Shortest and longest test that is asked for, s.
const LENGTHS_S: [f64; 2] = [10.0, 300.0];
const SEED: u64 = 20_140_901;

/// The excitation with the largest expected likelihood ratio between the two fits.
pub fn best(problem: &Problem<'_>, a: &Fit, b: &Fit) -> Option<NextExperiment> {
    let scale = problem.sizes.u;
    let limit = largest_angle(problem);
    let mut best: Option<(f64, [f64; 2], f64)> = None;
    for dwell in DWELLS {
        for relative in AMPLITUDES {
            let amplitude = relative * scale;
            let flown = fly(problem, a, prbs(dwell, amplitude, problem.sizes.step), amplitude, limit);
            if let Some(ratio) = flown.and_then(|run| expected_ratio(problem, a, b, &run))
                && best.is_none_or(|(most, ..)| ratio > most)
            {
                best = Some((ratio, dwell, amplitude));
            }
        }
    }
    let worth_a_flight = |ratio: f64| ratio * LENGTHS_S[1] / DURATION_S >= TELLING;
    let (ratio, dwell, amplitude) = best.filter(|(ratio, ..)| worth_a_flight(*ratio))?;
    let amplitude = (amplitude * 1e4).round() / 1e4;
    let ids = [own_term(a, b), own_term(b, a)].map(str::to_owned);
    let unit = match problem.data.input_unit.symbol() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let length = (DURATION_S * DECISIVE / ratio).clamp(LENGTHS_S[0], LENGTHS_S[1]).ceil();
    let within = limit.map_or(String::new(), |limit| {
        format!(", with a supervisor that keeps the angle within the ±{} rad of these data", digits(limit))
    });
    let why = format!(
        "{length:.0} s of PRBS with ±{amplitude}{unit} are expected to change 2 ln(likelihood ratio) of {} against {} by \
         {:.0}{within}",
        ids[0],
        ids[1],
        ratio * length / DURATION_S,
    );
    Some(NextExperiment {
        switching_s: dwell,
        amplitude_rad: amplitude,
        length_s: length,
        section: "quasi-open loop",
        separates: ids,
        why,
    })
}

/// The last term that `fit` has and `other` lacks.
fn own_term(fit: &Fit, other: &Fit) -> &'static str {
    let own = |e: &&&'static dyn Effect| !e.is_background() && other.position(e.about().id).is_none();
    match fit.effects.iter().rev().find(own) {
        Some(&shape) if is_shape(shape) => "unlisted",
        Some(term) => term.about().id,
        None => "baseline",
    }
}

/// The largest angle of the recordings: so far the supervisor lets the vehicle go.
fn largest_angle(problem: &Problem<'_>) -> Option<f64> {
    let angles = problem.data.runs.iter().map(|run| run.angle.as_ref());
    let largest = |angles: &Vec<f64>| angles.iter().fold(0.0, |most: f64, theta| most.max(theta.abs()));
    angles.map(|run| run.map(largest)).try_fold(0.0, |most: f64, one| Some(most.max(one?)))
}

/// What `fit` shows when `excitation` flies it. Beyond the `limit` the supervisor commands the angle back, until it has
/// halved.
fn fly(
    problem: &Problem<'_>,
    fit: &Fit,
    excitation: Vec<f64>,
    amplitude: f64,
    limit: Option<f64>,
) -> Option<Run> {
    let count = excitation.len();
    let mut run = Run {
        recording: 0,
        origin: 0.0,
        start: 0.0,
        step: problem.sizes.step,
        held: true,
        rate: problem.data.has_rate.then(|| vec![0.0; count]),
        angle: problem.data.has_angle.then(|| vec![0.0; count]),
        rate_limit: f64::INFINITY,
        beside: Default::default(),
        supervised: vec![false; count],
        unmeasured: Vec::new(),
        sections: Vec::new(),
        u: excitation,
        between: None,
        command_news: None,
        leads: false,
    };
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let model = problem.model(&unpacked, run.step)?;
    let mut point = model.start(&run);
    for k in 0..count {
        let [rate, angle] = model.output(&point);
        let before = k > 0 && run.supervised[k - 1];
        let reach = if before { 0.5 } else { 1.0 };
        if limit.is_some_and(|limit| angle.abs() > reach * limit) {
            run.supervised[k] = true;
            run.u[k] = -amplitude * (angle * unpacked.plant.dm_du).signum();
        }
        for (signal, value) in [(&mut run.rate, rate), (&mut run.angle, angle)] {
            if let Some(signal) = signal {
                signal[k] = value;
            }
        }
        if !model.advance(&mut point, &run, k) {
            return None;
        }
    }
    Some(run)
}

fn prbs(dwell: [f64; 2], amplitude: f64, step: f64) -> Vec<f64> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut level = amplitude;
    let mut next = random.random_range(dwell[0]..dwell[1]);
    (0..(DURATION_S / step) as usize)
        .map(|k| {
            if k as f64 * step >= next {
                level = -level;
                next += random.random_range(dwell[0]..dwell[1]);
            }
            level
        })
        .collect()
}

/// 2 ln(likelihood ratio) of `a`, which flew `run`, against `b`.
fn expected_ratio(problem: &Problem<'_>, a: &Fit, b: &Fit, run: &Run) -> Option<f64> {
    let (weight, _) = weights(&a.minimum.residuals);
    let root = weight.symmetric_eigen();
    let root = root.eigenvectors
        * nalgebra::Matrix2::from_diagonal(&root.eigenvalues.map(|x| x.max(0.0).sqrt()))
        * root.eigenvectors.transpose();
    let whitened = |values: &[f64]| -> Option<DVector<f64>> {
        let unpacked = problem.unpack(&b.effects, values);
        let model = problem.model(&unpacked, run.step)?;
        let gain = model.gain(&unpacked.disturbance, run)?;
        let e = model.innovations(run, &gain, run.len(), |_, _| {})?;
        let packed = e.iter().map(|e| if problem.data.has_rate { *e } else { [e[1], 0.0] });
        Some(DVector::from_iterator(
            2 * e.len(),
            packed.flat_map(|e| {
                let w = root * nalgebra::Vector2::new(e[0], e[1]);
                [w[0], w[1]]
            }),
        ))
    };
    let at = whitened(&b.minimum.values)?;
    // What B can make good by other values of the plant and of its own parameters does not separate.
    let first_own = problem.plant_unknowns() + problem.noise_unknowns();
    let movable: Vec<usize> =
        (0..problem.plant_unknowns()).chain(first_own..b.minimum.values.len()).collect();
    let mut columns = Vec::new();
    for i in movable {
        let mut moved = b.minimum.values.clone();
        let h = 1e-4 * moved[i].abs().max(1e-6);
        moved[i] += h;
        columns.push((whitened(&moved)? - &at) / h);
    }
    let sensitivities = DMatrix::from_columns(&columns);
    let mut normal = sensitivities.tr_mul(&sensitivities);
    for i in 0..normal.nrows() {
        normal[(i, i)] = normal[(i, i)] * (1.0 + 1e-9) + f64::MIN_POSITIVE;
    }
    let solution = normal.cholesky()?.solve(&sensitivities.tr_mul(&at));
    let ratio = (at - sensitivities * solution).norm_squared();
    ratio.is_finite().then_some(ratio)
}

#[cfg(test)]
mod tests;
