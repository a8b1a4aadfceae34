//! Lines and the fields in them.

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::{missing, sniff, wall_clock};
use crate::error::{Error, ErrorKind, quote};

/// In place of a separator: runs of blanks.
pub(super) const BLANKS: u8 = b' ';

/// How a line is split.
#[derive(Clone, Copy)]
pub(super) struct Form {
    pub(super) separator: u8,
    /// Whether lines begin with a time of day that a terminal has put before them.
    pub(super) stamped: bool,
}

impl Form {
    /// The time of day before a line, where lines begin with one and this does, and the line without it.
    pub(super) fn unstamped<'l>(&self, line: &'l str) -> (Option<&'l str>, &'l str) {
        let stamp = if self.stamped { stamped(line) } else { None };
        stamp.map_or((None, line), |(stamp, rest)| (Some(stamp), rest))
    }
}

/// Splits one line into fields; the buffers are kept from line to line.
pub(super) struct Splitter {
    reader: Reader,
    pub(super) form: Form,
    /// The line with one separator where a terminal or a run of blanks has another.
    squeezed: String,
    bytes: Vec<u8>,
    ends: Vec<usize>,
    pub(super) fields: usize,
}

impl Splitter {
    pub(super) fn new(form: Form) -> Self {
        let reader = ReaderBuilder::new().delimiter(form.separator).build();
        let (squeezed, bytes, ends) = (String::new(), vec![0; 4096], vec![0; 256]);
        Self { reader, form, squeezed, bytes, ends, fields: 0 }
    }

    /// Splits `line` (without its line end) at the separators, quotes removed.
    pub(super) fn split(&mut self, line: &str) -> Result<(), Error> {
        let (stamp, rest) = self.form.unstamped(line);
        let blanks = self.form.separator == BLANKS;
        if blanks {
            self.squeeze(stamp.into_iter().chain(rest.split_whitespace()));
        } else if stamp.is_some() {
            self.squeeze(stamp.into_iter().chain([rest]));
        }
        let line = if blanks || stamp.is_some() { &self.squeezed } else { line };
        self.reader.reset();
        self.fields = 0;
        let (mut input, mut written, mut closed) = (line.as_bytes(), 0, false);
        loop {
            let (result, read, wrote, ended) =
                self.reader.read_record(input, &mut self.bytes[written..], &mut self.ends[self.fields..]);
            input = &input[read..];
            written += wrote;
            self.fields += ended;
            match result {
                ReadRecordResult::OutputFull => self.bytes.resize(2 * self.bytes.len(), 0),
                ReadRecordResult::OutputEndsFull => self.ends.resize(2 * self.ends.len(), 0),
                ReadRecordResult::InputEmpty if !closed => {
                    input = b"\n";
                    closed = true;
                }
                ReadRecordResult::InputEmpty => {
                    let advice = "close the quote on the same line, or delete it";
                    return Err(Error::new(ErrorKind::Format, "a quote is opened and not closed", advice));
                }
                ReadRecordResult::Record | ReadRecordResult::End => return Ok(()),
            }
        }
    }

    /// Puts one separator between these parts of a line.
    fn squeeze<'l>(&mut self, parts: impl Iterator<Item = &'l str>) {
        self.squeezed.clear();
        for (i, part) in parts.enumerate() {
            self.squeezed.extend((i > 0).then_some(char::from(self.form.separator)));
            self.squeezed.push_str(part);
        }
    }

    /// The field's text, trimmed.
    pub(super) fn field(&self, index: usize) -> &str {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        std::str::from_utf8(&self.bytes[start..self.ends[index]]).unwrap_or_default().trim()
    }

    /// The number in the field of the column called `column`; NaN where there is none. Where no comma separates columns, a comma is
    /// a decimal one.
    pub(super) fn number(&self, index: usize, column: &str) -> Result<f64, Error> {
        let cell = self.field(index);
        if self.form.separator != b',' && cell.bytes().filter(|&byte| byte == b',').count() == 1 {
            return number(&cell.replace(',', "."), cell, column);
        }
        number(cell, cell, column)
    }

    /// Whether the line has so many fields, or an empty one behind them, of a separator that ends it.
    pub(super) fn has_width(&self, fields: usize) -> bool {
        self.fields == fields || self.fields == fields + 1 && self.field(fields).is_empty()
    }
}

/// The time of day that a terminal has put before a line, and the line: `12:34:56.789 -> 1,2`, or a blank between.
pub(super) fn stamped(line: &str) -> Option<(&str, &str)> {
    let is_stamp = |stamp: &str| wall_clock::seconds(stamp).is_some();
    if let Some((stamp, rest)) = line.split_once(" -> ") {
        return is_stamp(stamp.trim()).then_some((stamp.trim(), rest));
    }
    let mut blanks = line.match_indices([' ', '\t']).take(2);
    blanks.find_map(|(at, _)| {
        let (stamp, rest) = (&line[..at], &line[at + 1..]);
        let is_table = rest.contains([',', ';']) && !sniff::is_between_blanks(rest);
        // "02:34:56 PM,1,2" is a table whose first column is the time
        let goes_on =
            || rest.split([',', ';']).next().is_some_and(|more| is_stamp(&format!("{stamp} {more}")));
        (is_table && is_stamp(stamp) && !goes_on()).then_some((stamp, rest))
    })
}

/// The lines that carry data or the header, with their numbers from 1; comments and blank lines are left out.
pub(super) fn content_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    numbered_lines(text).filter(|(_, line)| !is_comment(line) && !line.trim().is_empty())
}

/// All lines, with their numbers from 1.
pub(super) fn numbered_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let lines = text.split(separator).map(|line| line.strip_suffix('\r').unwrap_or(line));
    lines.enumerate().map(|(index, line)| (index + 1, line))
}

/// Whether a line is a comment, of a table or of MATLAB.
pub(super) fn is_comment(line: &str) -> bool {
    line.starts_with(['#', '%'])
}

/// The number in `text`, which stands as `cell` in the file; NaN where there is none.
fn number(text: &str, cell: &str, column: &str) -> Result<f64, Error> {
    let parsed = text.parse::<f64>();
    let (found, advice) = match parsed {
        Ok(raw) if raw.is_finite() => return Ok(raw),
        _ if missing::is_missing(cell) => return Ok(f64::NAN),
        Ok(raw) if raw.is_infinite() && !cell.to_ascii_lowercase().contains("inf") => (
            format!("{}, beyond any measurement", quote(cell)),
            "look for a broken logger or a wrong unit; correct the cell or delete the row",
        ),
        Ok(_) => (quote(cell), "empty the cell or delete the row: then it is a gap"),
        Err(_) => (quote(cell), sniff::number_advice(cell)),
    };
    Err(Error::new(ErrorKind::Value, format!("found {found}"), advice)
        .in_column(column)
        .expecting("a finite number"))
}
