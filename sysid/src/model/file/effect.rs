//! `[[effect]]` of a model file: checked against the effects that there are.

use std::collections::BTreeMap;

use serde::Serialize;

use super::AXES;
use crate::error::quote;
use crate::legal::Legal;
use crate::toml_file::{Source, Table};

/// One effect with its parameters, in the units of the catalogue.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectEntry {
    /// Id of the catalogue, or `unlisted`.
    pub id: String,
    /// Which curves a term without a name is made of; `None` for an effect of the catalogue.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// Value by parameter name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, f64>,
    /// A comment of one line that is written above the entry, and not read.
    #[serde(skip)]
    pub remark: Option<String>,
}

/// An effect that a model file may have.
#[derive(Clone, Debug)]
pub struct KnownEffect {
    /// Its id.
    pub id: &'static str,
    /// Its shape, for a term without a name.
    pub shape: Option<&'static str>,
    /// Its parameters, all of which must be given, with what is legal.
    pub parameters: Vec<(&'static str, Legal)>,
}

/// Keys of what the signals of a term without a name are divided by: pitch rate (rad/s), pitch angle (rad), input (its
/// unit) and time (s); each > 0.
pub const SCALES: [&str; 4] = ["scale_q_rad_s", "scale_theta_rad", "scale_u", "duration_s"];

/// An effect and the axis that it is of; without one it is of all.
type OfAxis = (Option<String>, EffectEntry);

/// The effects of a file in their order; what is wrong with one is kept by `source`.
pub(super) fn read(source: &Source<'_>, root: &Table<'_>, known: &[KnownEffect]) -> Vec<OfAxis> {
    let tables = root.get("effect").map(|entry| entry.tables()).unwrap_or_default();
    let mut all: Vec<(usize, OfAxis)> = Vec::new();
    for table in tables {
        let Some((axis, effect)) = one(source, &table, known) else { continue };
        let same = |(_, (of, other)): &&(usize, OfAxis)| {
            let together = of.is_none() || axis.is_none() || *of == axis;
            together && (&other.id, &other.shape) == (&effect.id, &effect.shape)
        };
        if let Some((first, _)) = all.iter().find(same) {
            let line = table.get("id").map_or(table.line, |id| id.line);
            let found = format!("{} a second time; the first is on line {first}", effect.id);
            source.expect(line, "id", found, "each effect once", "delete one of the two entries");
        }
        all.push((table.line, (axis, effect)));
    }
    all.into_iter().map(|(_, effect)| effect).collect()
}

fn one(source: &Source<'_>, table: &Table<'_>, all: &[KnownEffect]) -> Option<OfAxis> {
    let axis = axis(table);
    let Some(id) = table.get("id") else {
        source.refuse(table.line, "id", "an effect without id", "add a line id = \"...\"");
        return None;
    };
    let (id_line, id) = (id.line, id.text("the id of an effect")?);
    let known = find(source, table, all, (id, id_line))?;
    let names: Vec<&str> = known.parameters.iter().map(|(name, _)| *name).collect();
    let expected = format!("{id} with {}", names.join(", "));
    let (mut parameters, mut unknown) = (BTreeMap::new(), 0);
    for entry in table.entries().filter(|entry| !["axis", "id", "shape"].contains(&entry.key)) {
        let Some((name, legal)) = known.parameters.iter().find(|(name, _)| *name == entry.key) else {
            unknown += 1;
            let advice = "correct the key or delete the line";
            source.expect(entry.line, entry.key, "unknown parameter", expected.as_str(), advice);
            continue;
        };
        if let Some(value) = entry.number(legal) {
            parameters.insert((*name).to_owned(), value);
        }
    }
    // a misspelt key is not missing as well
    let missing = known.parameters.iter().filter(|(name, _)| table.get(name).is_none());
    for (name, legal) in missing.skip(unknown) {
        source.expect(id_line, name, format!("{id} without {name}"), legal.to_string(), "add the parameter");
    }
    Some((
        axis?,
        EffectEntry { id: id.into(), shape: known.shape.map(str::to_owned), parameters, remark: None },
    ))
}

/// The axis that an entry is of: none where it is of all; nothing where it cannot be read.
fn axis(table: &Table<'_>) -> Option<Option<String>> {
    let Some(entry) = table.get("axis") else { return Some(None) };
    let legal = format!("one of {}", AXES.join(", "));
    let axis = entry.text(&legal)?;
    if !AXES.contains(&axis) {
        entry.refuse(&legal);
        return None;
    }
    Some(Some(axis.to_owned()))
}

/// The effect with this id and the shape of `table`.
fn find<'k>(
    source: &Source<'_>,
    table: &Table<'_>,
    all: &'k [KnownEffect],
    (id, id_line): (&str, usize),
) -> Option<&'k KnownEffect> {
    let same: Vec<&KnownEffect> = all.iter().filter(|known| known.id == id).collect();
    let Some(first) = same.first() else {
        let mut ids: Vec<&str> = all.iter().map(|known| known.id).collect();
        ids.dedup();
        let (found, legal) = (format!("unknown effect {}", quote(id)), format!("one of {}", ids.join(", ")));
        source.expect(id_line, "id", found, legal, "correct the id or delete the entry");
        return None;
    };
    let shapes: Vec<&str> = same.iter().filter_map(|known| known.shape).collect();
    let legal = format!("one of {}", shapes.join(", "));
    let Some(shape) = table.get("shape") else {
        if first.shape.is_some() {
            source.expect(
                id_line,
                "shape",
                format!("{id} without shape"),
                legal,
                "add a line shape = \"...\"",
            );
        }
        return first.shape.is_none().then_some(*first);
    };
    if shapes.is_empty() {
        let found = format!("{id} with a shape");
        source.refuse(shape.line, "shape", found, "delete the line: an effect of the catalogue has none");
        return None;
    }
    let name = shape.text("the shape of a term without a name")?;
    let found = same.iter().copied().find(|known| known.shape == Some(name));
    if found.is_none() {
        let advice = "correct the shape or delete the entry";
        source.expect(shape.line, "shape", format!("unknown shape {}", quote(name)), legal, advice);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    const TERM: &str = "[plant]\ninertia_kg_m2 = 0.1705\n\n[[effect]]\nid = \"unlisted\"\nshape = \"of_q\"\n\
        c1_N_m = -0.02\nscale_q_rad_s = 0.3\nscale_theta_rad = 0.1\nscale_u = 0.015\nduration_s = 100\n";

    fn table() -> [KnownEffect; 3] {
        let scale = |&name| (name, Legal::positive(""));
        let parameters: Vec<_> =
            std::iter::once(("c1_N_m", Legal::any("N m"))).chain(SCALES.iter().map(scale)).collect();
        let of_q = KnownEffect { id: "unlisted", shape: Some("of_q"), parameters: parameters.clone() };
        [
            KnownEffect { id: "gravity_stiffness", shape: None, parameters: vec![("G", Legal::any("N m"))] },
            of_q,
            KnownEffect { id: "unlisted", shape: Some("of_u"), parameters },
        ]
    }

    #[test]
    fn a_term_without_a_name_reads_back_and_its_remark_is_a_comment() {
        let mut model = parse("m.toml", TERM, None, &table()).unwrap();
        assert_eq!(model.effects[0].shape.as_deref(), Some("of_q"));
        assert_eq!(model.effects[0].parameters["duration_s"], 100.0);
        let parameters = [("G".to_owned(), 0.4)].into();
        let gravity = EffectEntry { id: "gravity_stiffness".into(), shape: None, parameters, remark: None };
        model.effects.insert(0, gravity);
        model.effects[1].remark = Some("a moment of the rate".into());
        let text = model.to_toml().unwrap();
        assert!(text.contains("\n# a moment of the rate\n[[effect]]\nid = \"unlisted\"\n"), "{text}");
        model.effects[1].remark = None;
        assert_eq!(parse("m.toml", &text, None, &table()).unwrap(), model, "{text}");
    }

    #[test]
    fn malformed_terms_name_line_key_and_advice() {
        let cases = [
            (("\"of_q\"", "\"of_x\""), 6, "shape: unknown shape \"of_x\"\n  expected: one of of_q, of_u"),
            (("\"of_q\"", "3"), 6, "shape: found 3\n  expected: the shape"),
            (("shape = \"of_q\"\n", ""), 5, "unlisted without shape\n  expected: one of of_q, of_u"),
            (("\"unlisted\"", "\"gravity_stiffness\""), 6, "gravity_stiffness with a shape"),
            (("\"unlisted\"", "\"listed\""), 5, "one of gravity_stiffness, unlisted\n"),
            (("scale_u = 0.015\n", ""), 5, "unlisted without scale_u"),
            (("scale_u = 0.015", "scale_u = 0"), 10, "scale_u: found 0\n  expected: a number above 0"),
            (("c1_N_m = -0.02", "c1_N_m = [1]"), 7, "c1_N_m: found [1]\n  expected: a number from -1e12"),
            (("c1_N_m = -0.02", "c1_N_m = 1e13"), 7, "c1_N_m: found 1e13"),
        ];
        for ((from, to), line, part) in cases {
            let text = TERM.replacen(from, to, 1);
            let error = parse("m.toml", &text, None, &table()).expect_err(&text);
            let message = error.to_string();
            assert_eq!(error.line, Some(line), "{message}");
            assert!(message.contains(part) && message.contains("advice: "), "{part} is not in\n{message}");
        }
    }
}
