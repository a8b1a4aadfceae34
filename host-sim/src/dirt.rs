//! What happens to a recording between the vehicle and the file, each a pure function from one table to another. A column
//! that the table lacks is left alone.

use rand::RngExt;
use rand::seq::SliceRandom;

use crate::seeds::{Stream, generator};
use crate::table::{Column, Table};

fn changed(mut table: Table, name: &str, change: impl FnOnce(&mut Vec<f64>)) -> Table {
    if let Some(column) = table.columns.iter_mut().find(|column| column.name == name) {
        change(&mut column.values);
    }
    table
}

fn per_row(
    table: Table,
    pick: impl Fn(&[f64]) -> Vec<f64>,
    label: impl Fn(&[String]) -> Vec<String>,
) -> Table {
    let Table { comment, t_s, columns, sections } = table;
    let columns = columns.into_iter().map(|c| Column { name: c.name, values: pick(&c.values) }).collect();
    Table { t_s: pick(&t_s), columns, sections: label(&sections), comment }
}

/// Column `name` stamped `rows` rows late (the value of t_k stands at t_k+rows), or early where it is negative.
#[must_use]
pub fn stamped_late(table: Table, name: &str, rows: isize) -> Table {
    changed(table, name, |values| {
        let last = values.len().saturating_sub(1);
        *values = (0..values.len())
            .filter_map(|k| values.get(k.saturating_add_signed(-rows).min(last)).copied())
            .collect();
    })
}

/// Column `name` with `bursts` bursts of `in_a_row` wild samples each, of ½ to 1 times `height`, either sign, in places
/// drawn by `seed` that do not touch; fewer where there is no room.
#[must_use]
pub fn wild(table: Table, name: &str, bursts: usize, in_a_row: usize, height: f64, seed: u64) -> Table {
    changed(table, name, |values| {
        let mut generator = generator(seed, Stream::Dirt);
        let mut places: Vec<usize> = (0..values.len() / (in_a_row + 1)).collect();
        places.shuffle(&mut generator);
        for place in places.into_iter().take(bursts) {
            for value in values.iter_mut().skip(place * (in_a_row + 1)).take(in_a_row) {
                let sign = if generator.random_bool(0.5) { 1.0 } else { -1.0 };
                *value = sign * height * generator.random_range(0.5..1.0);
            }
        }
    })
}

/// A clock that shows `t0_s` at the first row.
#[must_use]
pub fn clock_from(mut table: Table, t0_s: f64) -> Table {
    let first = table.t_s.first().copied().unwrap_or_default();
    table.t_s.iter_mut().for_each(|t| *t += t0_s - first);
    table
}

/// Column `name` in degrees under a name that says radians.
#[must_use]
pub fn in_degrees(table: Table, name: &str) -> Table {
    changed(table, name, |values| values.iter_mut().for_each(|value| *value = value.to_degrees()))
}

/// Column `name` with its sign turned round.
#[must_use]
pub fn reversed(table: Table, name: &str) -> Table {
    changed(table, name, |values| values.iter_mut().for_each(|value| *value = -*value))
}

/// Column `name` stuck at its first value from `from_s` on.
#[must_use]
pub fn dead(table: Table, name: &str, from_s: f64) -> Table {
    let alive = table.t_s.partition_point(|t| *t < from_s);
    changed(table, name, |values| {
        let stuck = values.get(alive).copied().unwrap_or_default();
        values.iter_mut().skip(alive).for_each(|value| *value = stuck);
    })
}

/// Without column `name`.
#[must_use]
pub fn without(mut table: Table, name: &str) -> Table {
    table.columns.retain(|column| column.name != name);
    table
}

/// The rows from `from_s` to before `to_s`, their times as they are.
#[must_use]
pub fn cut(table: Table, [from_s, to_s]: [f64; 2]) -> Table {
    let [from, to] = [from_s, to_s].map(|end| table.t_s.partition_point(|t| *t < end));
    let to = to.max(from);
    per_row(
        table,
        |values| values.get(from..to).unwrap_or_default().to_vec(),
        |labels| labels.get(from..to).unwrap_or_default().to_vec(),
    )
}

/// Every `every`-th row.
#[must_use]
pub fn thinned(table: Table, every: usize) -> Table {
    let every = every.max(1);
    per_row(
        table,
        |values| values.iter().step_by(every).copied().collect(),
        |labels| labels.iter().step_by(every).cloned().collect(),
    )
}

/// The means of `every` rows each, stamped with the time of the first of them; what is left over at the end is dropped.
#[must_use]
pub fn averaged(table: Table, every: usize) -> Table {
    let every = every.max(1);
    let t_s = table.t_s.chunks_exact(every).filter_map(|chunk| chunk.first().copied()).collect();
    let mean = |values: &[f64]| -> Vec<f64> {
        values.chunks_exact(every).map(|chunk| chunk.iter().sum::<f64>() / every as f64).collect()
    };
    let labels = |labels: &[String]| labels.chunks_exact(every).filter_map(|c| c.first().cloned()).collect();
    Table { t_s, ..per_row(table, mean, labels) }
}

