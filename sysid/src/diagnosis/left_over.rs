//! What the models leave of each measurement, predicted one step ahead, and its correlations.

use super::adequacy::left::{white, whitening};
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::pitch::Output;
use crate::validate::cross_correlation::{CrossCorrelation, cross_correlation};
use crate::validate::whiteness::{Whiteness, whiteness};

/// Lags of the correlations reach this far, s, and are at most so many.
const REACH_S: f64 = 2.0;
const MOST_LAGS: usize = 120;
/// What is left before, and after where something was added.
#[derive(Clone, Debug)]
pub struct LeftOver {
    /// By the baseline.
    pub before: OneStep,
    /// By the extended model.
    pub after: Option<OneStep>,
    /// Sample period, s.
    pub step: f64,
}

/// The errors of predictions one step ahead, made white by the covariance of the last model's.
#[derive(Clone, Debug)]
pub struct OneStep {
    /// Their correlation with themselves.
    pub own: Whiteness,
    /// Their correlation with the input.
    pub with_input: CrossCorrelation,
}

/// What `baseline` and `extended` leave; `None` where a fit has no errors.
pub fn left_over(problem: &Problem<'_>, baseline: &Fit, extended: &Fit) -> Option<LeftOver> {
    let scale = whitening(&extended.minimum.residuals);
    let of = |fit: &Fit| one_step(problem, fit, &scale);
    let changed = !extended.effects.is_empty();
    let step = reading_step(problem)?;
    let before = of(baseline)?;
    Some(LeftOver { before, after: if changed { Some(of(extended)?) } else { None }, step })
}

/// Time from one reading to the next, s.
fn reading_step(problem: &Problem<'_>) -> Option<f64> {
    problem.data.runs.first().map(|run| run.measured_every() as f64 * run.step)
}

fn one_step(problem: &Problem<'_>, fit: &Fit, scale: &[f64; 3]) -> Option<OneStep> {
    let errors: Vec<Output> = fit.minimum.residuals.iter().map(|e| white(scale, e)).collect();
    if errors.len() < 32 {
        return None;
    }
    let step = reading_step(problem)?;
    let first: Vec<f64> = errors.iter().map(|e| e[0]).collect();
    let input: Vec<f64> = problem.counted_rows().map(|(run, k)| problem.data.runs[run].u[k]).collect();
    let lags = ((REACH_S / step) as usize).min(MOST_LAGS);
    Some(OneStep { own: whiteness(&first, lags), with_input: cross_correlation(&input, &first, lags) })
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{asked, effects, extended, flight_with};
    use super::*;

    #[test]
    fn only_a_right_model_leaves_nothing_of_the_input() {
        let flown = flight_with(1, |_, _, theta| -3.0 * theta.sin());
        asked(&flown, |problem, baseline| {
            let after = extended(problem, baseline, &effects(&["gravity_stiffness"]));
            let left = left_over(problem, baseline, &after).unwrap();
            let rest = left.after.unwrap();
            assert!(rest.with_input.independent && rest.own.white, "{:?}", rest.own.p_value);
            assert!(!left.before.with_input.independent);
            assert_eq!(
                (rest.own.correlation.len(), rest.with_input.correlation.len()),
                (100, 101),
                "2 s of 0.02 s"
            );
            assert!(left_over(problem, baseline, baseline).unwrap().after.is_none());
        });
    }
}
