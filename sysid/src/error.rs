//! The one error of this crate: what was found, where, what was expected, and what to do about it.

use std::fmt;

/// What kind of thing went wrong, for a caller that has to act on it; people read the message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The file is absent, is a directory, or could not be read or written.
    File,
    /// The bytes are not a recording or a model at all: binary, another encoding, another separator.
    Format,
    /// A column that must be there is missing, double or contradictory.
    Column,
    /// A cell or a key holds something else than the number that belongs there.
    Value,
    /// Time stamps stand still, run backwards, or have an impossible step.
    Clock,
    /// Fewer samples than needed.
    TooShort,
    /// An option that the caller gave cannot be used.
    Options,
    /// A section that was asked for is not in the recording.
    Section,
    /// A model file or the vehicle's with an unknown key, effect or parameter, or a value outside its legal range.
    Model,
    /// A computation that has no usable result on these data (singular, unstable, not convergent).
    Numerical,
}

/// An error for people: [`Display`](fmt::Display) gives the whole message in one to three lines.
///
/// ```text
/// flight.csv, line 12, column q_rad_s: found "abc"
///   expected: a number
///   advice: correct the cell, or delete the row
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", Message(self))]
#[non_exhaustive]
pub struct Error {
    /// What kind of thing went wrong.
    pub kind: ErrorKind,
    /// The file, as it was named by the caller.
    pub file: Option<Box<str>>,
    /// The line of the file, counted from 1.
    pub line: Option<usize>,
    /// The name of the column (of a recording) or key (of a model file or the vehicle's).
    pub column: Option<Box<str>>,
    /// What was found.
    pub found: Box<str>,
    /// What belongs there, where that can be said.
    pub expected: Option<Box<str>>,
    /// What to do about it.
    pub advice: Box<str>,
    /// What else is wrong with the same file; none where this is all.
    pub also: Option<Box<Also>>,
}

/// What else is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Also {
    /// In order of the lines; at most [`Error::MOST_TOLD`] with the one that has these beside it.
    pub errors: Vec<Error>,
    /// How many more there are that are not in the list.
    pub more: usize,
}

impl Error {
    /// Errors of one file that are told in one run.
    pub const MOST_TOLD: usize = 20;

    /// An error with neither place nor expectation; `found` and `advice` are phrases without a full stop.
    #[must_use]
    pub fn new(kind: ErrorKind, found: impl Into<Box<str>>, advice: impl Into<Box<str>>) -> Self {
        Self {
            kind,
            file: None,
            line: None,
            column: None,
            found: found.into(),
            expected: None,
            advice: advice.into(),
            also: None,
        }
    }

    /// The first of several errors of one file, with the others; `count` is how many there are in all.
    #[must_use]
    pub fn of_several(errors: Vec<Self>, count: usize) -> Option<Self> {
        let mut errors = errors.into_iter();
        let first = errors.next()?;
        let errors: Vec<Self> = errors.take(Self::MOST_TOLD - 1).collect();
        let more = count.saturating_sub(1 + errors.len());
        let also = (!errors.is_empty()).then(|| Box::new(Also { errors, more }));
        Some(Self { also, ..first })
    }

