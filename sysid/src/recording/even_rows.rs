//! Rows that were sampled evenly and stamped late, as a busy computer does, told from rows that were read at uneven times.
//!
//! The motion is smooth in time. Of two clocks, the stamps and the count of the rows, the right one is that by which each value of
//! rate and angle lies nearer to the straight line through its neighbours:
//!
//! ```text
//! r_k = x_k − x_{k−1} − (x_{k+1} − x_{k−1}) (t_k − t_{k−1})/(t_{k+1} − t_{k−1}),    d_k = r_k²(stamps) − r_k²(count)
//! ```
//!
//! The count is believed where Σ d_k exceeds `CLEAR` of its standard errors; otherwise the stamps are.

use std::ops::Range;

use super::columns::Role;
use super::table::Table;

/// Standard errors by which rows must be smoother by their count.
const CLEAR: f64 = 4.0;
/// Rows before and after one that say whether a row is missing before it: a late stamp is late alone.
const ROWS: usize = 8;

/// An even clock.
pub(super) struct EvenRows {
    /// Time between rows, s.
    pub(super) step: f64,
    /// Stamps by that clock.
    pub(super) t: Vec<f64>,
    /// Farthest that a stamp lies from it, s.
    pub(super) off: f64,
}

/// The even clock of the rows of `stretches`, `median` apart, where the motion is smoother by it than by the stamps.
pub(super) fn even_rows(table: &Table, stretches: &[Range<usize>], median: f64) -> Option<EvenRows> {
    let counts: Vec<Vec<f64>> = stretches.iter().map(|rows| counts(&table.t[rows.clone()], median)).collect();
    let outputs = table.signals.iter().filter(|s| matches!(s.source.role, Role::Q | Role::Theta));
    let (mut sum, mut squares) = (0.0, 0.0);
    for signal in outputs {
        let (mut differences, mut total) = (Vec::new(), 0.0);
        for (rows, counts) in stretches.iter().zip(&counts) {
            let (x, t) = (&signal.values[rows.clone()], &table.t[rows.clone()]);
            let bends = bends(x, t).zip(bends(x, counts));
            differences.extend(bends.map(|(stamps, count)| {
                total += stamps * stamps + count * count;
                stamps * stamps - count * count
            }));
        }
        // each signal in its own unit
        let unit = total / differences.len().max(1) as f64;
        sum += differences.iter().map(|d| d / unit).sum::<f64>();
        squares += differences.iter().map(|d| (d / unit).powi(2)).sum::<f64>();
    }
    if sum.is_nan() || sum <= CLEAR * squares.sqrt() {
        return None;
    }
    let lines = stretches.iter().zip(&counts).map(|(rows, counts)| sums(&table.t[rows.clone()], counts));
    let (along, across) = lines.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    let step = across / along;
    let (mut t, mut off) = (table.t.clone(), 0.0_f64);
    for (rows, counts) in stretches.iter().zip(&counts) {
        let stamps = &mut t[rows.clone()];
        let late = |(t, count): (&f64, &f64)| t - count * step;
        let start = stamps.iter().zip(counts).map(late).sum::<f64>() / counts.len() as f64;
        for (stamp, count) in stamps.iter_mut().zip(counts) {
            let even = start + count * step;
            off = off.max((*stamp - even).abs());
            *stamp = even;
        }
    }
    Some(EvenRows { step, t, off })
}

/// Distances of the values from the lines through their neighbours.
fn bends(x: &[f64], t: &[f64]) -> impl Iterator<Item = f64> {
    x.windows(3).zip(t.windows(3)).map(|(x, t)| x[1] - x[0] - (x[2] - x[0]) * (t[1] - t[0]) / (t[2] - t[0]))
}

/// Σ (n − n̄)² and Σ (n − n̄)(t − t̄).
fn sums(t: &[f64], counts: &[f64]) -> (f64, f64) {
    let n = counts.len() as f64;
    let (of_count, of_time) = (counts.iter().sum::<f64>() / n, t.iter().sum::<f64>() / n);
    let terms = t.iter().zip(counts).map(|(t, count)| (count - of_count, t - of_time));
    terms.fold((0.0, 0.0), |(along, across), (c, t)| (along + c * c, across + c * t))
}

/// Steps from the first row. One is missing before a row where all that follow are late by it.
fn counts(t: &[f64], step: f64) -> Vec<f64> {
    let mut counts = vec![0.0_f64];
    for k in 1..t.len() {
        let last = counts[k - 1];
        let before = (k.saturating_sub(ROWS)..k).map(|i| t[i] + (last - counts[i]) * step);
        let base = before.fold(f64::INFINITY, f64::min);
        let late = (k..t.len().min(k + ROWS)).map(|j| ((t[j] - base) / step).round() - (j + 1 - k) as f64);
        counts.push(last + 1.0 + late.fold(f64::INFINITY, f64::min).max(0.0));
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::super::options::ColumnMap;
    use super::*;

    const STEP: f64 = 0.01;

    /// All rows as one stretch.
    fn whole() -> Vec<Range<usize>> {
        std::iter::once(0..1999).collect()
    }

    /// A rate of 1.3 Hz at `times`, with noise, stamped `stamps`.
    fn table(times: &[f64], stamps: Vec<f64>) -> Table {
        let mut noise = noise(7);
        let values = times.iter().map(|t| (8.0 * t).sin() + 0.002 * noise()).collect();
        let map: ColumnMap = "q_rad_s=q".parse().unwrap();
        Table::of_signals(stamps, vec![(map, values)]).unwrap()
    }

    fn noise(mut seed: u32) -> impl FnMut() -> f64 {
        move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        }
    }

    /// Even times without row 500, and how late each is, up to 7 ms now and then.
    fn rows() -> (Vec<f64>, Vec<f64>) {
        let even = (0..2000).filter(|k| *k != 500).map(|k| STEP * f64::from(k));
        let mut noise = noise(3);
        even.map(|t| (t, 0.001 * (noise() + 0.5) * if noise() > 0.45 { 7.0 } else { 1.0 })).unzip()
    }

    #[test]
    fn late_stamps_of_even_rows_give_way_to_the_count_with_missing_rows_left_out() {
        let (even, late) = rows();
        let stamps: Vec<f64> = even.iter().zip(&late).map(|(t, late)| t + late).collect();
        let found = even_rows(&table(&even, stamps), &whole(), STEP).unwrap();
        assert!((found.step - STEP).abs() < 1e-6, "{}", found.step);
        assert!((found.t[500] - found.t[499] - 2.0 * STEP).abs() < 1e-5);
        assert!((found.off - 0.007).abs() < 0.001, "{}", found.off);
    }

    #[test]
    fn rows_that_were_read_at_uneven_times_keep_their_stamps() {
        let (even, late) = rows();
        let read: Vec<f64> = even.iter().zip(&late).map(|(t, late)| t + late).collect();
        assert!(even_rows(&table(&read, read.clone()), &whole(), STEP).is_none());
        // at rest the two cannot be told apart
        assert!(even_rows(&table(&vec![0.0; 1999], read), &whole(), STEP).is_none());
    }
}
