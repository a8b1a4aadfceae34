//! Wild samples: readings that neither the samples around them nor the signal's own unevenness explain.
//!
//! ```text
//! |x_k − m_k| > 8 · 1.4826 max(MAD_k, median_j |x_j − m_j|) and > 4 σ_x,   m_k, MAD_k over k − 7 .. k + 7
//! ```
//!
//! (Hampel's identifier: Davies and Gather, J. Am. Stat. Assoc. 88, 1993.) What is smaller than the motion is wild where it goes
//! out in one row and back in the next, by far more than the signal does anywhere else:
//!
//! ```text
//! r_k = x_k − (x_{k−1} + x_{k+1})/2,    |r_k| > 4 · 99.5 % point of |r|,    r_{k±1} of the other sign, beyond |r_k|/4
//! ```
//!
//! The point is that of the rows which are left without the hundredth part that goes out furthest, and the rows beside these.
//!
//! Up to five in a row are bridged by a straight line and told by line; longer stretches are motion, and a signal with many of
//! them has heavy tails, which is another matter.

use super::clock::counted;
use super::columns::Role;
use super::plateaus::smallest_step;
use super::table::Table;
use super::{Note, NoteKind};
use crate::estimate::digits;
use std::ops::Range;

const HALF_WINDOW: usize = 7;
/// Standard deviations, the scale taken from the median absolute deviation.
const FAR: f64 = 8.0;
const NORMAL: f64 = 1.4826;
/// Standard deviations of the whole signal: what lies within is motion.
const OF_ALL: f64 = 4.0;
const MOST_IN_A_ROW: usize = 5;
/// Share of the rows that are no further out and back than usual, and how much further a wild one is.
const USUAL: f64 = 0.995;
const OUT_AND_BACK: f64 = 4.0;
/// Least share of it by which the rows beside it stand out the other way; half where nothing else moves.
const OTHER_WAY: f64 = 0.25;
/// Share of all samples from which on they are the signal's own.
const MOST: f64 = 0.01;
/// Lines that a note names.
const LINES_TOLD: usize = 5;

/// Bridges the wild samples of rate and angle.
pub(super) fn bridge(table: &mut Table, notes: &mut Vec<Note>) {
    for signal in table.signals.iter_mut().filter(|s| matches!(s.source.role, Role::Q | Role::Theta)) {
        let wild = wild_rows(&signal.values);
        let count: usize = wild.iter().map(Range::len).sum();
        if count == 0 || count as f64 > MOST * signal.values.len() as f64 {
            continue;
        }
        let lines: Vec<String> = wild
            .iter()
            .flat_map(Range::clone)
            .take(LINES_TOLD)
            .map(|row| {
                // A log has no lines.
                let place = match table.lines.get(row) {
                    Some(line) => format!("line {line}"),
                    None => format!("{:.3} s", table.t[row]),
                };
                format!("{place} ({})", digits(signal.values[row] / signal.source.factor))
            })
            .collect();
        let more = if count > LINES_TOLD { ", ..." } else { "" };
        let text = format!(
            "{}: {} left out, far from all around: {}{more}; bridged by a straight line",
            signal.source.name,
            counted(count, "wild sample"),
            lines.join(", ")
        );
        let (first, last) = (wild[0].start, wild[wild.len() - 1].end - 1);
        notes.push(Note::over(NoteKind::Wild, table.t[first], table.t[last], text));
        for rows in wild {
            bridge_rows(&mut signal.values, rows);
        }
    }
}

fn bridge_rows(values: &mut [f64], rows: Range<usize>) {
    let last = values.len() - 1;
    let after = values[rows.end.min(last)];
    let before = if rows.start > 0 { values[rows.start - 1] } else { after };
    let after = if rows.end > last { before } else { after };
    let steps = (rows.len() + 1) as f64;
    for (i, row) in rows.enumerate() {
        values[row] = before + (after - before) * (i + 1) as f64 / steps;
    }
}

