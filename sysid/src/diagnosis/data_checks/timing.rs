//! The loop delay that the data want against the model's, and whether the input is held between samples.
//!
//! A held input is half a sample late against an interpolated one; with the delay free, the two differ by the shape of
//! the response within a sample alone, and often the data do not tell them apart.

use super::{DataCheck, Gravity};
use crate::dataset::Dataset;
use crate::diagnosis::estimates::estimates_of;
use crate::diagnosis::input_hold::half_a_sample;
use crate::estimate::{Estimate, digits};
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::{LONGEST_DELAY, Problem};
use crate::model::baseline::Baseline;
use crate::optim::levenberg_marquardt::{Effort, minimize};

/// Enough from a minimum at which only the delay was held.
const EFFORT: Effort = Effort { iterations: 2, tolerance: 0.5 };
/// Distances in samples below which a delay is right.
const NEGLIGIBLE: f64 = 0.25;
/// Standard errors that a wrong delay lies away at least: one in 10⁴ by chance.
const CLEAR: f64 = 3.9;
/// Share of samples that repeat the one before, from which an input is a command in steps.
const STEPS: f64 = 0.5;
/// Difference of 2 ln likelihood from which one way between samples is preferred.
const PREFERRED: f64 = 10.0;
/// Share of the range searched from which on an interval says nothing.
const ALL_OF_IT: f64 = 0.9;
const DELAY: &str = "delay";
const EXTRA: &str = "extra_delay";

/// The delay: the model's against the data's. What other physics explains of a lag is left to it: the delay is asked
/// beside the effects that were found; where no model fixes it, it is the one that is `told`.
pub fn delay(problem: &Problem<'_>, fit: &Fit, told: &[Estimate]) -> DataCheck {
    let samples = |s: f64| format!("{:.2} samples", s / problem.sizes.step);
    let model = problem.baseline.plant.delay;
    if problem.data.is_smoothed() {
        let words = "the outputs were smoothed both ways in time, and may move before their cause by that";
        return DataCheck::cannot_tell(DELAY, words);
    }
    if problem.baseline.delay_free {
        let found = told.iter().find(|e| e.name == DELAY);
        // Within half a sample no stamp need be off.
        return match found {
            Some(found) if found.ci95[1] < -half_a_sample(problem) => DataCheck::found(
                DELAY,
                Gravity::Told,
                format!(
                    "the motion is stamped before the input that caused it: {} ({}); the stamps of one of them are off",
                    found,
                    samples(found.value)
                ),
            ),
            Some(found) if is_anything(problem, found) => DataCheck::cannot_tell(DELAY, anything(found)),
            Some(found) => DataCheck::ruled_out(
                DELAY,
                format!("no model fixes it: estimated, {} ({})", found, samples(found.value)),
            ),
            None => DataCheck::cannot_tell(DELAY, "it could not be estimated"),
        };
    }
    if let Some(own) = fit.range_of(problem, EXTRA) {
        let extra = fit.minimum.values[own.start];
        return DataCheck::found(
            DELAY,
            Gravity::Told,
            format!(
                "the data want {} s ({}), the model has {} s ({}): named as {EXTRA}",
                digits(model + extra),
                samples(model + extra),
                digits(model),
                samples(model)
            ),
        );
    }
    let baseline = Baseline { delay_free: true, ..problem.baseline.clone() };
    let free = Problem::new(problem.data, &baseline, &[]);
    let Some(found) = with_delay(&free, fit, model) else {
        return DataCheck::cannot_tell(DELAY, "no finite likelihood with another delay");
    };
    let Some(wanted) = estimates_of(&free, &found).into_iter().find(|e| e.name == DELAY) else {
        return DataCheck::cannot_tell(DELAY, "it could not be estimated");
    };
    if is_anything(&free, &wanted) {
        return DataCheck::cannot_tell(
            DELAY,
            format!("{}; the model has {} s", anything(&wanted), digits(model)),
        );
    }
    let error = (wanted.ci95[1] - wanted.ci95[0]) / 3.92;
    let described = format!(
        "the data want {} ({}), the model has {} s ({})",
        wanted,
        samples(wanted.value),
        digits(model),
        samples(model)
    );
    let (off, negligible) = ((wanted.value - model).abs(), NEGLIGIBLE * problem.sizes.step);
    if off < negligible && error < negligible {
        DataCheck::ruled_out(DELAY, described)
    } else if off > negligible && off > CLEAR * error {
        DataCheck::found(DELAY, Gravity::Told, described)
    } else {
        DataCheck::cannot_tell(DELAY, described)
    }
}

