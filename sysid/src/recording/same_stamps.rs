//! Rows that carry one stamp and other values: messages that came in together, each after the one before.
//!
//! ```text
//! t_{n+j} = t_{n−1} + (t_n − t_{n−1}) (j + 1)/g,    j = 0 .. g − 1, of g rows stamped t_n after one stamped t_{n−1}
//! ```

use super::clock::counted;
use super::garbled::are_few;
use super::missing::lines;
use super::table::Table;
use super::{Note, NoteKind};

/// Puts such rows between the stamp before and their own, where they are few; many are another clock, or two sources in one file, and
/// left to be refused. `same` says whether a row has all values of the one before: that is a repetition.
pub(super) fn spread(table: &mut Table, same: impl Fn(&Table, usize) -> bool, notes: &mut Vec<Note>) {
    let rows: Vec<usize> =
        (2..table.t.len()).filter(|&row| table.t[row] == table.t[row - 1] && !same(table, row)).collect();
    if rows.is_empty() || !are_few(rows.len(), table.t.len()) {
        return;
    }
    let mut told = Vec::new();
    for group in rows.chunk_by(|a, b| a + 1 == *b) {
        let (first, last) = (group[0] - 1, group[group.len() - 1]);
        let (now, all) = (table.t[last], (last + 1 - first) as f64);
        let Some(before) = first.checked_sub(1).map(|row| table.t[row]).filter(|t| *t < now) else {
            continue;
        };
        for (row, count) in (first..last).zip(1..) {
            table.t[row] = before + (now - before) * f64::from(count) / all;
        }
        told.extend(group);
    }
    if told.is_empty() {
        return;
    }
    let text = format!(
        "{} with the stamp of the row before and other values ({}): messages that came in together, spread between the stamps around them",
        counted(told.len(), "row"),
        lines(&table.lines, &told)
    );
    notes.push(Note::new(NoteKind::Snapped, text));
}