/// Stretches of at most [`MOST_IN_A_ROW`] samples that are far from all around, with what they hide between them.
fn wild_rows(values: &[f64]) -> Vec<Range<usize>> {
    if values.len() < 4 * HALF_WINDOW {
        return Vec::new();
    }
    let mut window = Vec::with_capacity(2 * HALF_WINDOW + 1);
    let local: Vec<(f64, f64)> = (0..values.len())
        .map(|k| {
            let rows = k.saturating_sub(HALF_WINDOW)..(k + HALF_WINDOW + 1).min(values.len());
            window.clear();
            window.extend_from_slice(&values[rows]);
            let middle = median(&mut window);
            window.iter_mut().for_each(|x| *x = (*x - middle).abs());
            (middle, median(&mut window))
        })
        .collect();
    let away = |k: usize| (values[k] - local[k].0).abs();
    let usual = median(&mut (0..values.len()).map(away).collect::<Vec<f64>>());
    let resolution = smallest_step(values);
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let deviation = (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt();
    let far = |k: usize| {
        away(k) > FAR * NORMAL * local[k].1.max(usual).max(resolution) && away(k) > OF_ALL * deviation
    };
    // beside a wild row every row bends
    let mut alone = out_and_back(values, resolution);
    alone.retain(|&k| !far(k - 1) && !far(k + 1));
    let rows: Vec<usize> = (0..values.len()).filter(|k| far(*k) || alone.binary_search(k).is_ok()).collect();
    let in_a_row = rows.chunk_by(|a, b| a + 1 == *b).map(|rows| rows[0]..rows[rows.len() - 1] + 1);
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for rows in in_a_row.filter(|rows| rows.len() <= MOST_IN_A_ROW) {
        match stretches.last_mut() {
            Some(last) if rows.end - last.start <= MOST_IN_A_ROW => last.end = rows.end,
            _ => stretches.push(rows),
        }
    }
    stretches
}

/// Rows that alone are far from the line through their neighbours.
fn out_and_back(values: &[f64], resolution: f64) -> Vec<usize> {
    let bend = |k: usize| values[k] - 0.5 * (values[k - 1] + values[k + 1]);
    // wild samples, which bend the rows beside them too, say nothing of what is usual
    let mut by_size: Vec<usize> = (1..values.len() - 1).collect();
    let most = (MOST * values.len() as f64).ceil() as usize;
    by_size.select_nth_unstable_by(most, |&a, &b| bend(b).abs().total_cmp(&bend(a).abs()).then(a.cmp(&b)));
    let mut aside = vec![false; values.len()];
    by_size.iter().take(most).for_each(|&k| aside[k - 1..=k + 1].fill(true));
    let mut sizes: Vec<f64> = by_size.into_iter().filter(|&k| !aside[k]).map(|k| bend(k).abs()).collect();
    let place = ((sizes.len() - 1) as f64 * USUAL) as usize;
    let usual = *sizes.select_nth_unstable_by(place, f64::total_cmp).1;
    let limit = OUT_AND_BACK * usual.max(resolution);
    let alone = |&k: &usize| {
        let size = bend(k);
        let other_way = |k: usize| -bend(k) * size.signum() > OTHER_WAY * size.abs();
        size.abs() > limit && other_way(k - 1) && other_way(k + 1)
    };
    (2..values.len() - 2).filter(alone).collect()
}

fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion with noise, and `wild` added at some rows.
    fn signal(wild: &[(usize, f64)]) -> Vec<f64> {
        let mut seed = 1_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let mut values: Vec<f64> =
            (0..2000).map(|k| (0.11 * f64::from(k)).sin() * 0.3 + 0.05 * noise()).collect();
        for &(row, height) in wild {
            values[row] += height;
        }
        values
    }

    #[test]
    fn single_and_neighbouring_wild_samples_are_found_and_nothing_else() {
        assert!(wild_rows(&signal(&[])).is_empty());
        let found = wild_rows(&signal(&[(0, 5.0), (700, 5.0), (900, -9.0), (901, -9.0), (1999, 9.0)]));
        assert_eq!(found, [0..1, 700..701, 900..902, 1999..2000]);
        // at the ends of five in a row, every way, the rows beside them are not wild
        for heights in
            [[5.0, -5.0, 4.0, -4.0, 5.0], [-3.3, 3.1, 4.3, 4.6, -3.4], [-3.7, -3.7, -3.4, -3.1, 5.0]]
        {
            let mut five = signal(&[]);
            // where the motion is quick, the middle ones are hidden by the others
            five.iter_mut().enumerate().for_each(|(k, x)| *x += 0.3 * (0.5 * k as f64).sin());
            five[900..905].copy_from_slice(&heights);
            assert!(matches!(wild_rows(&five)[..], [Range { start: 900, end: 905 }]), "{heights:?}");
        }
    }

    #[test]
    fn one_row_out_and_back_is_wild_though_it_stays_within_the_motion() {
        assert_eq!(wild_rows(&signal(&[(900, 0.3), (1500, -0.3)])), [900..901, 1500..1501]);
        // three in a short recording
        let short = |wild: &[(usize, f64)]| wild_rows(&signal(wild)[..600]);
        assert_eq!(short(&[(100, 0.3), (250, 0.25), (500, 0.3)]), [100..101, 250..251, 500..501]);
        assert!(short(&[]).is_empty());
        // as far as the noise goes elsewhere, and a step
        assert!(wild_rows(&signal(&[(900, 0.05)])).is_empty());
        let mut step = signal(&[]);
        step[900..].iter_mut().for_each(|x| *x += 0.3);
        assert!(wild_rows(&step).is_empty());
    }

    #[test]
    fn a_jump_and_rest_before_motion_are_not_wild() {
        let mut values = signal(&[]);
        values[..1000].fill(0.0);
        assert!(wild_rows(&values).is_empty());
        values[1000..].iter_mut().for_each(|x| *x += 4.0);
        assert!(wild_rows(&values).is_empty());
    }

    #[test]
    fn a_flickering_last_digit_is_not_wild() {
        let values: Vec<f64> = (0..500).map(|k| if k % 97 == 0 { 0.001 } else { 0.0 }).collect();
        assert!(wild_rows(&values).is_empty());
    }

    #[test]
    fn a_bridge_is_a_straight_line_and_flat_at_the_ends() {
        let mut values = [9.0, 1.0, 9.0, 9.0, 4.0, 9.0];
        for rows in [0..1, 2..4, 5..6] {
            bridge_rows(&mut values, rows);
        }
        assert_eq!(values, [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
    }
}
