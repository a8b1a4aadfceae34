//! A constant moment that comes, stays and may go.

use crate::dataset::Amplitudes;
use crate::model::effect::{
    About, Conditions, Effect, Locus, Parameter, Picture, ResidualMoment, Scale, Signal,
};

/// M += M0 from t0 to t1: a load that is put down, a contact, a cable that catches; t1 beyond the end where it stays.
pub struct MomentStep;

/// Parts into which the time is cut to look for the window.
const PARTS: usize = 60;
/// Where a window that never closes ends, as a share of the data's length.
const NEVER: f64 = 1.5;

impl Effect for MomentStep {
    fn about(&self) -> About {
        About {
            id: "moment_step",
            locus: Locus::PitchMoment,
            sentence: "a constant moment sets in at one moment and may go at another",
            equation: "M += M0 from t0 to t1",
            variable: "t",
            condition: "from one moment to another",
        }
    }
    fn picture(&self) -> Option<Picture> {
        Some(Picture::Moment(Signal::Time))
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        let (reach, duration) = (5.0 * data.moment, data.duration);
        let time = |name, upper| Parameter {
            name,
            unit: "s",
            lower: 0.0,
            upper,
            scale: Scale::Linear(0.05 * duration),
        };
        vec![
            Parameter {
                name: "M0",
                unit: "N m",
                lower: -reach,
                upper: reach,
                scale: Scale::Linear(0.1 * data.moment),
            },
            time("t0", duration),
            time("t1", 2.0 * duration),
        ]
    }
    fn starts(&self, data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.35, 0.65].map(|share| vec![0.0, share * data.duration, NEVER * data.duration]).to_vec()
    }
    /// The window in which the moment that is left differs most from that outside, and that from one moment on; with one
    /// more of either at half the length of the data.
    fn starts_from(&self, data: &Amplitudes, left: &ResidualMoment) -> Vec<Vec<f64>> {
        let mut starts = self.starts(data);
        let windows = windows(left).into_iter();
        starts.extend(windows.map(|(mean, from, to)| vec![mean, from, to.unwrap_or(NEVER * data.duration)]));
        starts
    }
    fn begins_at(&self) -> Option<usize> {
        Some(1)
    }
    fn ends_at(&self) -> Option<usize> {
        Some(2)
    }
    fn beyond_data(&self, p: &[f64], data: &Amplitudes) -> Option<usize> {
        (p[2] > data.duration).then_some(2)
    }
    fn forcing(&self, p: &[f64], at: &Conditions) -> f64 {
        // The share of the step within the window, so that the likelihood moves smoothly with its ends.
        let within = (at.t + at.dt).min(p[2]) - at.t.max(p[1]);
        p[0] * (within / at.dt).clamp(0.0, 1.0)
    }
}

/// Mean moment against that outside, begin and end of two windows: the one that stands out most, and that of those which
/// last to the end and have none. The variance between means (Sen and Srivastava, Annals of Statistics 3, 1975) counts, over
/// whole parts at first; then the ends of the best are moved row by row, up to a part away.
fn windows(left: &ResidualMoment) -> Vec<(f64, f64, Option<f64>)> {
    let rows = left.moment.len();
    let part = rows.div_ceil(PARTS).max(1);
    let mut up_to = vec![0.0];
    up_to.extend(left.moment.iter().scan(0.0, |sum, moment| {
        *sum += moment;
        Some(*sum)
    }));
    let mean = |(from, to): (usize, usize)| {
        let (inside, outside) = ((to - from) as f64, (rows - (to - from)) as f64);
        let sum = up_to[to] - up_to[from];
        sum / inside - (up_to[rows] - sum) / outside
    };
    let between = |&(from, to): &(usize, usize)| {
        let inside = (to - from) as f64;
        mean((from, to)).powi(2) * inside * (rows as f64 - inside)
    };
    let best = |ends: &mut dyn Iterator<Item = (usize, usize)>| {
        ends.filter(|(from, to)| from < to && to - from < rows)
            .max_by(|a, b| between(a).total_cmp(&between(b)))
    };
    let near = |row: usize| row.saturating_sub(part).max(1)..=(row + part).min(rows);
    let parts = 1..rows.div_ceil(part);
    let mut within = parts.clone().flat_map(|to| (1..to).map(move |from| (from * part, to * part)));
    let mut to_end = parts.map(|from| (from * part, rows));
    let found = [best(&mut within), best(&mut to_end)].into_iter().flatten();
    let moved = found.filter_map(|(from, to)| {
        let (from, to) = best(&mut near(from).map(|from| (from, to)))?;
        if to == rows { Some((from, to)) } else { best(&mut near(to).map(|to| (from, to))) }
    });
    let time = |row: usize| left.start + left.step * row as f64;
    moved.map(|(from, to)| (mean((from, to)), time(from), (to < rows).then(|| time(to)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_acts_within_its_window_by_the_share_of_the_step() {
        let at = |t: f64| {
            MomentStep.forcing(&[0.2, 1.004, 2.0], &Conditions { t, dt: 0.01, ..Conditions::default() })
        };
        assert_eq!([at(0.5), at(1.01), at(1.99), at(2.0), at(7.0)], [0.0, 0.2, 0.2, 0.0, 0.0]);
        assert!((at(1.0) - 0.2 * 0.6).abs() < 1e-12);
        assert_eq!(
            MomentStep.forcing(&[0.2, 2.0, 1.0], &Conditions { t: 1.5, dt: 0.01, ..Conditions::default() }),
            0.0
        );
    }

    #[test]
    fn a_window_is_seen_in_what_is_left_and_one_that_stays_as_well() {
        let data = Amplitudes { moment: 0.3, step: 0.02, duration: 61.74, ..Amplitudes::default() };
        let left = |to: i32| {
            let moment = (0..3037).map(|k| if (1000..to).contains(&k) { 0.1 } else { 0.02 });
            // the last part is shorter than the others
            ResidualMoment { start: 1.0, step: 0.02, moment: moment.collect(), angle: Vec::new() }
        };
        let near =
            |start: &[f64], expected: [f64; 3]| start.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near(&MomentStep.starts_from(&data, &left(1500))[2], [0.08, 21.0, 31.0]));
        assert!(near(&MomentStep.starts_from(&data, &left(9999))[3], [0.08, 21.0, 92.61]));
        assert_eq!(MomentStep.starts_from(&data, &ResidualMoment::default()).len(), 2);
    }
}
