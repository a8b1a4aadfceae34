//! An input that was averaged to fewer rows, with what it does between them.
//!
//! The mean of a switching input over a row changes anywhere between the rows' middles. A straight line from row to row rounds that
//! off, and after every switch a rate computed from it is wrong for one row by up to an eighth of what it gains within a row, which
//! a sensor with little noise shows.

use core::ops::Range;
use std::sync::Arc;

/// The mean of an input over the time of a row, at every sample that it had before it was averaged. The outputs are sampled, and a
/// row's is their mean by the trapezoidal rule; linear dynamics lead to that mean from the same mean of the input, wherever between
/// the samples that switches:
///
/// ```text
/// ū(t) = Σ_j w_j u(t + (j − n/2) h),    w_0 = w_n = 1/2n, w_j = 1/n,    n samples of h s in a row
/// ```
///
/// That of a held input is held from sample to sample, that of an interpolated one goes in straight lines.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingMean {
    /// n.
    per_row: usize,
    /// ū, its first node at the first row.
    mean: Arc<Track>,
    /// The input itself, its first node half a row before.
    input: Arc<Track>,
}

/// A signal by its nodes, one a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Whether it is held between its nodes.
    held: bool,
    nodes: Vec<f64>,
    /// Its integral from the first node to each, in samples.
    integral: Vec<f64>,
}

impl MovingMean {
    /// Of an input of more than `per_row` samples (fewer make no row), held over each or interpolated between them.
    #[must_use]
    pub fn new(u: &[f64], per_row: usize, held: bool) -> Self {
        let n = per_row as f64;
        let mean = |u: &[f64]| (u.iter().sum::<f64>() - 0.5 * (u[0] + u[per_row])) / n;
        let mean = Track::new(u.windows(per_row + 1).map(mean).collect(), held);
        Self { per_row, mean: Arc::new(mean), input: Arc::new(Track::new(u.to_vec(), held)) }
    }

    /// The same of the rows `rows` alone.
    #[must_use]
    pub fn cut(&self, rows: Range<usize>) -> Self {
        let [first, last] = [rows.start, rows.end].map(|row| row * self.per_row);
        let of = |track: &Track, last: usize| {
            Arc::new(Track::new(track.nodes[first..last.min(track.nodes.len())].to_vec(), track.held))
        };
        Self {
            per_row: self.per_row,
            mean: of(&self.mean, last),
            input: of(&self.input, last + self.per_row),
        }
    }

    /// The same of an input that is less by `level`.
    #[must_use]
    pub fn less(&self, level: f64) -> Self {
        let of =
            |track: &Track| Arc::new(Track::new(track.nodes.iter().map(|u| u - level).collect(), track.held));
        Self { per_row: self.per_row, mean: of(&self.mean), input: of(&self.input) }
    }

    /// ū at two places, and its mean between them. A place is a row, and a share of the time to the next; before the first node
    /// and after the last ū is as it is there.
    #[must_use]
    pub fn between(&self, places: [(isize, f64); 2]) -> ([f64; 2], f64) {
        self.mean.between(places.map(|place| self.samples(place)))
    }

    /// The same of the input itself.
    #[must_use]
    pub fn input_between(&self, places: [(isize, f64); 2]) -> ([f64; 2], f64) {
        let half = 0.5 * self.per_row as f64;
        self.input.between(places.map(|place| self.samples(place) + half))
    }

    /// n.
    #[must_use]
    pub fn per_row(&self) -> usize {
        self.per_row
    }

    /// Samples from the first row to a place.
    fn samples(&self, (row, share): (isize, f64)) -> f64 {
        (row as f64 + share) * self.per_row as f64
    }
}

impl Track {
    /// Of nodes; whether it is held between them, or straight.
    #[must_use]
    pub fn new(nodes: Vec<f64>, held: bool) -> Self {
        let mut integral = vec![0.0; nodes.len()];
        for k in 1..nodes.len() {
            let end = if held { nodes[k - 1] } else { nodes[k] };
            integral[k] = integral[k - 1] + 0.5 * (nodes[k - 1] + end);
        }
        Self { held, nodes, integral }
    }

    /// Its values at two places, in samples from the first node, and its mean between them.
    #[must_use]
    pub fn between(&self, places: [f64; 2]) -> ([f64; 2], f64) {
        let [from, to] = places.map(|place| self.reach(place));
        ([from.0, to.0], (to.1 - from.1) / (places[1] - places[0]))
    }

    /// The mean between two places of its mean over `width` samples about each, where it is held: that is straight from node to node
    /// for a whole number of samples.
    #[must_use]
    pub fn mean_of_means(&self, [from, to]: [f64; 2], width: usize) -> f64 {
        let half = 0.5 * width as f64;
        let mean = |place: f64| self.between([place - half, place + half]).1;
        let (mut at, mut value, mut sum) = (from, mean(from), 0.0);
        while at < to {
            let next = ((at + half).floor() + 1.0 - half).min(to);
            let there = mean(next);
            sum += 0.5 * (value + there) * (next - at);
            (at, value) = (next, there);
        }
        sum / (to - from)
    }

