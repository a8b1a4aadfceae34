//! Whether a model's parameters are the same everywhere: in every section, at every size of the motion.
//!
//! At the optimum the scores s_k = J_kᵀ W e_k of all rows add up to zero, and each is unpredictable from the past. A
//! parameter θ_i that is larger where a known weight w_k is larger makes the weighted sum differ from zero (score test;
//! Newey, Econometrica 53, 1985; Nyblom, JASA 84, 1989):
//!
//! ```text
//! m = Σ w_k s_ki,    v = A − B I⁻¹ Bᵀ,    A = Σ w_k² J_kiᵀ W J_ki,   B = Σ w_k J_kiᵀ W J_k,   I = Σ J_kᵀ W J_k
//! m²/v ~ χ²(1),      θ_i changes by m/v ± 1/√v per unit of w
//! ```
//!
//! v is widened where the scores are correlated or uneven (Newey and West, 1987).

use crate::estimate::digits;
use crate::held_out::Split;
use crate::likelihood::fit::Fit;
use crate::likelihood::fit::weights;
use crate::likelihood::problem::Problem;
use crate::optim::chord::Chord;
use nalgebra::{DMatrix, DVector};

/// Scores may be correlated over this time, s.
const CORRELATION_S: f64 = 0.5;
/// χ² that neither chance nor the idealised equations of the catalogue reach where the right effect is named: of 70
/// recordings with known truth the highest was 12.
const INCONSISTENT: f64 = 20.0;
/// Smaller shares of what the effects gain are put down to their idealised equations.
const LARGE: f64 = 0.03;
/// A switch of the input counts as recent for this time, s.
const RECENT_S: f64 = 0.3;

const LATE: &str = "late against early";

/// A parameter that is not the same everywhere.
#[derive(Clone, Debug)]
pub struct Inconsistency {
    /// Name of the parameter.
    pub parameter: String,
    /// Where it is another one, as the end of a sentence.
    pub regime: String,
    /// m²/v: χ² with one degree of freedom if the parameter is the same everywhere.
    pub statistic: f64,
}

/// The least consistent parameter of `fit`, where that is more than chance, and more than a small share of what its effects
/// gain over `baseline`.
pub fn inconsistency(
    problem: &Problem<'_>,
    split: &Split,
    baseline: &Fit,
    fit: &Fit,
) -> Option<Inconsistency> {
    let gain = baseline.criterion() - fit.criterion();
    let worst = inconsistencies(problem, split, fit)?.into_iter().next()?;
    (worst.statistic > INCONSISTENT.max(LARGE * gain)).then_some(worst)
}

impl Inconsistency {
    /// As the end of "what the model leaves is ...".
    pub fn words(&self) -> String {
        format!(
            "a moment that makes {} another one {} (chi-squared {} with one degree of freedom)",
            self.parameter,
            self.regime,
            digits(self.statistic)
        )
    }
}

