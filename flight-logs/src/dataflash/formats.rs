//! What a DataFlash message holds: one format character for each column.

use crate::bytes::Number;

/// How a column is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// A number, times a factor.
    Number(Number, f64),
    /// `a`: 32 numbers i16.
    Array,
    /// Text of so many bytes.
    Text(usize),
}

/// Numbers in an array.
pub(super) const ARRAY: usize = 32;

/// A column of a message.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Bytes after the head and the type.
    pub(super) at: usize,
}

/// A type of message.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Definition {
    pub(super) name: String,
    /// With head and type.
    pub(super) length: usize,
    pub(super) columns: Vec<Column>,
    /// Whether the columns are known and fill the length; a text log can do without.
    pub(super) usable: bool,
    /// The column that holds the time since start, and what one second is in its unit.
    pub(super) time: Option<(usize, f64)>,
}

impl Definition {
    pub(super) fn new(name: &str, length: usize, format: &str, columns: &str) -> Self {
        let names: Vec<&str> = columns.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
        let kinds: Option<Vec<Kind>> = format.bytes().map(kind).collect();
        let mut at = 0;
        let mut found = Vec::new();
        for (&name, &kind) in names.iter().zip(kinds.as_deref().unwrap_or_default()) {
            found.push(Column { name: name.to_owned(), kind, at });
            at += size(kind);
        }
        let usable = kinds.is_some_and(|kinds| kinds.len() == names.len()) && at + 3 == length;
        let time = time(name, &names).filter(|&(index, _)| index < found.len());
        Self { name: name.to_owned(), length: length.max(3), columns: found, usable, time }
    }

    /// The same in a text log, where modes are words, and an array is one cell.
    pub(super) fn in_text(name: &str, length: usize, format: &str, columns: &str) -> Self {
        Self::new(name, length, &format.replace(['a', 'M'], "Z"), columns)
    }

    /// The columns but the time, each with its place.
    pub(super) fn channels(&self) -> impl Iterator<Item = (usize, &Column)> {
        let time = self.time.map(|(index, _)| index);
        self.columns.iter().enumerate().filter(move |&(index, _)| Some(index) != time)
    }
}

fn time(message: &str, columns: &[&str]) -> Option<(usize, f64)> {
    let column = |name: &str| columns.iter().position(|&column| column == name);
    // In the GPS messages of old logs TimeMS is the time of the week; the time since start is T.
    let since_start = if message == "GPS" && column("T").is_some() { "T" } else { "TimeMS" };
    column("TimeUS").map(|index| (index, 1e6)).or_else(|| column(since_start).map(|index| (index, 1e3)))
}

fn kind(character: u8) -> Option<Kind> {
    Some(match character {
        b'a' => Kind::Array,
        b'b' => Kind::Number(Number::I8, 1.0),
        b'B' | b'M' => Kind::Number(Number::U8, 1.0),
        b'h' => Kind::Number(Number::I16, 1.0),
        b'H' => Kind::Number(Number::U16, 1.0),
        b'i' => Kind::Number(Number::I32, 1.0),
        b'I' => Kind::Number(Number::U32, 1.0),
        b'q' => Kind::Number(Number::I64, 1.0),
        b'Q' => Kind::Number(Number::U64, 1.0),
        b'g' => Kind::Number(Number::F16, 1.0),
        b'f' => Kind::Number(Number::F32, 1.0),
        b'd' => Kind::Number(Number::F64, 1.0),
        b'c' => Kind::Number(Number::I16, 0.01),
        b'C' => Kind::Number(Number::U16, 0.01),
        b'e' => Kind::Number(Number::I32, 0.01),
        b'E' => Kind::Number(Number::U32, 0.01),
        b'L' => Kind::Number(Number::I32, 1e-7),
        b'n' => Kind::Text(4),
        b'N' => Kind::Text(16),
        b'Z' => Kind::Text(64),
        _ => return None,
    })
}

fn size(kind: Kind) -> usize {
    match kind {
        Kind::Number(number, _) => number.size(),
        Kind::Array => 2 * ARRAY,
        Kind::Text(length) => length,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_character() {
        let columns = (0..20).map(|i| format!("c{i}")).collect::<Vec<_>>().join(",");
        let length = 3 + 64 + 1 + 1 + 1 + 2 + 2 + 4 + 4 + 8 + 8 + 2 + 4 + 8 + 2 + 2 + 4 + 4 + 4 + 4 + 16;
        let definition = Definition::new("ALL", length, "abBMhHiIqQgfdcCeELnN", &columns);
        assert!(definition.usable, "{definition:?}");
        assert_eq!(definition.columns.last().map(|column| column.at), Some(length - 3 - 16));
    }

    #[test]
    fn a_definition_that_does_not_fit_is_not_used() {
        assert!(Definition::new("A", 11, "Q", "TimeUS").usable);
        assert!(!Definition::new("A", 12, "Q", "TimeUS").usable);
        assert!(!Definition::new("A", 11, "?", "TimeUS").usable);
        assert!(!Definition::new("A", 11, "Q", "TimeUS,B").usable);
        assert_eq!(Definition::new("GPS", 0, "II", "TimeMS,T").time, Some((1, 1e3)));
    }
}
