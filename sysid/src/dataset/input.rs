//! How the input moves.

use super::{Dataset, Run};
use core::cmp::Ordering;

/// Share of the rows at one value from which on an input stands still.
const STANDS: f64 = 0.9;

impl Dataset {
    /// Whether the input takes more than one value, in a run or from one run to another.
    pub fn input_changes(&self) -> bool {
        let mut all = self.runs.iter().flat_map(|run| &run.u);
        let first = all.next();
        all.any(|u| Some(u) != first)
    }

    /// How often the input changes: steps, or ramps each way.
    pub(crate) fn changes_of_input(&self) -> usize {
        let of_run = |run: &Run| {
            let moves: Vec<_> = run.u.windows(2).map(|pair| pair[1].partial_cmp(&pair[0])).collect();
            moves.chunk_by(|a, b| a == b).filter(|stretch| stretch[0] != Some(Ordering::Equal)).count()
        };
        self.runs.iter().map(of_run).sum()
    }

    /// Whether the input moves for more than a tenth of the time: less is a step or two, or one value a run, whose spread over all
    /// rows says nothing of its size.
    pub(super) fn input_goes_on(&self) -> bool {
        let standing: usize = self.runs.iter().map(|run| rows_at_rest(&run.u)).sum();
        (standing as f64) < STANDS * self.samples() as f64
    }
}

/// Number of rows with the value that most of them have (Boyer, Moore, 1981); where no value has more than half, some number below that.
fn rows_at_rest(signal: &[f64]) -> usize {
    let (mut value, mut votes) = (0.0, 0usize);
    for x in signal {
        if votes == 0 {
            value = *x;
        }
        votes = if *x == value { votes + 1 } else { votes - 1 };
    }
    signal.iter().filter(|x| **x == value).count()
}

/// Whether a signal has two values and no third.
pub fn has_two_levels<'a>(mut input: impl Iterator<Item = &'a f64>) -> bool {
    let Some(first) = input.next() else { return false };
    let Some(second) = input.find(|u| *u != first) else { return false };
    input.all(|u| u == first || u == second)
}

/// Standard deviation of the values that count, by their median size, as it is for normal numbers about zero.
pub fn median_size(values: &[f64], counts: &[bool]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().zip(counts).filter(|(_, c)| **c).map(|(v, _)| v.abs()).collect();
    let middle = sizes.len() / 2;
    sizes.sort_by(f64::total_cmp);
    1.4826 * sizes.get(middle).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::flight;

    #[test]
    fn a_ramp_is_one_change() {
        let mut flown = flight(1, 0.0);
        let mut changes = |u: &dyn Fn(usize) -> f64| {
            flown.u.iter_mut().enumerate().for_each(|(k, value)| *value = u(k));
            Dataset::new(&[flown.recording()]).unwrap().changes_of_input()
        };
        assert_eq!(changes(&|_| 0.01), 0);
        assert_eq!(changes(&|k| if (100..300).contains(&k) { 0.01 } else { 0.0 }), 2);
        assert_eq!(changes(&|k| 1e-4 * (k.clamp(100, 200) - 100) as f64), 1);
        assert_eq!(changes(&|k| 1e-4 * 100usize.abs_diff(k.min(200)) as f64), 2);
    }

    #[test]
    fn an_input_of_two_levels_has_no_third() {
        for (input, two) in
            [(&[][..], false), (&[1.0; 4], false), (&[1.0, 0.0, 0.0, 1.0], true), (&[0.0, 1.0, 2.0], false)]
        {
            assert_eq!(has_two_levels(input.iter()), two, "{input:?}");
        }
    }
}
