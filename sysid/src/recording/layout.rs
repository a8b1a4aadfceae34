//! Where the names of a text file's columns stand, what separates the columns, and where the rows begin.

use super::assign::{Source, assign};
use super::fields::{BLANKS, Splitter, content_lines, is_comment, numbered_lines};
use super::options::ReadOptions;
use super::{Note, NoteKind, missing, sniff, wall_clock};
use crate::error::{Error, ErrorKind, quote};

/// Lines in which the first row is looked for.
const HEAD: usize = 100;

/// How the lines of a file make a table.
pub(super) struct Layout<'t> {
    /// What splits the names and the rows.
    pub(super) splitter: Splitter,
    /// Of the columns; c1, c2, ... from the left where the file has none.
    pub(super) names: Vec<String>,
    /// Number and text of the line with the names.
    pub(super) names_stand: Option<(usize, &'t str)>,
    /// Number of the line at which the rows begin.
    pub(super) rows_from: usize,
    /// Lines with something in them, above the names and between them and the rows.
    unread: Vec<(usize, &'t str)>,
    first: (usize, &'t str),
}

impl<'t> Layout<'t> {
    /// Finds the first row: a line of as many fields as the next, with a number over a number and no text over one. The names are the
    /// first line, or where that has not as many fields the nearest lines above the row that do, or a comment right above it that does.
    pub(super) fn read(text: &'t str) -> Result<Self, Error> {
        let head: Vec<(usize, &str)> = content_lines(text).take(HEAD).collect();
        let Some(&first) = head.first() else {
            let advice = "check that the logger has written it";
            return Err(Error::new(ErrorKind::Format, "only comments and blank lines", advice)
                .expecting("a header line and one line per sample"));
        };
        let below = head.get(1).map_or("", |(_, line)| *line);
        let found = head.windows(2).enumerate().find_map(|(place, pair)| {
            let separator = sniff::separator(pair[0].1, pair[1].1);
            let [fields, below] = [pair[0].1, pair[1].1].map(|line| Fields::of(line, separator));
            fields?.begins_rows(&below?).then_some((place, separator))
        });
        let (row, separator) = found.unwrap_or_else(|| {
            let separator = sniff::separator(first.1, below);
            let is_row = Fields::of(first.1, separator).is_some_and(|fields| fields.are_numbers());
            (usize::from(!is_row), separator)
        });
        let splitter = Splitter::new(separator);
        let Some(width) = head.get(row).and_then(|(_, line)| Fields::of(line, separator)).map(|f| f.0.len())
        else {
            return Self::with_names_in(&head, 0, 1, splitter);
        };
        let ends_empty =
            Fields::of(head[row].1, separator).is_some_and(|f| f.0.last().is_some_and(String::is_empty));
        let has_width = |f: &Fields| f.0.len() == width || ends_empty && f.0.len() + 1 == width;
        let of_width = |line: &str| Fields::of(line, separator).filter(has_width);
        let comment = || {
            let above = numbered_lines(text).take_while(|(number, _)| *number < head[row].0).last();
            let (number, line) = above.filter(|(_, line)| is_comment(line))?;
            let line = line.trim_start_matches(['#', '%', ' ']);
            of_width(line).filter(Fields::have_no_number).map(|fields| (number, line, fields))
        };
        let above = (0..row).rev().take_while(|&place| of_width(head[place].1).is_some()).last();
        let is_preamble = |line: &str| {
            separator == BLANKS || Fields::of(line, separator).is_some_and(|fields| fields.0.len() == 1)
        };
        match above {
            Some(0) => Self::with_names_in(&head, 0, row, splitter),
            Some(top) => {
                let bare = |&place: &usize| of_width(head[place].1).is_some_and(|f| f.have_no_number());
                let names = (top..row).find(bare).unwrap_or(0);
                Self::with_names_in(&head, names, row, splitter)
            }
            None if row > 0 && !is_preamble(first.1) => Self::with_names_in(&head, 0, row, splitter),
            None => {
                let named = comment();
                let names_stand = named.as_ref().map(|(number, line, _)| (*number, *line));
                let by_place = || (1..=width).map(|place| format!("c{place}")).collect();
                let names = named.map_or_else(by_place, |(.., fields)| fields.0);
                let (unread, rows_from) = (head[..row].to_vec(), head[row].0);
                Ok(Self { splitter, names, names_stand, rows_from, unread, first })
            }
        }
    }

    /// The names in the line at `place` of the first lines, rows at the first below it with a number, no later than at `row`.
    fn with_names_in(
        head: &[(usize, &'t str)],
        place: usize,
        row: usize,
        mut splitter: Splitter,
    ) -> Result<Self, Error> {
        let (line, text) = head[place];
        splitter.split(text).map_err(|error: Error| error.at_line(line))?;
        let names = (0..splitter.fields).map(|i| splitter.field(i).to_owned()).collect();
        let has_number = |&at: &usize| {
            let fields = head.get(at).and_then(|(_, line)| Fields::of(line, splitter.separator));
            fields.is_none_or(|fields| !fields.have_no_number())
        };
        let row = (place + 1..row).find(has_number).unwrap_or(row);
        let rows_from = head.get(row).map_or(line + 1, |(number, _)| *number);
        let unread = [&head[..place], head.get(place + 1..row).unwrap_or(&[])].concat();
        Ok(Self { splitter, names, names_stand: Some(head[place]), rows_from, unread, first: head[0] })
    }

    /// The columns that play a role.
    pub(super) fn assigned(
        &self,
        options: &ReadOptions,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<Source>, Error> {
        let Some((line, _)) = self.names_stand else {
            if options.columns.is_empty() {
                let (line, text) = self.first;
                let found = match text {
                    _ if line == self.rows_from => {
                        format!("a row of numbers where the header belongs: {}", quote(text))
                    }
                    _ => format!("no line that names the {} columns", self.names.len()),
                };
                let advice = format!(
                    "say which column is which, from the left c1 to c{}, as in --column t_s=c1 --column u_norm=c2 --column theta_deg=c3; or \
                     put a first line with the column names, e.g. t_s,u_rad,q_rad_s",
                    self.names.len()
                );
                return Err(Error::new(ErrorKind::Column, found, advice).at_line(line));
            }
            let text =
                format!("the file has no header: from the left its columns are c1 to c{}", self.names.len());
            notes.push(Note::new(NoteKind::Converted, text));
            return self.assign(self.rows_from, options, notes);
        };
        self.assign(line, options, notes)
    }

    fn assign(
        &self,
        line: usize,
        options: &ReadOptions,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<Source>, Error> {
        if let [(first, text), ..] = self.unread[..] {
            let more = match self.unread.len() - 1 {
                0 => String::new(),
                some => format!(" and {some} more without numbers for its columns"),
            };
            let text = format!("line {first} is not of the table: {}{more}", quote(text));
            notes.push(Note::new(NoteKind::Ignored, text));
        }
        if self.splitter.separator == BLANKS {
            notes.push(Note::new(NoteKind::Converted, "columns separated by blanks"));
        } else if self.splitter.separator != b',' {
            let by = if self.splitter.separator == b';' { "semicolons" } else { "tabs" };
            let text = format!("columns separated by {by}: a comma in a number is a decimal one");
            notes.push(Note::new(NoteKind::Converted, text));
        }
        assign(&self.names, &options.columns, notes).map_err(|error| error.at_line(line))
    }
}

/// What stands in a line.
struct Fields(Vec<String>);

impl Fields {
    fn of(line: &str, separator: u8) -> Option<Self> {
        let mut splitter = Splitter::new(separator);
        splitter.split(line).ok()?;
        Some(Self((0..splitter.fields).map(|i| splitter.field(i).to_owned()).collect()))
    }

    /// Whether this is a row over another: as many fields, a number over a number, no text over one.
    fn begins_rows(&self, below: &Self) -> bool {
        let pairs = || self.0.iter().zip(&below.0);
        self.0.len() == below.0.len()
            && pairs().any(|(above, below)| is_number(above) && is_number(below))
            && pairs()
                .all(|(above, below)| is_number(above) || missing::is_missing(above) || !is_number(below))
    }

    fn are_numbers(&self) -> bool {
        !self.have_no_number() && self.0.iter().all(|field| is_number(field) || missing::is_missing(field))
    }

    fn have_no_number(&self) -> bool {
        !self.0.iter().any(|field| is_number(field))
    }
}

fn is_number(field: &str) -> bool {
    field.replace(',', ".").parse::<f64>().is_ok_and(f64::is_finite) || wall_clock::seconds(field).is_some()
}
