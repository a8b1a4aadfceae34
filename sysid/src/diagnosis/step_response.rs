//! The pitch rate after a step of the input from rest, before and after, with 95 % intervals.
//!
//! ```text
//! y(t; p̂) ± 1.96 √(∇y' Σ ∇y),   ∇y by central differences
//! ```

use super::posterior::Visited;
use super::spectra::at_rest;
use crate::dataset::Run;
use crate::likelihood::problem::Problem;

/// The step comes after this much rest, s: before its first row, a run's input is that of the row.
const REST_S: f64 = 1.0;
/// The response is followed this long, s, and has at most so many points.
const FOLLOWED_S: f64 = 2.5;
const MOST_POINTS: usize = 250;
/// Unknowns are moved by this share of their standard deviation, or of their value where that is less.
const SHARE: f64 = 0.1;
const SHARE_OF_VALUE: f64 = 0.01;

/// Responses to a step of a size that the test had.
#[derive(Clone, Debug)]
pub struct StepResponses {
    /// Size of the step, unit of the input: the input's standard deviation.
    pub size: f64,
    /// Of the baseline: time in s, response in rad/s (or rad where no rate was measured), half of the 95 % interval.
    pub before: Vec<[f64; 3]>,
    /// Of the extended model; `None` where nothing was added.
    pub after: Option<Vec<[f64; 3]>>,
}

/// Responses of two models; `None` where a simulation diverges.
pub fn step_responses(
    problem: &Problem<'_>,
    baseline: &Visited,
    extended: &Visited,
) -> Option<StepResponses> {
    let size = problem.sizes.u;
    let changed = !extended.fit.effects.is_empty();
    Some(StepResponses {
        size,
        before: response(problem, baseline, size)?,
        after: if changed { Some(response(problem, extended, size)?) } else { None },
    })
}

fn response(problem: &Problem<'_>, model: &Visited, size: f64) -> Option<Vec<[f64; 3]>> {
    let whole = problem.data.runs.first()?;
    let (rest, rows) = ((REST_S / whole.step) as usize, (FOLLOWED_S / whole.step) as usize);
    let [still, moved] = [0.0, size].map(|u| {
        let input = (0..rest + rows).map(|k| if k < rest { 0.0 } else { u });
        at_rest(whole, input.collect())
    });
    let values = &model.fit.minimum.values;
    let of = |values: &[f64]| {
        let [a, b] = [&moved, &still].map(|run| simulated(problem, model, values, run));
        Some(a?.iter().zip(b?).skip(rest).map(|(a, b)| a - b).collect::<Vec<f64>>())
    };
    let found = of(values)?;
    let deviations = model.information.deviations(values);
    let gradients: Vec<Vec<f64>> = (0..values.len())
        .map(|i| {
            let by = SHARE * deviations[i].min(SHARE_OF_VALUE / SHARE * values[i].abs());
            let at = |by: f64| {
                let mut values = values.clone();
                values[i] += by;
                of(&values)
            };
            match (at(by), at(-by)) {
                (Some(up), Some(down)) if by > 0.0 => {
                    up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * by)).collect()
                }
                _ => vec![0.0; rows],
            }
        })
        .collect();
    let every = rows.div_ceil(MOST_POINTS).max(1);
    let point = |k: usize| {
        let gradient: Vec<f64> = gradients.iter().map(|of| of[k]).collect();
        let still = gradient.iter().all(|g| *g == 0.0);
        let deviation = if still { 0.0 } else { model.information.deviation_along(values, &gradient) };
        [k as f64 * moved.step, found[k], if deviation.is_finite() { 1.96 * deviation } else { 0.0 }]
    };
    Some((0..rows).step_by(every).map(point).collect())
}

fn simulated(problem: &Problem<'_>, model: &Visited, values: &[f64], run: &Run) -> Option<Vec<f64>> {
    let unpacked = problem.unpack(&model.fit.effects, values);
    let sampled = problem.model(&unpacked, run.step)?;
    let judged = usize::from(!problem.data.has_rate);
    let outputs = sampled.simulate(run, 0..run.len(), sampled.start(run))?;
    Some(outputs.iter().map(|y| y[judged]).collect())
}

#[cfg(test)]
mod tests {
    use super::super::data_checks::fixture::{GAIN, model};
    use super::super::fixture::{asked, flight_with, quarters, selection};
    use super::*;

    #[test]
    fn the_interval_holds_the_true_response() {
        let flown = flight_with(3, |_, _, _| 0.0);
        asked(&flown, |problem, baseline| {
            let all = selection(problem, baseline, &quarters(problem), &[]);
            let found = step_responses(problem, &all.visited[0], &all.visited[0]).unwrap();
            let plant = model(GAIN, 0.06).plant;
            let (damping, inertia) = (plant.dm_dq.unwrap(), plant.inertia_kg_m2);
            assert!(found.after.is_none() && found.before[0] == [0.0; 3]);
            for [t, rate, half] in found.before.iter().copied().filter(|[t, ..]| *t > 0.2) {
                let after = t - 0.06;
                let truth = -GAIN * found.size / damping * (1.0 - (damping * after / inertia).exp());
                assert!(half > 0.0 && half < 0.3 * truth.abs(), "{half} of {truth}");
                assert!((rate - truth).abs() < 2.0 * half, "{t} s: {rate} ± {half}, {truth}");
            }
        });
    }
}
