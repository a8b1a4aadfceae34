//! The one error of this crate: what was found, where, what was expected, and what to do about it.

use std::fmt;

/// Where in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Bytes from its start.
    Offset(usize),
    /// Line, counted from 1.
    Line(usize),
}

/// An error for people: [`Display`](fmt::Display) gives the whole message in one to three lines.
///
/// ```text
/// flight.ulg, offset 16: found flags 0x02
///   expected: no flag but appended data (0x01)
///   advice: read the log with the flight stack's own tools
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", Message(self))]
#[non_exhaustive]
pub struct Error {
    /// The file, as it was named by the caller.
    pub file: Option<Box<str>>,
    /// Where in it.
    pub place: Option<Place>,
    /// What was found.
    pub found: Box<str>,
    /// What belongs there, where that can be said.
    pub expected: Option<Box<str>>,
    /// What to do about it.
    pub advice: Box<str>,
}

impl Error {
    pub(crate) fn new(found: impl Into<Box<str>>, advice: impl Into<Box<str>>) -> Self {
        Self { file: None, place: None, found: found.into(), expected: None, advice: advice.into() }
    }

    pub(crate) fn in_file(mut self, file: &str) -> Self {
        self.file = Some(file.into());
        self
    }

    pub(crate) fn at(mut self, place: Place) -> Self {
        self.place = Some(place);
        self
    }

    pub(crate) fn expecting(mut self, expected: impl Into<Box<str>>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    pub(crate) fn from_io(file: &str, error: &std::io::Error) -> Self {
        let (found, advice) = match error.kind() {
            std::io::ErrorKind::NotFound => ("no such file".into(), "check the name and the folder"),
            std::io::ErrorKind::IsADirectory => ("this is a directory".into(), "name a file inside it"),
            std::io::ErrorKind::PermissionDenied => {
                ("permission denied".into(), "check the rights of the file")
            }
            std::io::ErrorKind::FileTooLarge => (
                format!("more than {} MiB", crate::LARGEST >> 20),
                "check that it is the log that you mean; cut a longer one with its autopilot's own tools",
            ),
            _ => (format!("could not be read: {error}"), "check the file and its disk"),
        };
        Self::new(found, advice).in_file(file)
    }
}

struct Message<'a>(&'a Error);

impl fmt::Display for Message<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = self.0;
        let place = error.place.map(|place| match place {
            Place::Offset(offset) => format!("offset {offset}"),
            Place::Line(line) => format!("line {line}"),
        });
        let places: Vec<&str> = error.file.as_deref().into_iter().chain(place.as_deref()).collect();
        if !places.is_empty() {
            write!(f, "{}: ", places.join(", "))?;
        }
        write!(f, "{}", error.found)?;
        if let Some(expected) = &error.expected {
            write!(f, "\n  expected: {expected}")?;
        }
        write!(f, "\n  advice: {}", error.advice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_names_place_expectation_and_advice() {
        let error = Error::new("found flags 0x02", "read it elsewhere")
            .in_file("a.ulg")
            .at(Place::Offset(16))
            .expecting("none");
        assert_eq!(
            error.to_string(),
            "a.ulg, offset 16: found flags 0x02\n  expected: none\n  advice: read it elsewhere"
        );
    }
}
