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
        starts.extend(windows(left).map(|[mean, from, to]| vec![mean, from, to]));
        for start in starts.iter_mut().skip(2).filter(|start| start[2] >= data.duration - data.step) {
            start[2] = NEVER * data.duration;
        }
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
/// last to the end. The variance between means (Sen and Srivastava, Annals of Statistics 3, 1975) counts.
fn windows(left: &ResidualMoment) -> impl Iterator<Item = [f64; 3]> {
    let length = left.moment.len().div_ceil(PARTS).max(1);
    let sums: Vec<f64> = left.moment.chunks_exact(length).map(|part| part.iter().sum()).collect();
    let parts = sums.len();
    let mut up_to = vec![0.0];
    up_to.extend(sums.iter().scan(0.0, |sum, part| {
        *sum += part;
        Some(*sum)
    }));
    let time = |part: usize| left.start + left.step * (part * length) as f64;
    let window = |(from, to): (usize, usize)| {
        let inside = ((to - from) * length) as f64;
        let outside = (parts * length) as f64 - inside;
        let sum = up_to[to] - up_to[from];
        let mean = sum / inside - (up_to[parts] - sum) / outside;
        (mean * mean * inside * outside, [mean, time(from), time(to)])
    };
    let largest = |ends: std::ops::RangeInclusive<usize>| {
        let all = ends.flat_map(|to| (1..to).map(move |from| (from, to)));
        all.map(window).max_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
    };
    largest(2..=parts.saturating_sub(1)).into_iter().chain(largest(parts..=parts))
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
        let data = Amplitudes { moment: 0.3, step: 0.02, duration: 61.0, ..Amplitudes::default() };
        let left = |to: f64| {
            let moment =
                (0..3000).map(|k| if (20.0..to).contains(&(0.02 * f64::from(k))) { 0.1 } else { 0.02 });
            ResidualMoment { start: 1.0, step: 0.02, moment: moment.collect() }
        };
        let near =
            |start: &[f64], expected: [f64; 3]| start.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near(&MomentStep.starts_from(&data, &left(30.0))[2], [0.08, 21.0, 31.0]));
        assert!(near(&MomentStep.starts_from(&data, &left(99.0))[3], [0.08, 21.0, 91.5]));
        assert_eq!(MomentStep.starts_from(&data, &ResidualMoment::default()).len(), 2);
    }
}
