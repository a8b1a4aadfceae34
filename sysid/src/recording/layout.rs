//! Where the names of a text file's columns stand, what separates the columns, and where the rows begin.

use super::assign::{Source, assign};
use super::columns::Role;
use super::fields::{BLANKS, Form, Splitter, content_lines, is_comment, numbered_lines, stamped};
use super::options::{ColumnMap, ReadOptions};
use super::{Note, NoteKind, missing, sniff, wall_clock};
use crate::error::{Error, ErrorKind, quote};
use std::collections::BTreeSet;

/// Lines in which the first row is looked for.
const HEAD: usize = 1000;
/// Lines below it by which it is judged, and above it in which the names are looked for.
const NEAR: usize = 20;
/// Share of them that are rows like it.
const MOST: f64 = 0.75;

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
    /// Finds the first row ([`Rows`]). The names are in the nearest lines above it that have as many fields, or in a comment right
    /// above it, and where there are several in that with a name of the format or one of those that are `asked` for; in the first line
    /// where nothing but rows stands between.
    pub(super) fn read(text: &'t str, asked: &[ColumnMap]) -> Result<Self, Error> {
        let is_wanted = |names: &[String]| {
            let asked = |name: &String| asked.iter().any(|map| map.source.names().contains(name));
            names.iter().any(|name| Role::of(name).is_some() || asked(name))
        };
        let head: Vec<(usize, &str)> = content_lines(text).take(HEAD).collect();
        let Some(&first) = head.first() else {
            let advice = "check that the logger has written it";
            return Err(Error::new(ErrorKind::Format, "only comments and blank lines", advice)
                .expecting("a header line and one line per sample"));
        };
        let Some(rows) = (0..head.len()).find_map(|place| Rows::at(&head, place)) else {
            let below = head.get(1).map_or("", |(_, line)| *line);
            let form = Form { separator: sniff::separator(first.1, below), stamped: false };
            let fields = Fields::of(first.1, form).filter(Fields::are_numbers);
            return match fields {
                Some(fields) => Ok(Self::by_place(&head, 0, fields.0.len(), form)),
                None => Self::with_names_in(&head, 0, 1, form),
            };
        };
        let Rows { first: row, form, width, .. } = rows;
        if let Some(place) = rows.names_above(&head, is_wanted) {
            return Self::with_names_in(&head, place, row, form);
        }
        let above: Vec<(usize, &str)> =
            numbered_lines(text).take_while(|(number, _)| *number < head[row].0).collect();
        let nothing = |line: &str| line.trim().is_empty();
        let comments = above.iter().rev().take_while(|(_, line)| is_comment(line) || nothing(line));
        let comments = comments.filter(|(_, line)| !nothing(line)).take(NEAR);
        let bare = |(number, line): &(usize, &'t str)| {
            let line = line.trim_start_matches(['#', '%', ' ', '\t']);
            rows.names(line).map(|names| (*number, line, names))
        };
        let mut named: Vec<_> = comments.filter_map(bare).collect();
        let best = named.iter().position(|(.., names)| is_wanted(names));
        if !named.is_empty() {
            let (number, line, names) = named.swap_remove(best.unwrap_or(0));
            let mut layout = Self::by_place(&head, row, width, form);
            (layout.names, layout.names_stand) = (names, Some((number, line)));
            return Ok(layout);
        }
        // a header of another width, below which nothing but rows stands, is told against every row
        let has_number =
            |(_, line): &(usize, &str)| Fields::of(line, form).is_some_and(|f| !f.have_no_number());
        let is_header = |line: &str| {
            form.separator != BLANKS
                && Fields::of(line, form).is_some_and(|f| f.0.len() > 1 && !f.are_numbers())
        };
        if row > 0 && is_header(first.1) && head[1..row].iter().all(has_number) {
            return Self::with_names_in(&head, 0, row, form);
        }
        let counted = Fields::of(head[row].1, form).is_some_and(|fields| fields.count_up());
        Ok(Self::by_place(&head, row + usize::from(counted), width, form))
    }

    /// Columns called by their places, rows at `row` of the first lines.
    fn by_place(head: &[(usize, &'t str)], row: usize, width: usize, form: Form) -> Self {
        Self {
            splitter: Splitter::new(form),
            names: (1..=width).map(|place| format!("c{place}")).collect(),
            names_stand: None,
            rows_from: head[row].0,
            unread: head[..row].to_vec(),
            first: head[0],
        }
    }

    /// The names in the line at `place` of the first lines, rows at the first below it with a number, no later than at `row`.
    fn with_names_in(head: &[(usize, &'t str)], place: usize, row: usize, form: Form) -> Result<Self, Error> {
        let (line, text) = head[place];
        let mut splitter = Splitter::new(form);
        splitter.split(text).map_err(|error: Error| error.at_line(line))?;
        let width = head.get(row).and_then(|(_, line)| Fields::of(line, form)).map(|fields| fields.0.len());
        let ends =
            |(_, line): &(usize, &str)| Fields::of(line, form).is_some_and(|fields| fields.end_empty());
        let ends_empty = head.get(row).is_some_and(ends);
        let names =
            Rows { first: row, form, width: width.unwrap_or(splitter.fields), ends_empty }.names(text);
        let names = names.unwrap_or_else(|| Fields::in_splitter(&splitter).0);
        let has_number = |&at: &usize| {
            let fields = head.get(at).and_then(|(_, line)| Fields::of(line, form));
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
                some => format!(" and {some} more"),
            };
            let text = format!("line {first} is not of the table: {}{more}", quote(text));
            notes.push(Note::new(NoteKind::Ignored, text));
        }
        let Form { separator, stamped } = self.splitter.form;
        if stamped {
            let text = "each line begins with a time of day: it is the column clock";
            notes.push(Note::new(NoteKind::Converted, text));
        }
        if separator == BLANKS {
            notes.push(Note::new(NoteKind::Converted, "columns separated by blanks"));
        } else if separator != b',' {
            let by = if separator == b';' { "semicolons" } else { "tabs" };
            let text = format!("columns separated by {by}: a comma in a number is a decimal one");
            notes.push(Note::new(NoteKind::Converted, text));
        }
        assign(&self.names, &options.columns, notes).map_err(|error| error.at_line(line))
    }
}

/// The rows of a table: where the first is, and how they are split.
struct Rows {
    /// Its place among the first lines.
    first: usize,
    form: Form,
    width: usize,
    /// Whether it ends with a separator.
    ends_empty: bool,
}

impl Rows {
    /// Whether the line at `place` is the first row: one of as many fields as the next, with a number over a number and no text over
    /// one, most of the lines below like it; where no names stand above it, none stand among those.
    fn at(head: &[(usize, &str)], place: usize) -> Option<Self> {
        let (line, below) = (head[place].1, head.get(place + 1)?.1);
        let (bare, stamped) = match (stamped(line), stamped(below)) {
            (Some((_, line)), Some((_, below))) => ([line, below], true),
            _ => ([line, below], false),
        };
        let form = Form { separator: sniff::separator(bare[0], bare[1]), stamped };
        let row = Fields::of(line, form)?;
        if !row.begins_rows(&Fields::of(below, form)?) {
            return None;
        }
        let rows = Self { first: place, form, width: row.0.len(), ends_empty: row.end_empty() };
        let below = &head[place + 1..head.len().min(place + 1 + NEAR)];
        let like =
            below.iter().filter(|(_, line)| Fields::of(line, form).is_some_and(|f| row.is_like(&f))).count();
        let names_below = || below.iter().any(|(_, line)| rows.names(line).is_some());
        let is_table = like as f64 >= MOST * below.len() as f64;
        (is_table && (!names_below() || rows.names_above(head, |_| false).is_some())).then_some(rows)
    }

    /// The line with the names: of the lines right above that have as many fields the first with a name that is wanted, or whose names
    /// are all there and differ, or the first of them; where each has a number, the uppermost if it is the file's first, or else the
    /// one above the rows.
    fn names_above(&self, head: &[(usize, &str)], is_wanted: impl Fn(&[String]) -> bool) -> Option<usize> {
        let is_rule = |line: &str| !line.contains(char::is_alphanumeric);
        let fits = |&place: &usize| is_rule(head[place].1) || self.has_width(head[place].1);
        let top = (0..self.first).rev().take(NEAR).take_while(fits).last()?;
        let named = (top..self.first).filter(|&place| !is_rule(head[place].1));
        let named: Vec<(usize, Vec<String>)> =
            named.filter_map(|place| Some((place, self.names(head[place].1)?))).collect();
        let differ = |names: &[String]| {
            names.iter().collect::<BTreeSet<_>>().len() == names.len() && !names.contains(&String::new())
        };
        let best = named.iter().find(|(_, names)| is_wanted(names));
        let best = best.or_else(|| named.iter().find(|(_, names)| differ(names))).or(named.first());
        match best {
            Some((place, _)) => Some(*place),
            None if top == 0 => Some(0).filter(|_| self.has_text(head[0].1)),
            None => Some(self.first - 1).filter(|&place| self.has_text(head[place].1)),
        }
    }

    fn has_width(&self, line: &str) -> bool {
        self.fields(line).is_some()
    }

    fn has_text(&self, line: &str) -> bool {
        Fields::of(line, self.form).is_some_and(|fields| !fields.are_numbers())
    }

    /// The fields of a line that has as many as the rows, or an empty one more or less at its end; before them what names the stamps.
    fn fields(&self, line: &str) -> Option<Vec<String>> {
        let (_, bare) = self.form.unstamped(line);
        let mut fields = Fields::of(bare, Form { stamped: false, ..self.form })?.0;
        if self.form.stamped {
            fields.insert(0, "clock".into());
        }
        if fields.len() == self.width + 1 && fields.last().is_some_and(String::is_empty) {
            fields.pop();
        }
        if self.ends_empty && fields.len() + 1 == self.width {
            fields.push(String::new());
        }
        (fields.len() == self.width).then_some(fields)
    }

    /// The same of a line that has no number, and not only cells without one.
    fn names(&self, line: &str) -> Option<Vec<String>> {
        let has_text = |fields: &[String]| fields.iter().any(|field| !missing::is_missing(field));
        self.fields(line).filter(|fields| !fields.iter().any(|field| is_number(field)) && has_text(fields))
    }
}

/// What stands in a line.
struct Fields(Vec<String>);

impl Fields {
    fn of(line: &str, form: Form) -> Option<Self> {
        let mut splitter = Splitter::new(form);
        splitter.split(line).ok()?;
        Some(Self::in_splitter(&splitter))
    }

    fn in_splitter(splitter: &Splitter) -> Self {
        Self((0..splitter.fields).map(|i| splitter.field(i).to_owned()).collect())
    }

    /// Whether this is a row over another: as many fields, a number over a number, no text over one.
    fn begins_rows(&self, below: &Self) -> bool {
        let pairs = || self.0.iter().zip(&below.0);
        self.0.len() == below.0.len()
            && pairs().any(|(above, below)| is_number(above) && is_number(below))
            && pairs()
                .all(|(above, below)| is_number(above) || missing::is_missing(above) || !is_number(below))
    }

    /// Whether another is as wide and has a number, or none, where this has one.
    fn is_like(&self, other: &Self) -> bool {
        let fits = |(own, other): (&String, &String)| {
            !is_number(own) || is_number(other) || missing::is_missing(other)
        };
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(fits)
    }

    fn end_empty(&self) -> bool {
        self.0.last().is_some_and(String::is_empty)
    }

    fn are_numbers(&self) -> bool {
        !self.have_no_number() && self.0.iter().all(|field| is_number(field) || missing::is_missing(field))
    }

    fn have_no_number(&self) -> bool {
        !self.0.iter().any(|field| is_number(field))
    }

    /// Whether they are 0, 1, 2, ...: what a table without names of its own is given, before them maybe an empty one for the index.
    fn count_up(&self) -> bool {
        let fields = if self.0.first().is_some_and(String::is_empty) { &self.0[1..] } else { &self.0[..] };
        fields.len() > 2 && fields.iter().enumerate().all(|(i, field)| *field == i.to_string())
    }
}

fn is_number(field: &str) -> bool {
    field.replace(',', ".").parse::<f64>().is_ok_and(f64::is_finite) || wall_clock::seconds(field).is_some()
}
