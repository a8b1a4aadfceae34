//! The input, delayed by any share of a sample.

use crate::dataset::Run;

/// Where the delayed input of one substep stands, relative to the row at hand.
#[derive(Clone, Copy)]
pub struct Shift {
    held: bool,
    rows: isize,
    /// Share of the later one of the two rows that meet there.
    share: f64,
    /// Row and share of the one after it that the input has at the beginning and at the end of the substep.
    ends: [(isize, f64); 2],
}

impl Shift {
    /// For substep `i` of `substeps`: the mean over the substep where the input is held, or known between the rows; its value in
    /// the middle where it is interpolated.
    pub fn new(delay: f64, i: usize, substeps: usize, step: f64, held: bool) -> Self {
        let length = 1.0 / substeps as f64;
        let begin = i as f64 * length - delay / step;
        let (from, share) = if held {
            // A hair's breadth forward, so that a delay of whole samples does not straddle two of them by rounding.
            let first = (begin + 1e-9).floor();
            (first, ((begin + length - first - 1.0) / length).max(0.0))
        } else {
            let middle = begin + 0.5 * length;
            (middle.floor(), middle - middle.floor())
        };
        let (rows, share) = (from as isize, if share <= 1e-9 { 0.0 } else { share });
        let ends = [begin, begin + length].map(|place| {
            // A switch at a boundary belongs to the substep that it begins.
            let row = (place - 1e-9).floor();
            (row as isize, if held { 0.0 } else { place - row })
        });
        Self { held, rows, share, ends }
    }

    /// The input of `run` over the substep; before its first row and after its last as it is there.
    pub fn mean(&self, run: &Run, k: usize) -> f64 {
        match run.known_between() {
            Some(mean) => mean.between(self.places(k as isize)).1,
            None => self.over(&run.u, k),
        }
    }

    /// The same at the beginning and at the end of the substep.
    pub fn at_ends(&self, run: &Run, k: usize) -> [f64; 2] {
        match run.known_between() {
            Some(mean) => mean.between(self.places(k as isize)).0,
            None => self.ends(&run.u, k),
        }
    }

    /// Where the substep of row `k` begins and ends in the input: row, and share of the time to the next.
    pub fn places(&self, k: isize) -> [(isize, f64); 2] {
        self.ends.map(|(rows, share)| (k + rows, share))
    }

    pub fn over(&self, u: &[f64], k: usize) -> f64 {
        self.between(u, k as isize + self.rows, self.share)
    }

    fn ends(&self, u: &[f64], k: usize) -> [f64; 2] {
        self.places(k as isize).map(|(row, share)| self.between(u, row, share))
    }

    /// `share` of the way from row `first` to the next.
    fn between(&self, u: &[f64], first: isize, share: f64) -> f64 {
        let at = if self.held { row } else { node };
        at(u, first) * (1.0 - share) + if share == 0.0 { 0.0 } else { at(u, first + 1) * share }
    }
}

/// Node of the polygon that stands for a smooth input in the band: straight lines between its rows weaken a tone of f (per
/// sample) by sinc² f, and these nodes, u − δ²u/12 + δ⁴u/90, strengthen it by as much, but for f⁶.
fn node(u: &[f64], i: isize) -> f64 {
    const SHARPENED: [f64; 3] = [1.0 + 1.0 / 6.0 + 6.0 / 90.0, -1.0 / 12.0 - 4.0 / 90.0, 1.0 / 90.0];
    let pair = |apart: isize| row(u, i - apart) + row(u, i + apart);
    SHARPENED[0] * row(u, i) + SHARPENED[1] * pair(1) + SHARPENED[2] * pair(2)
}

fn row(u: &[f64], i: isize) -> f64 {
    u[usize::try_from(i).unwrap_or(0).min(u.len() - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_changes_of_all_substeps_add_up_to_the_jump_and_fall_where_it_arrives() {
        let u: Vec<f64> = (0..40).map(|k| if k < 10 { 0.0 } else { 2.0 }).collect();
        for delay in [0.0, 0.02, 0.05, 0.061] {
            for held in [true, false] {
                let mut sum = 0.0;
                for k in 0..u.len() {
                    for i in 0..2 {
                        let [from, to] = Shift::new(delay, i, 2, 0.02, held).ends(&u, k);
                        let change = to - from;
                        let begin = 0.02 * k as f64 + 0.01 * i as f64;
                        let arrives = 0.2 + delay;
                        let near = if held {
                            begin <= arrives + 1e-9 && arrives < begin + 0.01 - 1e-9
                        } else {
                            (begin - arrives).abs() < 0.071
                        };
                        assert!(change == 0.0 || near, "{delay} {held} {begin}");
                        sum += change;
                    }
                }
                assert!((sum - 2.0).abs() < 1e-12, "{delay} {held} {sum}");
            }
        }
    }

    #[test]
    fn a_smooth_input_keeps_its_size_over_a_row() {
        // nine rows a period: straight lines between them weaken the tone by 4 %
        let tone = |k: f64| (std::f64::consts::TAU * k / 9.0).sin();
        let u: Vec<f64> = (0..60).map(|k| tone(f64::from(k))).collect();
        let polygon = |held: bool, k: usize| -> f64 {
            (0..8).map(|i| Shift::new(0.0, i, 8, 1.0, held).over(&u, k)).sum::<f64>() / 8.0
        };
        let gain = |held: bool| {
            let exact = |k: usize| {
                (0..512).map(|i| tone(k as f64 + (f64::from(i) + 0.5) / 512.0)).sum::<f64>() / 512.0
            };
            let rows = 10..46;
            rows.clone().map(|k| polygon(held, k) * exact(k)).sum::<f64>()
                / rows.map(|k| exact(k).powi(2)).sum::<f64>()
        };
        assert!((gain(false) - 1.0).abs() < 2e-3, "{}", gain(false));
        assert!((gain(true) - 1.0).abs() > 0.03, "a held input is late: {}", gain(true));
    }
}
