//! Rows that carry one stamp and other values: messages that came in together, each after the one before.
//!
//! ```text
//! t_{n+j} = t_n − (g − 1 − j) min(T, (t_n − t_{n−1})/g),    j = 0 .. g − 1, of g rows stamped t_n after one stamped t_{n−1}
//! ```
//!
//! with T the median step: after a gap they are the last of it.

use super::clock::{counted, median_step};
use super::garbled::are_few;
use super::missing::lines;
use super::table::Table;
use super::{Note, NoteKind};

/// Puts such rows between the stamp before and their own, where they are few; many are another clock, or two sources in one file, and
/// left to be refused, as are those that no stamp stands before.
pub(super) fn spread(table: &mut Table, notes: &mut Vec<Note>) {
    let rows: Vec<usize> = (2..table.t.len()).filter(|&row| table.t[row] == table.t[row - 1]).collect();
    if rows.is_empty() || !are_few(rows.len(), table.t.len()) {
        return;
    }
    let step = median_step(&table.t, 1);
    let mut told = Vec::new();
    for group in rows.chunk_by(|a, b| a + 1 == *b) {
        let (first, last) = (group[0] - 1, group[group.len() - 1]);
        let (now, all) = (table.t[last], (last + 1 - first) as f64);
        let Some(before) = first.checked_sub(1).map(|row| table.t[row]).filter(|t| *t < now) else {
            continue;
        };
        let apart = step.min((now - before) / all);
        for (row, later) in (first..last).rev().zip(1..) {
            table.t[row] = now - f64::from(later) * apart;
        }
        told.extend(group);
    }
    if told.is_empty() {
        return;
    }
    let text = format!(
        "{} with the stamp of the row before and other values ({}): messages that came in together, put before their stamp one by one",
        counted(told.len(), "row"),
        lines(&table.lines, &told)
    );
    notes.push(Note::new(NoteKind::Snapped, text));
}
