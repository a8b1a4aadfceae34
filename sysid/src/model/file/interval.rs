//! `[interval.KEY]` of a model file.

use std::collections::BTreeMap;

use super::axes::key_of;
use super::plant::KEYS;
use super::{EffectEntry, Interval};
use crate::error::{Error, ErrorKind};
use crate::legal::Legal;
use crate::toml_file::{Source, Table};

const ENDS: Legal = Legal::any("");

/// The intervals of `axis`, which has these effects.
pub(super) fn read(
    source: &Source<'_>,
    root: &Table<'_>,
    axis: &str,
    effects: &[EffectEntry],
) -> BTreeMap<String, Interval> {
    let mut all = BTreeMap::new();
    for entry in root.table("interval").iter().flat_map(Table::entries) {
        let Some(table) = entry.table() else { continue };
        table.only(&["ci95"]);
        let own = key_of(entry.key, axis);
        if let Some(own) = own.filter(|own| !source.refused() && !stands_for_something(own, effects)) {
            let found = "an interval of something that is not in this file";
            source.expect(entry.line, own, found, names(), "correct the name or delete the interval");
        }
        let Some(ends) = table.get("ci95") else {
            source.expect(
                entry.line,
                entry.key,
                "an interval without ci95",
                "ci95 = [low, high]",
                "add the key",
            );
            continue;
        };
        if let Some((ci95, own)) = ends.interval(&ENDS).zip(own) {
            all.insert(own.to_owned(), Interval { ci95 });
        }
    }
    all
}

/// Refuses an interval that could not be read back.
pub(super) fn check(key: &str, interval: Interval, effects: &[EffectEntry]) -> Result<(), Error> {
    let [low, high] = interval.ci95;
    let wrong = |found: String, expected: String| {
        let advice = "do not write a model that did not converge";
        Err(Error::new(ErrorKind::Model, found, advice).in_column(key).expecting(expected))
    };
    if !(low <= high && ENDS.holds(low) && ENDS.holds(high)) {
        return wrong(format!("ci95 = [{low}, {high}]"), format!("[low, high], low first, each {ENDS}"));
    }
    match stands_for_something(key, effects) {
        true => Ok(()),
        false => wrong("an interval of something that is not in this model".into(), names()),
    }
}

fn names() -> String {
    format!("{}, or a parameter of an effect above", KEYS.map(|(key, _)| key).join(", "))
}

/// Whether `key` is that of a plant, or a parameter of an effect with or without its id.
fn stands_for_something(key: &str, effects: &[EffectEntry]) -> bool {
    let of_effect = |effect: &EffectEntry| {
        let name =
            key.strip_prefix(effect.id.as_str()).and_then(|rest| rest.strip_prefix('.')).unwrap_or(key);
        effect.parameters.contains_key(name)
    };
    KEYS.iter().any(|(known, _)| *known == key) || effects.iter().any(of_effect)
}
