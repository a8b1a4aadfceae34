//! The input, delayed by any share of a sample.

/// Where the delayed input of one substep stands, relative to the row at hand.
#[derive(Clone, Copy)]
pub struct Shift {
    rows: isize,
    /// Share of the later one of the two rows that meet there.
    share: f64,
}

impl Shift {
    /// For substep `i` of `substeps`: the mean over the substep where the input is held, its value in the middle where
    /// it is interpolated.
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
        Self { rows: from as isize, share: if share <= 1e-9 { 0.0 } else { share } }
    }

    /// The input; before its first row and after its last as it is there.
    pub fn apply(&self, u: &[f64], k: usize) -> f64 {
        let last = u.len() - 1;
        let at = |i: isize| u[usize::try_from(i).unwrap_or(0).min(last)];
        let first = k as isize + self.rows;
        at(first) * (1.0 - self.share) + at(first + 1) * self.share
    }
}
