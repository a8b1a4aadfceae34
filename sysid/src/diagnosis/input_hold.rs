//! What the input does between two rows, where it is another one in each: held, or straight, or the answer of a controller that is
//! faster than the log. A lag or a delay within half a row is that as well, and no finding; no more is a lag, a slew or a mode beside a total delay
//! that has the motion come before its cause: the two together make another shape, of something else.

use crate::dataset::Run;
use crate::likelihood::problem::Problem;
use crate::model::effect::{Class, Effect, Picture};

/// Rows for which an input that is made in steps keeps a value at least, in the mean.
const STEPS: usize = 2;

/// Whether `effect` with the values `p`, beside a total delay of `delay` s, turns the phase by no more than what is not known of the
/// input.
pub fn is_of_the_hold(problem: &Problem<'_>, effect: &dyn Effect, p: &[f64], delay: f64) -> bool {
    let is_early = |by: f64| problem.baseline.delay_free && delay < -by;
    if effect.class() != Some(Class::Phase) {
        return shapes_the_answer(effect) && is_early(0.5 * problem.sizes.step);
    }
    if is_early(half_a_sample(problem)) {
        return true;
    }
    let known = |run: &Run| run.known_between().is_some() || run.holds_longer_than(STEPS);
    if problem.data.runs.iter().all(known) {
        return false;
    }
    let parameters = effect.parameters(&problem.sizes);
    let mut times = parameters.iter().zip(p).filter(|(parameter, _)| parameter.unit == "s").peekable();
    times.peek().is_some() && times.all(|(_, time)| time.abs() < 0.5 * problem.sizes.step)
}

/// Whether `effect` shapes the answer to a step of the input, as a lag, a slew or a mode does. So does an output that was smoothed both
/// ways in time, which is early and late at once.
pub fn shapes_the_answer(effect: &dyn Effect) -> bool {
    matches!(effect.class(), Some(Class::Phase | Class::Resonance))
        || effect.picture() == Some(Picture::StepResponse)
}

/// Half of a step of the log, s: what stands between an input that is held and one that is straight.
pub fn half_a_sample(problem: &Problem<'_>) -> f64 {
    0.5 * problem.sizes.step / problem.data.thinned as f64
}

#[cfg(test)]
mod tests {
    use super::super::data_checks::fixture::flight;
    use super::super::fixture::{asked, flown_by};
    use super::*;
    use crate::catalogue::find;
    use crate::model::baseline::Baseline;

    #[test]
    fn a_lag_within_half_a_row_is_of_the_hold_where_every_row_has_another_input() {
        let [lag, friction] = ["servo_lag", "coulomb_friction"].map(|id| find(id).unwrap());
        let sines = (0..flight(1, 0.0).u.len()).map(|k| (0.31 * k as f64).sin() * 0.01).collect();
        asked(&flown_by(1, sines, |_, _, _| 0.0), |problem, _| {
            let step = problem.sizes.step;
            assert!(is_of_the_hold(problem, lag, &[0.4 * step], 0.01));
            assert!(!is_of_the_hold(problem, lag, &[0.6 * step], 0.01));
            assert!(!is_of_the_hold(problem, friction, &[0.4 * step], 0.01));
        });
        asked(&flight(1, 0.0), |problem, _| {
            assert!(!is_of_the_hold(problem, lag, &[0.001], 0.01));
            let baseline = Baseline { delay_free: true, ..problem.baseline.clone() };
            let free = Problem::new(problem.data, &baseline, &[]);
            assert!(is_of_the_hold(&free, lag, &[0.05], -problem.sizes.step));
            for id in ["servo_second_order", "servo_rate_limit", "imu_mount", "structural_mode"] {
                let effect = find(id).unwrap();
                assert!(is_of_the_hold(
                    &free,
                    effect,
                    &effect.starts(&problem.sizes)[0],
                    -problem.sizes.step
                ));
            }
            assert!(
                !is_of_the_hold(&free, lag, &[0.05], 0.01) && !is_of_the_hold(&free, friction, &[0.05], -1.0)
            );
        });
    }
}