/// Whether a delay's interval is that of the search.
fn is_anything(problem: &Problem<'_>, delay: &Estimate) -> bool {
    delay.ci95[1] - delay.ci95[0] > ALL_OF_IT * (LONGEST_DELAY - problem.earliest())
}

fn anything(delay: &Estimate) -> String {
    let [from, to] = delay.ci95.map(digits);
    format!("any from {from} to {to} s goes with the data")
}

/// `fit` of a problem whose delay was held, with the delay free from `start` on.
fn with_delay(free: &Problem<'_>, fit: &Fit, start: f64) -> Option<Fit> {
    let mut values = fit.minimum.values.clone();
    values.insert(2, start);
    let residuals = free.prediction_errors(&fit.effects);
    let minimum = minimize(&residuals, free.channels(), &free.coordinates(&fit.effects), &values, EFFORT)?;
    Some(Fit { effects: fit.effects.clone(), minimum })
}

/// Whether the input is held or straight between samples.
pub fn hold(problem: &Problem<'_>, fit: &Fit) -> DataCheck {
    const CAUSE: &str = "input_hold";
    let data = problem.data;
    if data.thinned > 1 {
        let averaged = format!("{} samples were averaged into one", data.thinned);
        return if data.runs.iter().all(|run| run.known_between().is_some()) {
            DataCheck::ruled_out(CAUSE, averaged + ", with the input between as it was logged")
        } else {
            DataCheck::cannot_tell(CAUSE, averaged + ": what the input does between samples is not seen")
        };
    }
    let held = data.runs.iter().all(|run| run.held);
    let share = repeated(problem);
    if share > STEPS {
        let described =
            format!("the input keeps its value in {:.0} % of the samples: a command in steps", 100.0 * share);
        return if held {
            DataCheck::ruled_out(CAUSE, described)
        } else {
            let words = format!("{described}, read as interpolated; leave out --input interpolated");
            DataCheck::found(CAUSE, Gravity::Told, words)
        };
    }
    let Some(gain) = gain_by_other_hold(problem, fit, held) else {
        return DataCheck::cannot_tell(CAUSE, "no finite likelihood with the other way");
    };
    let (now, other) = if held { ("held", "interpolated") } else { ("interpolated", "held") };
    let described =
        format!("2 ln likelihood of {other} against {now} between samples, the delay free: {gain:+.1}");
    if gain < -PREFERRED {
        DataCheck::ruled_out(CAUSE, described)
    } else if gain > PREFERRED {
        DataCheck::found(CAUSE, Gravity::Told, format!("{described}; read it with --input {other}"))
    } else {
        DataCheck::cannot_tell(CAUSE, format!("{described} (half a sample of delay is all they differ by)"))
    }
}

/// Share of the counted samples in which the input is what it was a sample before.
fn repeated(problem: &Problem<'_>) -> f64 {
    let (mut same, mut all) = (0usize, 0usize);
    for (run, counted) in problem.data.runs.iter().zip(&problem.counted) {
        for k in (1..run.len()).filter(|&k| counted[k]) {
            all += 1;
            same += usize::from(run.u[k] == run.u[k - 1]);
        }
    }
    same as f64 / all.max(1) as f64
}

/// What 2 ln likelihood gains when the input is taken the other way between samples.
fn gain_by_other_hold(problem: &Problem<'_>, fit: &Fit, held: bool) -> Option<f64> {
    let mut turned: Dataset = problem.data.clone();
    for run in &mut turned.runs {
        run.held = !held;
    }
    let baseline = Baseline { delay_free: true, ..problem.baseline.clone() };
    let mut fixed = fit.clone();
    let delay = if problem.baseline.delay_free {
        fixed.minimum.values.remove(2)
    } else {
        problem.baseline.plant.delay
    };
    let later = if held { 0.5 } else { -0.5 } * problem.sizes.step;
    let criterion = |data: &Dataset, delay: f64| {
        let free = Problem::new(data, &baseline, &[]);
        Some(with_delay(&free, &fixed, delay)?.criterion())
    };
    let (now, other) = rayon::join(
        || criterion(problem.data, delay),
        || criterion(&turned, (delay + later).max(problem.earliest())),
    );
    Some(now? - other?)
}
