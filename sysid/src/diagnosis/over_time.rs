//! The residual moment over time, before and after: for effects that live in a window of time or begin at a moment.

use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;

/// What a diagnosis shows over time.
#[derive(Clone, Debug, Default)]
pub struct OverTime {
    /// Whether what was found is an effect of the time.
    pub of_time: bool,
    /// The residual moment, run by run.
    pub runs: Vec<ResidualMoment>,
}

/// The moment of one run that a model does not explain: the predictor's filtered estimate of the disturbance.
#[derive(Clone, Debug)]
pub struct ResidualMoment {
    /// Index of the recording.
    pub recording: usize,
    /// Time since the start of the recording, s.
    pub t: Vec<f64>,
    /// With the baseline, N m.
    pub baseline: Vec<f64>,
    /// With the extended model, N m; `None` where nothing was added.
    pub extended: Option<Vec<f64>>,
}

/// The residual moment of every run from its first counted sample on; none where a predictor diverges.
pub fn residual_moments(problem: &Problem<'_>, baseline: &Fit, extended: &Fit) -> Vec<ResidualMoment> {
    let changed = !extended.effects.is_empty();
    let Some(before) = moments(problem, baseline) else { return Vec::new() };
    let after = if changed { moments(problem, extended) } else { None };
    let mut after = after.map(Vec::into_iter);
    let runs = problem.data.runs.iter().zip(before).enumerate();
    runs.map(|(index, (run, baseline))| {
        let first = settled(problem, index);
        ResidualMoment {
            recording: run.recording,
            t: (first..run.len()).map(|k| run.time(k)).collect(),
            baseline,
            extended: after.as_mut().and_then(Iterator::next),
        }
    })
    .collect()
}

/// The first row of a run that is counted: before it the predictor settles.
fn settled(problem: &Problem<'_>, run: usize) -> usize {
    let counted = &problem.counted[run];
    counted.iter().position(|counted| *counted).unwrap_or(counted.len())
}

fn moments(problem: &Problem<'_>, fit: &Fit) -> Option<Vec<Vec<f64>>> {
    let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
    let mut all = vec![Vec::new(); problem.data.runs.len()];
    let visit = |run: usize, k: usize, point: &crate::model::pitch::Point| {
        if k >= settled(problem, run) {
            all[run].push(unpacked.disturbance.moment(&point.x));
        }
    };
    problem.track(&unpacked, visit, &mut |_, _| {})?;
    Some(all)
}

#[cfg(test)]
mod tests;