    /// What else is wrong, a line each: place and what was found.
    pub fn others(&self) -> impl Iterator<Item = String> + '_ {
        self.also.iter().flat_map(|also| {
            let legal = |error: &Self| match &error.expected {
                Some(expected) if error.kind == ErrorKind::Model => format!("; expected {expected}"),
                _ => String::new(),
            };
            let told = also.errors.iter().map(move |error| error.in_short() + &legal(error));
            told.chain((also.more > 0).then(|| format!("and {} more", also.more)))
        })
    }

    /// Place and what was found, without advice.
    pub(crate) fn in_short(&self) -> String {
        format!("{}{}", Place(self), self.found)
    }

    /// Names the file.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<Box<str>>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// Names the line, counted from 1.
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// Names the column or key.
    #[must_use]
    pub fn in_column(mut self, column: impl Into<Box<str>>) -> Self {
        self.column = Some(column.into());
        self
    }

    /// Says what belongs there.
    #[must_use]
    pub fn expecting(mut self, expected: impl Into<Box<str>>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    /// A file that could not be opened, read or written, with the reason the system gives.
    #[must_use]
    pub fn from_io(file: &str, error: &std::io::Error) -> Self {
        let (found, advice) = match error.kind() {
            std::io::ErrorKind::NotFound => ("no such file".into(), "check the name and the folder"),
            std::io::ErrorKind::IsADirectory => ("this is a directory".into(), "name a file inside it"),
            std::io::ErrorKind::PermissionDenied => {
                ("permission denied".into(), "check the rights of the file")
            }
            _ => (format!("could not be read or written: {error}"), "check the file and its disk"),
        };
        Self::new(ErrorKind::File, found, advice).in_file(file)
    }
}

/// Where it is, with a colon behind; nothing where that is not known.
struct Place<'a>(&'a Error);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = self.0;
        let mut place = Vec::new();
        place.extend(error.file.as_deref().map(str::to_owned));
        place.extend(error.line.map(|line| format!("line {line}")));
        let what = if error.kind == ErrorKind::Model { "key" } else { "column" };
        place.extend(error.column.as_deref().map(|column| format!("{what} {column}")));
        if place.is_empty() { Ok(()) } else { write!(f, "{}: ", place.join(", ")) }
    }
}

struct Message<'a>(&'a Error);

impl fmt::Display for Message<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = self.0;
        write!(f, "{}{}", Place(error), error.found)?;
        if let Some(expected) = &error.expected {
            write!(f, "\n  expected: {expected}")?;
        }
        write!(f, "\n  advice: {}", error.advice)?;
        error.others().try_for_each(|other| write!(f, "\n  also: {other}"))
    }
}

/// Names for a message: those most like `wanted` first, cut after the twelfth.
#[must_use]
pub fn nearest<'n>(names: impl IntoIterator<Item = &'n str>, wanted: &str) -> String {
    const MOST: usize = 12;
    let lower = wanted.to_lowercase();
    let likeness = |name: &str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &lower);
    let mut names: Vec<(f64, &str)> = names.into_iter().map(|name| (likeness(name), name)).collect();
    names.sort_by(|a, b| b.0.total_cmp(&a.0));
    let shown = names.iter().take(MOST);
    let mut listed: Vec<String> =
        shown.map(|(_, name)| name.chars().take(40).flat_map(char::escape_debug).collect()).collect();
    if names.len() > MOST {
        listed.push(format!("and {} more", names.len() - MOST));
    }
    listed.join(", ")
}

/// A piece of foreign text as it may stand in a message: quoted, control characters escaped, cut short.
#[must_use]
pub fn quote(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    format!("\"{shown}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_names_place_expectation_and_advice() {
        let error = Error::new(ErrorKind::Value, "found \"abc\"", "correct the cell")
            .in_file("a.csv")
            .at_line(3)
            .in_column("u_rad")
            .expecting("a number");
        assert_eq!(
            error.to_string(),
            "a.csv, line 3, column u_rad: found \"abc\"\n  expected: a number\n  advice: correct the cell"
        );
    }

    #[test]
    fn the_likest_names_come_first() {
        let names = ["t_s", "battery", "gyro_x", "Gyro_Y", "u"];
        assert!(nearest(names, "gyro_y").starts_with("Gyro_Y, gyro_x, "), "{}", nearest(names, "gyro_y"));
        let many: Vec<String> = (0..20).map(|k| format!("m{k}")).collect();
        assert!(nearest(many.iter().map(String::as_str), "m7").ends_with(", and 8 more"));
    }

    #[test]
    fn quoted_text_stays_on_one_short_line() {
        assert_eq!(quote("a\nb"), "\"a\\nb\"");
        assert_eq!(quote(&"x".repeat(100)).chars().count(), 43);
    }
}