/// All parameters of the physics against all weights, the least consistent first. `None` where the fit has no finite
/// derivatives.
pub fn inconsistencies(problem: &Problem<'_>, split: &Split, fit: &Fit) -> Option<Vec<Inconsistency>> {
    let coordinates = problem.coordinates(&fit.effects);
    let residuals = |values: &[f64]| problem.prediction_errors(&fit.effects, values);
    let slopes =
        Chord::new(&residuals, problem.channels(), &coordinates, &fit.minimum.values)?.into_jacobian();
    let (inverse, _) = weights(&fit.minimum.residuals);
    let rows = fit.minimum.residuals.len();
    let unknowns = slopes.len();
    let w = [inverse[(0, 0)], inverse[(0, 1)], inverse[(1, 1)]];
    let weighted = |e: &[f64; 2]| [w[0] * e[0] + w[1] * e[1], w[1] * e[0] + w[2] * e[1]];
    let inner = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[0] + a[1] * b[1];
    let weighted_slopes: Vec<Vec<[f64; 2]>> =
        slopes.iter().map(|column| column.iter().map(weighted).collect()).collect();
    let errors: Vec<[f64; 2]> = fit.minimum.residuals.iter().map(weighted).collect();
    let information = DMatrix::from_fn(unknowns, unknowns, |i, j| {
        (0..rows).map(|k| inner(&weighted_slopes[i][k], &slopes[j][k])).sum::<f64>()
    });
    let moving: Vec<usize> = (0..unknowns).filter(|&i| information[(i, i)] > 0.0).collect();
    let part = DMatrix::from_fn(moving.len(), moving.len(), |a, b| information[(moving[a], moving[b])]);
    let solver = part.cholesky()?;
    let lag = (CORRELATION_S / problem.sizes.step).ceil() as usize;
    let mut all = Vec::new();
    // The user's mount is held by its prior: its scores do not add up to zero. An effect of time has no other time,
    // and says itself what changes over time.
    let of_time: Vec<usize> = (0..fit.effects.len())
        .filter(|&i| fit.effects[i].about().variable == "t")
        .flat_map(|i| fit.own_range(problem, i))
        .collect();
    let tested = |i: &&usize| {
        let of_model = problem.noise_range().contains(*i) || problem.mount_range().contains(*i);
        !of_model && !of_time.contains(*i)
    };
    let regimes = regimes(problem, split, fit)?.into_iter();
    for (words, weight) in regimes.filter(|(words, _)| of_time.is_empty() || words != LATE) {
        for &i in moving.iter().filter(tested) {
            let scores: Vec<f64> = (0..rows).map(|k| weight[k] * inner(&slopes[i][k], &errors[k])).collect();
            let m: f64 = scores.iter().sum();
            let a: f64 =
                (0..rows).map(|k| weight[k] * weight[k] * inner(&weighted_slopes[i][k], &slopes[i][k])).sum();
            let b = DVector::from_iterator(
                moving.len(),
                moving.iter().map(|&j| {
                    (0..rows).map(|k| weight[k] * inner(&weighted_slopes[i][k], &slopes[j][k])).sum::<f64>()
                }),
            );
            let v = a - b.dot(&solver.solve(&b));
            if v < 1e-6 * a {
                continue;
            }
            let uneven = (long_run(&scores, lag) / a).max(1.0);
            all.push(Inconsistency {
                parameter: coordinates[i].name.clone(),
                regime: words.clone(),
                statistic: m * m / (v * uneven),
            });
        }
    }
    all.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
    Some(all)
}

/// Σ s² + 2 Σ (1 − l/(L+1)) Σ s_k s_{k−l}.
fn long_run(scores: &[f64], lag: usize) -> f64 {
    let at = |l: usize| scores.iter().zip(scores.iter().skip(l)).map(|(a, b)| a * b).sum::<f64>();
    at(0) + 2.0 * (1..=lag).map(|l| (1.0 - l as f64 / (lag + 1) as f64) * at(l)).sum::<f64>()
}

/// Weights of the counted rows, with where they are large in words.
fn regimes(problem: &Problem<'_>, split: &Split, fit: &Fit) -> Option<Vec<(String, Vec<f64>)>> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let sizes = &problem.sizes;
    let delay = (unpacked.plant.delay / sizes.step).round() as usize;
    let recent = (RECENT_S / sizes.step).ceil() as usize;
    let mut named: Vec<(String, Vec<f64>)> = [
        "at large rates",
        "nose-up rates against nose-down",
        "at large angles",
        "nose-up against nose-down",
        "at large commands",
        "at positive commands against negative",
        "shortly after a switch of the input",
        LATE,
    ]
    .iter()
    .map(|words| ((*words).to_owned(), Vec::new()))
    .chain(split.training.iter().map(|place| (format!("in section {}", place.label), Vec::new())))
    .collect();
    // What is known of row k before it is measured is the state after row k - 1.
    let mut last = (usize::MAX, [0.0; 2]);
    problem.track(
        &unpacked,
        |run, k, point| {
            let now = [point.x[0] / sizes.q, point.x[2] / sizes.theta.max(f64::MIN_POSITIVE)];
            let (_, [q, theta]) = core::mem::replace(&mut last, (run, now));
            if !problem.counted[run][k] {
                return;
            }
            let data = &problem.data.runs[run];
            let u = |back: usize| data.u[k.saturating_sub(delay + back)] / sizes.u;
            let moved = (u(0) - u(recent)).abs();
            let of_signals =
                [q.abs(), q, theta.abs(), theta, u(0).abs(), u(0), moved, data.time(k) / sizes.duration];
            let of_sections = split
                .training
                .iter()
                .map(|place| f64::from(u8::from(place.run == run && place.rows.contains(&k))));
            for ((_, weights), value) in named.iter_mut().zip(of_signals.into_iter().chain(of_sections)) {
                weights.push(value);
            }
        },
        &mut |_, _| {},
    )?;
    Some(named)
}
