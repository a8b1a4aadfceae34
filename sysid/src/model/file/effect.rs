//! `[[effect]]` of a model file: checked against the effects that there are.

use std::collections::BTreeMap;

use serde::Serialize;
use toml::{Spanned, Value};

use super::{AXES, Source, positive};
use crate::error::{Error, ErrorKind, quote};

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
    /// Names of its parameters, all of which must be given.
    pub parameters: Vec<&'static str>,
}

/// Keys of what the signals of a term without a name are divided by: pitch rate (rad/s), pitch angle (rad), input (its
/// unit) and time (s); each > 0.
pub const SCALES: [&str; 4] = ["scale_q_rad_s", "scale_theta_rad", "scale_u", "duration_s"];

/// An entry as it stands.
pub(super) type Raw = Spanned<BTreeMap<Spanned<String>, Spanned<Value>>>;

/// A value with its line.
type Placed<T> = (T, usize);

/// An entry whose values are numbers.
struct Parsed {
    axis: Option<String>,
    id: Placed<String>,
    shape: Option<Placed<String>>,
    parameters: BTreeMap<String, Placed<f64>>,
}

/// The entry, if it is one of `table` with all its parameters, and the axis that it is of; without one it is of all.
pub(super) fn checked(
    source: &Source,
    entry: Raw,
    table: &[KnownEffect],
) -> Result<(Option<String>, EffectEntry), Error> {
    let Parsed { axis, id: (id, id_line), shape, parameters } = parsed(source, entry)?;
    let known = find(table, (&id, id_line), shape.as_ref())?;
    let expected = format!("{id} with {}", known.parameters.join(", "));
    let unknown = parameters.iter().find(|(key, _)| !known.parameters.contains(&key.as_str()));
    if let Some((key, (_, line))) = unknown {
        return Err(
            wrong("unknown parameter", "correct the key or delete the line", *line, key).expecting(expected)
        );
    }
    if let Some(missing) = known.parameters.iter().find(|name| !parameters.contains_key(**name)) {
        let found = format!("{id} without {missing}");
        return Err(wrong(found, "add the parameter", id_line, missing).expecting(expected));
    }
    let none =
        |(key, (value, _)): &(&String, &Placed<f64>)| SCALES.contains(&key.as_str()) && !positive(*value);
    if let Some((key, (value, line))) = parameters.iter().find(none) {
        return Err(
            wrong(format!("found {value}"), "correct the value", *line, key).expecting("a number above 0")
        );
    }
    let parameters = parameters.into_iter().map(|(key, (value, _))| (key, value)).collect();
    Ok((axis, EffectEntry { id, shape: shape.map(|(shape, _)| shape), parameters, remark: None }))
}

fn wrong(found: impl Into<Box<str>>, advice: &str, line: usize, key: &str) -> Error {
    Error::new(ErrorKind::Model, found, advice).at_line(line).in_column(key)
}

fn parsed(source: &Source, entry: Raw) -> Result<Parsed, Error> {
    let line = source.line(entry.span().start);
    let (mut axis, mut id, mut shape) = (None, None, None);
    let mut parameters = BTreeMap::new();
    for (key, value) in entry.into_inner() {
        let (line, key) = (source.line(key.span().start), key.into_inner());
        let refuse = |expected: &str| {
            let found = format!("found {}", quote(&value.get_ref().to_string()));
            wrong(found, "correct the value", line, &key).expecting(expected)
        };
        match value.get_ref() {
            Value::String(text) if key == "axis" && AXES.contains(&text.as_str()) => {
                axis = Some(text.clone());
            }
            _ if key == "axis" => return Err(refuse(&format!("one of {}, in quotes", AXES.join(", ")))),
            Value::String(text) if key == "id" => id = Some((text.clone(), line)),
            _ if key == "id" => return Err(refuse("the id of an effect, in quotes")),
            Value::String(text) if key == "shape" => shape = Some((text.clone(), line)),
            _ if key == "shape" => return Err(refuse("the shape of a term without a name, in quotes")),
            Value::Float(number) if number.is_finite() => drop(parameters.insert(key, (*number, line))),
            Value::Integer(number) => drop(parameters.insert(key, (*number as f64, line))),
            _ => return Err(refuse("a finite number")),
        }
    }
    let advice = "add a line id = \"...\"";
    let id = id.ok_or_else(|| Error::new(ErrorKind::Model, "an effect without id", advice).at_line(line))?;
    Ok(Parsed { axis, id, shape, parameters })
}

/// The effect of `table` with this id and shape.
fn find<'t>(
    table: &'t [KnownEffect],
    (id, id_line): (&str, usize),
    shape: Option<&Placed<String>>,
) -> Result<&'t KnownEffect, Error> {
    let same: Vec<&KnownEffect> = table.iter().filter(|known| known.id == id).collect();
    let Some(first) = same.first() else {
        let mut ids: Vec<&str> = table.iter().map(|known| known.id).collect();
        ids.dedup();
        let found = format!("unknown effect {}", quote(id));
        return Err(wrong(found, "correct the id or delete the entry", id_line, "id")
            .expecting(format!("one of {}", ids.join(", "))));
    };
    let shapes: Vec<&str> = same.iter().filter_map(|known| known.shape).collect();
    match shape {
        None if first.shape.is_none() => Ok(first),
        None => Err(wrong(format!("{id} without shape"), "add a line shape = \"...\"", id_line, "shape")
            .expecting(format!("one of {}", shapes.join(", ")))),
        Some((_, line)) if shapes.is_empty() => {
            Err(wrong("unknown parameter", "correct the key or delete the line", *line, "shape")
                .expecting(format!("{id} with {}", first.parameters.join(", "))))
        }
        Some((shape, line)) => {
            same.iter().copied().find(|known| known.shape == Some(shape.as_str())).ok_or_else(|| {
                let found = format!("unknown shape {}", quote(shape));
                wrong(found, "correct the shape or delete the entry", *line, "shape")
                    .expecting(format!("one of {}", shapes.join(", ")))
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    const TERM: &str = "[plant]\ninertia_kg_m2 = 0.1705\n\n[[effect]]\nid = \"unlisted\"\nshape = \"of_q\"\n\
        c1_N_m = -0.02\nscale_q_rad_s = 0.3\nscale_theta_rad = 0.1\nscale_u = 0.015\nduration_s = 100\n";

    fn table() -> [KnownEffect; 3] {
        let parameters = [&["c1_N_m"], &SCALES[..]].concat();
        let of_q = KnownEffect { id: "unlisted", shape: Some("of_q"), parameters: parameters.clone() };
        [
            KnownEffect { id: "gravity_stiffness", shape: None, parameters: vec!["G"] },
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
            (("\"of_q\"", "3"), 6, "shape: found \"3\"\n  expected: the shape"),
            (("shape = \"of_q\"\n", ""), 5, "unlisted without shape\n  expected: one of of_q, of_u"),
            (("\"unlisted\"", "\"gravity_stiffness\""), 6, "expected: gravity_stiffness with G"),
            (("\"unlisted\"", "\"listed\""), 5, "one of gravity_stiffness, unlisted\n"),
            (("scale_u = 0.015\n", ""), 5, "unlisted without scale_u"),
            (("scale_u = 0.015", "scale_u = 0"), 10, "scale_u: found 0\n  expected: a number above 0"),
            (("c1_N_m = -0.02", "c1_N_m = [1]"), 7, "a finite number"),
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
