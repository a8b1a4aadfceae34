//! From which row on a run counts.

use crate::dataset::{Amplitudes, Run};

/// Time after the start of a run that the predictor takes to settle, s.
const SETTLING: f64 = 1.0;
/// Motion before the input first moves, as a share of the signal's size, of a run that begins at rest;
const AT_REST: f64 = 0.1;
/// and the least time for which it has to last, s.
const RESTING: f64 = 0.15;

/// The first row of `run` that counts, with signals of these `sizes`: where the predictor has settled, or the input first moves of what
/// has been at rest.
pub fn first_counted(run: &Run, sizes: &Amplitudes) -> usize {
    let settled = ((SETTLING / run.step).ceil() as usize).min(run.len() / 4);
    rests_until(run, sizes).map_or(settled, |moved| settled.min(moved))
}

/// The row of `run` at which its input first moves, where nothing else has moved before: the predictor is where the axis is, and
/// what a step within the first second tells is not lost. Asked of the beginning of a recording alone: a hold of the input
/// after a gap may be one of many.
fn rests_until(run: &Run, sizes: &Amplitudes) -> Option<usize> {
    let moved = run.u.iter().position(|&u| u != run.u[0])?;
    let rested = (RESTING / run.step).ceil() as usize;
    if run.start > run.origin + run.step || moved < rested.max(2) {
        return None;
    }
    let keeps = |signal: &[f64], size: f64| {
        signal[..moved].iter().all(|value| (value - signal[0]).abs() < AT_REST * size)
    };
    let angle = run.angle_or_sum();
    let drifted = (angle[moved - 1] - angle[0]) / ((moved - 1) as f64 * run.step);
    let rests = drifted.abs() < AT_REST * sizes.q
        && run.rate.as_deref().is_none_or(|rate| keeps(rate, sizes.q))
        && run.angle.as_deref().is_none_or(|angle| keeps(angle, sizes.theta));
    rests.then_some(moved)
}

#[cfg(test)]
mod tests {
    use crate::diagnosis::data_checks::fixture::{GAIN, fitted, flight, model};
    use crate::recording::Recording;

    /// The first row that counts of the test flight with its first `rows` at a zero input, the rate and the angle by `moved` of the row;
    /// with its angle alone too.
    fn counts_from(rows: usize, moved: impl Fn(usize) -> [f64; 2]) -> [usize; 2] {
        let mut flown = flight(1, 0.0);
        flown.u[..rows].fill(0.0);
        for k in 0..rows {
            [flown.q[k], flown.theta[k]] = moved(k);
        }
        let mut recording = flown.recording();
        let first = |recording: &Recording| {
            fitted(recording, &model(GAIN, 0.06), |_, problem, _| problem.counted[0].iter().position(|c| *c))
        };
        let both = first(&recording);
        recording.q = None;
        [both.unwrap(), first(&recording).unwrap()]
    }

    #[test]
    fn the_first_second_counts_from_where_the_input_moves_if_nothing_has_moved_before() {
        const SECOND: usize = 50;
        assert_eq!(counts_from(25, |_| [0.0, 0.1]), [25, 25], "at rest");
        assert_eq!(counts_from(60, |_| [0.0, 0.0]), [SECOND, SECOND], "for longer than a second");
        assert_eq!(counts_from(0, |_| [0.0, 0.0]), [SECOND, SECOND], "in the middle of an excitation");
        assert_eq!(counts_from(25, |k| [0.5, 0.01 * k as f64]), [SECOND, SECOND], "turning");
        let swings = |k: usize| (0.5 * k as f64).sin();
        assert_eq!(counts_from(25, |k| [0.5 * swings(k), 0.1 * swings(k)]), [SECOND, SECOND], "swinging");
    }
}
