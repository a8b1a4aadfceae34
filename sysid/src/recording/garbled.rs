//! Lines that a serial link, a board that starts again or a full card has garbled: a few are gaps, more are an error.

use super::clock::counted;
use super::{Note, NoteKind};
use crate::error::Error;

/// Of so many lines one may be garbled.
const LINES_PER_GARBLED: usize = 100;
/// Garbled lines that a note tells.
const TOLD: usize = 5;

/// Whether so many garbled lines of `all` are few.
pub(super) fn are_few(garbled: usize, all: usize) -> bool {
    garbled * LINES_PER_GARBLED <= all
}

/// What is wrong with the rows.
#[derive(Default)]
pub(super) struct Wrong {
    /// The first of them.
    errors: Vec<Error>,
    count: usize,
    /// Lines that they stand in.
    lines: usize,
    last: usize,
}

impl Wrong {
    /// One more, in this line; lines come in order.
    pub(super) fn add(&mut self, error: Error, line: usize) {
        self.count += 1;
        self.lines += usize::from(line != self.last);
        self.last = line;
        if self.errors.len() < Error::MOST_TOLD {
            self.errors.push(error.at_line(line));
        }
    }

    /// What is to be told of it, of so many rows: a note where it is little, which is missing then, and else the error.
    pub(super) fn of(self, rows: usize) -> Result<Option<Note>, Error> {
        if !are_few(self.lines, rows) {
            return Error::of_several(self.errors, self.count).map_or(Ok(None), Err);
        }
        let mut told: Vec<String> = self.errors.iter().take(TOLD).map(Error::in_short).collect();
        if self.count > told.len() {
            told.push("...".into());
        }
        let text = format!(
            "{} of {rows} garbled, what should stand there taken as missing: {}",
            counted(self.lines, "line"),
            told.join("; ")
        );
        Ok((self.lines > 0).then(|| Note::new(NoteKind::Missing, text)))
    }
}
