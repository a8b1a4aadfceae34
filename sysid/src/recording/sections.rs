//! Sections: runs of one label, from the file's column or from times given by the caller.

use std::collections::BTreeSet;
use std::ops::Range;

use super::options::ReadOptions;
use super::table::Table;
use super::{Note, NoteKind, Section};
use crate::error::{Error, ErrorKind};

/// Label of rows between the sections.
const BETWEEN: &str = "-";
/// Label of a file that names no section.
pub(crate) const WHOLE: &str = "all";

/// Replaces the labels as the options say; a file without a single label becomes one section `all`.
pub(super) fn relabel(table: &mut Table, options: &ReadOptions, notes: &mut Vec<Note>) -> Result<(), Error> {
    let by_time = match (options.splits.is_empty(), options.sections.is_empty()) {
        (true, true) => {
            if table.label_names.iter().all(|name| name == BETWEEN) {
                if !table.labels.is_empty() {
                    let text = "the section column names no section: the whole recording is one, called all";
                    notes.push(Note::new(NoteKind::Sections, text));
                }
                set_labels(table, vec![WHOLE.into()], |_| 0);
            }
            return Ok(());
        }
        (false, false) => {
            let found = "both --split and --section";
            return Err(Error::new(ErrorKind::Options, found, "give one of the two"));
        }
        (false, true) => "--split",
        (true, false) => "--section",
    };
    if !table.labels.is_empty() {
        notes.push(Note::new(NoteKind::Sections, format!("the section column is replaced by {by_time}")));
    }
    if options.sections.is_empty() { split(table, &options.splits) } else { name_by_time(table, options) }
}

fn set_labels(table: &mut Table, names: Vec<String>, index_at: impl Fn(f64) -> usize) {
    table.labels = table.t.iter().map(|&t| u32::try_from(index_at(t)).unwrap_or(u32::MAX)).collect();
    table.label_names = names;
}

fn time_range(table: &Table) -> Option<(f64, f64)> {
    Some((*table.t.first()?, *table.t.last()?))
}

fn split(table: &mut Table, splits: &[f64]) -> Result<(), Error> {
    let Some((first, last)) = time_range(table) else { return Ok(()) };
    let mut splits = splits.to_vec();
    splits.sort_by(f64::total_cmp);
    splits.dedup();
    if let Some(outside) = splits.iter().find(|&&s| !(s > first && s <= last)) {
        let found = format!("--split {outside}");
        let advice = "give times of the file's own clock, in seconds";
        return Err(Error::new(ErrorKind::Options, found, advice)
            .expecting(format!("a time inside the recording, {first} to {last} s")));
    }
    let names = (1..=splits.len() + 1).map(|n| format!("S{n}")).collect();
    set_labels(table, names, |t| splits.partition_point(|&s| s <= t));
    Ok(())
}

fn name_by_time(table: &mut Table, options: &ReadOptions) -> Result<(), Error> {
    let Some((first, last)) = time_range(table) else { return Ok(()) };
    let mut specs = options.sections.clone();
    specs.sort_by(|a, b| a.from.total_cmp(&b.from));
    for pair in specs.windows(2) {
        if pair[1].from < pair[0].to {
            let found = format!("--section {} and --section {} overlap", pair[0].label, pair[1].label);
            return Err(Error::new(ErrorKind::Options, found, "let one end where the other begins"));
        }
    }
    for spec in &specs {
        if !table.t.iter().any(|t| (spec.from..spec.to).contains(t)) {
            let found = format!("--section {}={}..{}: no sample there", spec.label, spec.from, spec.to);
            let advice = "give times of the file's own clock, in seconds";
            return Err(Error::new(ErrorKind::Options, found, advice)
                .expecting(format!("times inside the recording, {first} to {last} s")));
        }
    }
    let mut names: Vec<String> = specs.iter().map(|spec| spec.label.clone()).collect();
    names.push(BETWEEN.into());
    set_labels(table, names, |t| {
        specs.iter().position(|spec| (spec.from..spec.to).contains(&t)).unwrap_or(specs.len())
    });
    Ok(())
}

/// The runs of one label inside one segment, with unique names.
pub(super) fn runs(table: &Table, segments: &[Range<usize>]) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    let mut taken = BTreeSet::new();
    let mut counts = vec![0_usize; table.label_names.len()];
    for segment in segments {
        let mut start = segment.start;
        for run in table.labels[segment.clone()].chunk_by(|a, b| a == b) {
            let rows = start..start + run.len();
            start = rows.end;
            let index = run[0] as usize;
            let name = &table.label_names[index];
            if name == BETWEEN {
                continue;
            }
            let label = loop {
                counts[index] += 1;
                let label =
                    if counts[index] == 1 { name.clone() } else { format!("{name}#{}", counts[index]) };
                if taken.insert(label.clone()) {
                    break label;
                }
            };
            sections.push(Section { label, file_label: name.clone(), rows });
        }
    }
    sections
}