/// All of them in one file, one after another without a gap in time: the times of each go on a step after those before.
/// Columns and sections as the first has them; a table that lacks one of its columns is left out.
#[must_use]
pub fn end_to_end(tables: &[Table]) -> Table {
    let Some((first, others)) = tables.split_first() else { return Table::default() };
    let step = first.t_s.get(1).zip(first.t_s.first()).map_or(0.0, |(after, before)| after - before);
    let mut whole = first.clone();
    for table in others {
        let values: Option<Vec<&[f64]>> = whole.columns.iter().map(|c| table.column(&c.name)).collect();
        let Some(values) = values else { continue };
        let begins = whole.t_s.last().map_or(0.0, |last| last + step);
        let first = table.t_s.first().copied().unwrap_or_default();
        for (column, added) in whole.columns.iter_mut().zip(values) {
            column.values.extend_from_slice(added);
        }
        whole.t_s.extend(table.t_s.iter().map(|t| begins + t - first));
        whole.sections.extend_from_slice(&table.sections);
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten rows at 0.1 s from 1 s on, `q_rad_s` counts them.
    fn counted() -> Table {
        let values = || (0..10).map(f64::from);
        let mut table = Table::new("counted", values().map(|k| 1.0 + 0.1 * k).collect());
        table.sections = (0..10).map(|k| if k < 5 { "I" } else { "II" }.to_owned()).collect();
        table.with("u_rad", vec![0.5; 10]).with("q_rad_s", values().collect())
    }

    fn q(table: &Table) -> Vec<f64> {
        table.column("q_rad_s").unwrap().to_vec()
    }

    #[test]
    fn stamps_move_one_column_alone() {
        assert_eq!(q(&stamped_late(counted(), "q_rad_s", 1))[..4], [0.0, 0.0, 1.0, 2.0]);
        assert_eq!(q(&stamped_late(counted(), "q_rad_s", -1))[6..], [7.0, 8.0, 9.0, 9.0]);
        assert_eq!(stamped_late(counted(), "q_rad_s", 3).column("u_rad"), counted().column("u_rad"));
        assert_eq!(stamped_late(counted(), "no_such", 1), counted());
    }

    #[test]
    fn as_many_samples_are_wild_as_asked_for_and_by_the_seed() {
        let long = || Table::new("long", (0..1000).map(f64::from).collect()).with("q_rad_s", vec![0.1; 1000]);
        for (bursts, in_a_row) in [(1, 1), (20, 1), (4, 5), (0, 3)] {
            let table = wild(long(), "q_rad_s", bursts, in_a_row, 5.0, 7);
            let places: Vec<usize> = (0..1000).filter(|k| q(&table)[*k].abs() > 1.0).collect();
            assert_eq!(places.len(), bursts * in_a_row);
            let begins = places.iter().filter(|k| **k == 0 || !places.contains(&(**k - 1))).count();
            assert_eq!(begins, bursts);
            assert!(places.iter().all(|k| (2.5..=5.0).contains(&q(&table)[*k].abs())));
            assert_eq!(table, wild(long(), "q_rad_s", bursts, in_a_row, 5.0, 7));
        }
        assert_ne!(wild(long(), "q_rad_s", 3, 1, 5.0, 7), wild(long(), "q_rad_s", 3, 1, 5.0, 8));
    }

    #[test]
    fn units_signs_clocks_and_dead_channels_are_as_said() {
        assert!((q(&in_degrees(counted(), "q_rad_s"))[9] - 9.0 * 57.295_779_513).abs() < 1e-8);
        assert_eq!(q(&reversed(counted(), "q_rad_s"))[9], -9.0);
        assert_eq!(q(&dead(counted(), "q_rad_s", 1.25))[2..], [2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]);
        let late = clock_from(counted(), 180.0);
        assert!((late.t_s[9] - 180.9).abs() < 1e-9 && late.t_s[0] == 180.0);
        assert!(without(counted(), "u_rad").column("u_rad").is_none());
    }

    #[test]
    fn rows_are_picked_averaged_cut_and_joined_with_their_times_and_labels() {
        let thin = thinned(counted(), 4);
        assert_eq!((q(&thin), thin.sections.join(" ")), (vec![0.0, 4.0, 8.0], "I I II".to_owned()));
        let mean = averaged(counted(), 4);
        assert_eq!((q(&mean), mean.t_s.clone()), (vec![1.5, 5.5], vec![1.0, 1.4]));
        let part = cut(counted(), [1.25, 1.55]);
        assert_eq!((q(&part), part.sections.len()), (vec![3.0, 4.0, 5.0], 3));
        let whole = end_to_end(&[counted(), counted()]);
        assert_eq!((q(&whole).len(), whole.sections.len()), (20, 20));
        assert!(whole.t_s.windows(2).all(|pair| (pair[1] - pair[0] - 0.1).abs() < 1e-9));
    }
}
