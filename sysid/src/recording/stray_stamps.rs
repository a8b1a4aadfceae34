//! Single time stamps that a garbled line or a swap of two rows has put out of order, between neighbours that are in order.

use super::clock::median_step;
use super::garbled::are_few;
use super::missing::{lines, over};
use super::table::Table;
use super::{Note, clock::counted};

/// Rows before and after a stray one that tell whether the clock goes on.
const REACH: usize = 3;

/// Leaves out the rows of such stamps, where they are few; a clock that is set back, or that never grows, is left to be refused.
pub(super) fn leave_out(table: &mut Table, notes: &mut Vec<Note>) {
    let Some(strays) = strays(&table.t) else { return };
    let (Some(&first), Some(&last)) = (strays.first(), strays.last()) else { return };
    if !are_few(strays.len(), table.t.len()) {
        return;
    }
    let text = format!(
        "{} out of order in time: left out as a gap ({})",
        counted(strays.len(), "row"),
        lines(&table.lines, &strays)
    );
    table.remove(&strays);
    let (end, after) = (table.t.len() - 1, last + 1 - strays.len());
    notes.push(over(&table.t, first.saturating_sub(1).min(end), after.min(end), text));
}

/// Rows without which time does not run backwards; `None` where no single rows are to blame.
fn strays(t: &[f64]) -> Option<Vec<usize>> {
    let mut strays: Vec<usize> = Vec::new();
    for row in (1..t.len()).filter(|&row| t[row] < t[row - 1]) {
        let early = row < 2 || t[row - 2] < t[row];
        let late = row + 1 == t.len() || t[row - 1] < t[row + 1];
        match (early, late) {
            (true, true) => strays.push(if is_further_off(t, row) { row } else { row - 1 }),
            (true, false) => strays.push(row - 1),
            (false, true) => strays.push(row),
            (false, false) => return None,
        }
    }
    if strays.is_empty() {
        return Some(strays);
    }
    let kept = (0..t.len()).filter(|row| strays.binary_search(row).is_err());
    let in_order = kept.map(|row| t[row]).is_sorted();
    let step = median_step(t, 1);
    (in_order && strays.iter().all(|&row| goes_on(t, row, step))).then_some(strays)
}

/// Whether as much time goes by across a stray `row` as the rows there take, `step` each: a clock that is set back by a step or two
/// takes less.
fn goes_on(t: &[f64], row: usize, step: f64) -> bool {
    let (Some(from), Some(to)) = (row.checked_sub(REACH).and_then(|from| t.get(from)), t.get(row + REACH))
    else {
        return true;
    };
    to - from > (2 * REACH - 1) as f64 * step
}

/// Whether `row` lies further than the one before it from where an even clock has it, by the rows around both.
fn is_further_off(t: &[f64], row: usize) -> bool {
    let (Some(&from), Some(&to)) = (row.checked_sub(2).and_then(|before| t.get(before)), t.get(row + 1))
    else {
        return row + 1 == t.len();
    };
    let off = |row: usize, share: f64| (t[row] - from - share * (to - from)).abs();
    off(row, 2.0 / 3.0) > off(row - 1, 1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::strays;

    #[test]
    fn single_rows_are_to_blame_and_a_clock_that_is_set_back_is_not() {
        assert_eq!(strays(&[0.0, 1.0, 2.0, 3.0]), Some(vec![]));
        assert_eq!(strays(&[0.0, 1.0, 20.0, 3.0, 4.0]), Some(vec![2]));
        assert_eq!(strays(&[0.0, 1.0, 0.2, 3.0, 4.0]), Some(vec![2]));
        assert_eq!(strays(&[0.0, 2.0, 1.0, 3.0]), Some(vec![1]), "two rows that changed places");
        assert_eq!(strays(&[9.0, 1.0, 2.0, 3.0, 0.5]), Some(vec![0, 4]));
        assert_eq!(strays(&[5.0, 6.0, 7.0, 0.0, 1.0, 2.0]), None);
        assert_eq!(strays(&[0.0, 9.0, 1.0, 2.0, 0.5, 3.0]), Some(vec![1, 4]));
        assert_eq!(strays(&[0.0, 1.0, 0.9, 0.8, 2.0]), Some(vec![1, 3]));
        assert_eq!(strays(&[9.0, 8.0, 7.0, 6.0]), None);
        let even =
            |late: f64| (0..30).map(|k| f64::from(k) - if k < 15 { 0.0 } else { late }).collect::<Vec<f64>>();
        assert_eq!(strays(&even(1.2)), None, "a clock that is set back a little");
        let mut swapped = even(0.0);
        swapped.swap(14, 15);
        assert_eq!(strays(&swapped), Some(vec![14]));
    }
}