    /// Its value and its integral at a place.
    fn reach(&self, place: f64) -> (f64, f64) {
        if place < 0.0 {
            return (self.nodes[0], self.nodes[0] * place);
        }
        let last = self.nodes.len() - 1;
        let k = (place as usize).min(last);
        let beyond = place - k as f64;
        let slope = if self.held || k == last { 0.0 } else { self.nodes[k + 1] - self.nodes[k] };
        let value = self.nodes[k] + slope * beyond;
        (value, self.integral[k] + 0.5 * (self.nodes[k] + value) * beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// ū in the middle of each row.
    fn rows(mean: &MovingMean) -> Vec<f64> {
        mean.mean.nodes.iter().step_by(mean.per_row).copied().collect()
    }

    /// The held input `x` samples after its start.
    fn at(u: &[f64], x: f64) -> f64 {
        u[x as usize]
    }

    proptest! {
        #[test]
        fn the_mean_of_a_held_input_is_exact_anywhere(
            u in prop::collection::vec(-1.0_f64..1.0, 40..60), per_row in 2_usize..7, row in 1_isize..4, begin in 0.0_f64..1.0,
            length in 0.05_f64..1.0,
        ) {
            let mean = MovingMean::new(&u, per_row, true);
            let n = per_row as f64;
            let end = begin + length;
            let places = [(row, begin), (row + end.floor() as isize, end.fract())];
            let ([at_begin, _], between) = mean.between(places);
            // over the samples of the row whose middle lies there
            let direct = |place: f64| {
                let from = (row as f64 + place) * n;
                let ends = 0.5 * (at(&u, from) + at(&u, from + n));
                (ends + (1..per_row).map(|j| at(&u, from + j as f64)).sum::<f64>()) / n
            };
            prop_assert!((at_begin - direct(begin)).abs() < 1e-12);
            let steps = 20_000;
            let sum: f64 = (0..steps).map(|i| direct(begin + length * (f64::from(i) + 0.5) / f64::from(steps))).sum();
            prop_assert!((between - sum / f64::from(steps)).abs() < 5e-3);
        }
    }

    #[test]
    fn rows_are_the_means_and_a_part_is_the_same_where_it_lies() {
        let u: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        let mean = MovingMean::new(&u, 4, true);
        assert_eq!(rows(&mean)[3], (0.5 * u[12] + u[13] + u[14] + u[15] + 0.5 * u[16]) / 4.0);
        let part = mean.cut(3..7);
        assert_eq!(rows(&part), rows(&mean)[3..7]);
        let (there, here) = (mean.between([(4, 0.3), (5, 0.2)]), part.between([(1, 0.3), (2, 0.2)]));
        assert_eq!(there.0, here.0);
        assert!((there.1 - here.1).abs() < 1e-12);
        assert!((mean.less(2.0).between([(4, 0.3), (5, 0.2)]).1 - (there.1 - 2.0)).abs() < 1e-12);
    }

    #[test]
    fn the_input_itself_is_known_between_the_rows() {
        let u: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        let mean = MovingMean::new(&u, 4, true);
        // row 3 stands in the middle of samples 12 to 15
        let (ends, between) = mean.input_between([(3, 0.0), (3, 0.5)]);
        assert_eq!((ends, between), ([u[14], u[16]], 0.5 * (u[14] + u[15])));
        assert_eq!(mean.cut(2..6).input_between([(1, 0.0), (1, 0.5)]), (ends, between));
        assert_eq!(mean.less(2.0).input_between([(3, 0.0), (3, 0.5)]).1, between - 2.0);
    }

    #[test]
    fn the_mean_over_a_row_of_what_follows_the_input_is_that_of_the_input_where_it_is_the_same() {
        let u: Vec<f64> = (0..40).map(|k| f64::from(k * k % 17)).collect();
        for per_row in [1, 2, 3, 4] {
            let (mean, same) = (MovingMean::new(&u, per_row, true), Track::new(u.clone(), true));
            for begins in [2.0, 2.3, 2.71] {
                let places = [begins, begins + 0.5].map(|row: f64| (row.floor() as isize, row.fract()));
                let at = [begins, begins + 0.5].map(|row| (row + 0.5) * per_row as f64);
                // the input's mean is known at its samples, and held between them
                let fine = (0..2000).map(|i| {
                    let middle = at[0] + (at[1] - at[0]) * (f64::from(i) + 0.5) / 2000.0;
                    let half = 0.5 * per_row as f64;
                    same.between([middle - half, middle + half]).1
                });
                assert!((same.mean_of_means(at, per_row) - fine.sum::<f64>() / 2000.0).abs() < 1e-3);
                assert!((mean.between(places).1 - same.mean_of_means(at, per_row)).abs() < 6.0);
            }
        }
    }

    #[test]
    fn less_than_a_row_makes_none() {
        for held in [true, false] {
            assert!(MovingMean::new(&[1.0, 2.0], 5, held).mean.nodes.is_empty());
        }
    }

    #[test]
    fn outside_it_is_as_at_the_ends() {
        let u = [1.0, 1.0, 2.0, 3.0, 5.0, 5.0];
        for held in [true, false] {
            let mean = MovingMean::new(&u, 2, held);
            let last = mean.mean.nodes[mean.mean.nodes.len() - 1];
            let (before, after) = (mean.between([(-3, 0.4), (-2, 0.9)]), mean.between([(7, 0.4), (9, 0.0)]));
            assert_eq!((before.0, after.0), ([mean.mean.nodes[0]; 2], [last; 2]));
            assert!((before.1 - mean.mean.nodes[0]).abs() < 1e-12 && (after.1 - last).abs() < 1e-12);
        }
    }
}
