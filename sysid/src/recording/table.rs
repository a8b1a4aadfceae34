//! From bytes to columns of numbers: one pass over the lines, no allocation per cell.

use std::collections::BTreeMap;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::assign::{ROW, Source, assign};
use super::clock::counted;
use super::columns::{KNOWN_COLUMNS, Role};
use super::expression::Expression;
use super::garbled::Wrong;
use super::options::{ColumnMap, ReadOptions};
use super::{Note, NoteKind, missing, sniff};
use crate::error::{Error, ErrorKind, quote};

/// A number beyond this is no measurement in SI units.
pub(super) const LARGEST_VALUE: f64 = 1e9;
/// Time stamps may be nanoseconds since 1970; their unit is judged from the step.
pub(super) const LARGEST_TIME: f64 = 1e19;

/// One numeric column other than time, in SI units.
#[derive(Clone, Debug)]
pub(super) struct Signal {
    pub(super) source: Source,
    pub(super) values: Vec<f64>,
}

/// The rows of a file as they stand in it.
#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) t: Vec<f64>,
    pub(super) time: Source,
    pub(super) signals: Vec<Signal>,
    /// Per row an index into `label_names`; empty without a `section` column.
    pub(super) labels: Vec<u32>,
    pub(super) label_names: Vec<String>,
    /// Empty without a `supervised` column.
    pub(super) supervised: Vec<bool>,
    /// Line of the file of each row; empty where the rows come from no file of lines.
    pub(super) lines: Vec<u32>,
}

impl Default for Table {
    fn default() -> Self {
        Self {
            t: Vec::new(),
            time: Source::new(Role::Time, Expression::column(Role::Time.column()), vec![0], 1.0),
            signals: Vec::new(),
            labels: Vec::new(),
            label_names: Vec::new(),
            supervised: Vec::new(),
            lines: Vec::new(),
        }
    }
}

impl Table {
    /// The table of signals that are not read from lines; rows are counted from 1 in errors.
    pub(super) fn of_signals(t: Vec<f64>, signals: Vec<(ColumnMap, Vec<f64>)>) -> Result<Self, Error> {
        let mut table = Self { t, ..Self::default() };
        check_finite(&table.t, LARGEST_TIME, &table.time.name, table.t.len())?;
        for (index, (map, values)) in signals.into_iter().enumerate() {
            let Some((role, factor)) = Role::of(&map.target) else {
                let found = format!("{} is not a column of the format", quote(&map.target));
                let advice = format!("use one of {}", KNOWN_COLUMNS.join(", "));
                return Err(Error::new(ErrorKind::Column, found, advice));
            };
            let source = Source::new(role, map.source, vec![index], factor * map.factor);
            check_finite(&values, LARGEST_VALUE, &source.name, table.t.len())?;
            let values = values.into_iter().map(|value| factor * value).collect();
            if table.signals.iter().any(|s| s.source.role.same_slot(role)) {
                let found = format!("two signals for {}", map.target);
                return Err(Error::new(ErrorKind::Column, found, "give one"));
            }
            table.signals.push(Signal { source, values });
        }
        if !table.signals.iter().any(|s| matches!(s.source.role, Role::Q | Role::Theta)) {
            let found = "neither pitch rate nor pitch angle";
            return Err(Error::new(ErrorKind::Column, found, "give q_rad_s or theta_rad"));
        }
        Ok(table)
    }
}

impl Table {
    /// Removes the rows with these ascending indices.
    pub(super) fn remove(&mut self, rows: &[usize]) {
        remove_rows(&mut self.t, rows);
        remove_rows(&mut self.lines, rows);
        remove_rows(&mut self.labels, rows);
        remove_rows(&mut self.supervised, rows);
        self.signals.iter_mut().for_each(|signal| remove_rows(&mut signal.values, rows));
    }
}

/// Removes the rows with these ascending indices; a column that is not there stays empty.
fn remove_rows<T>(values: &mut Vec<T>, dropped: &[usize]) {
    let (mut row, mut next) = (0, dropped.iter().peekable());
    values.retain(|_| {
        let drop = next.next_if(|&&index| index == row).is_some();
        row += 1;
        !drop
    });
}

fn check_finite(values: &[f64], largest: f64, column: &str, rows: usize) -> Result<(), Error> {
    let refuse = |found: String, advice| Err(Error::new(ErrorKind::Value, found, advice).in_column(column));
    if values.len() != rows {
        return refuse(format!("{} values for {rows} times", values.len()), "give each time one value");
    }
    match values.iter().position(|value| !value.is_finite() || value.abs() > largest) {
        Some(row) => refuse(
            format!("found {} in row {}", values[row], row + 1),
            "leave out the rows without a measurement: a missing row is treated as a gap",
        ),
        None => Ok(()),
    }
}

/// Splits one line into fields; the buffers are kept from line to line.
struct Splitter {
    reader: Reader,
    separator: u8,
    bytes: Vec<u8>,
    ends: Vec<usize>,
    fields: usize,
}

impl Splitter {
    fn new(separator: u8) -> Self {
        let reader = ReaderBuilder::new().delimiter(separator).build();
        Self { reader, separator, bytes: vec![0; 4096], ends: vec![0; 256], fields: 0 }
    }

    /// Splits `line` (without its line end) at the separators, quotes removed.
    fn split(&mut self, line: &str) -> Result<(), Error> {
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

    /// The field's text, trimmed.
    fn field(&self, index: usize) -> &str {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        std::str::from_utf8(&self.bytes[start..self.ends[index]]).unwrap_or_default().trim()
    }

    /// The number in the field of the column called `column`; NaN where there is none. Where no comma separates columns, a comma is
    /// a decimal one.
    fn number(&self, index: usize, column: &str) -> Result<f64, Error> {
        let cell = self.field(index);
        if self.separator != b',' && cell.bytes().filter(|&byte| byte == b',').count() == 1 {
            return number(&cell.replace(',', "."), cell, column);
        }
        number(cell, cell, column)
    }
}

/// The lines that carry data or the header, with their numbers from 1; comments and blank lines are left out.
fn content_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let lines = text.split(separator).map(|line| line.strip_suffix('\r').unwrap_or(line));
    let numbered = lines.enumerate().map(|(index, line)| (index + 1, line));
    numbered.filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty())
}

/// The names of the columns.
pub(super) fn header(bytes: &[u8]) -> Result<Vec<String>, Error> {
    let text = sniff::text(bytes)?;
    let mut lines = content_lines(&text);
    Ok(Header::read(lines.next(), lines.next())?.names)
}

/// The first line.
struct Header {
    line: usize,
    /// What splits it and the rows below it.
    splitter: Splitter,
    names: Vec<String>,
    /// Whether it has no names but numbers, a row as all others; the names are then c1, c2, ... from the left.
    is_row: bool,
}

impl Header {
    fn read(first: Option<(usize, &str)>, below: Option<(usize, &str)>) -> Result<Self, Error> {
        let Some((line, text)) = first else {
            let advice = "check that the logger has written it";
            return Err(Error::new(ErrorKind::Format, "only comments and blank lines", advice)
                .expecting("a header line and one line per sample"));
        };
        let mut splitter = Splitter::new(sniff::separator(text, below.map_or("", |(_, row)| row)));
        splitter.split(text).map_err(|error: Error| error.at_line(line))?;
        let mut names: Vec<String> = (0..splitter.fields).map(|i| splitter.field(i).to_owned()).collect();
        let is_number = |name: &str| name.replace(',', ".").parse::<f64>().is_ok_and(f64::is_finite);
        let is_row = names.iter().any(|name| is_number(name))
            && names.iter().all(|name| is_number(name) || missing::is_missing(name));
        if is_row {
            names = (1..=splitter.fields).map(|place| format!("c{place}")).collect();
        }
        Ok(Self { line, splitter, names, is_row })
    }

    /// The columns that play a role.
    fn assigned(
        &self,
        text: &str,
        options: &ReadOptions,
        notes: &mut Vec<Note>,
    ) -> Result<Vec<Source>, Error> {
        let at_header = |error: Error| error.at_line(self.line);
        if self.is_row && options.columns.is_empty() {
            let found = format!("a row of numbers where the header belongs: {}", quote(text));
            let advice = format!(
                "say which column is which, from the left c1 to c{}, as in --column t_s=c1 --column u_norm=c2 --column theta_deg=c3; or put a \
                 first line with the column names, e.g. t_s,u_rad,q_rad_s",
                self.names.len()
            );
            return Err(at_header(Error::new(ErrorKind::Column, found, advice)));
        }
        if self.is_row {
            let text =
                format!("the file has no header: from the left its columns are c1 to c{}", self.names.len());
            notes.push(Note::new(NoteKind::Converted, text));
        }
        assign(&self.names, &options.columns, notes).map_err(at_header)
    }
}

/// Reads header and rows; errors carry line and column, the caller adds the file.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Vec<Note>) -> Result<Table, Error> {
    let text = sniff::text(bytes)?;
    let mut lines = content_lines(&text).peekable();
    let first = lines.next();
    let header = Header::read(first, lines.peek().copied())?;
    let header_length = first.map_or(1, |(_, line)| line.len().max(1));
    let sources = header.assigned(first.map_or("", |(_, line)| line), options, notes)?;
    let Header { mut splitter, names: header, is_row, .. } = header;
    let (first, row) = if is_row { (None, first) } else { (first, None) };
    let mut lines = row.into_iter().chain(lines).peekable();
    if splitter.separator != b',' {
        let by = if splitter.separator == b';' { "semicolons" } else { "tabs" };
        let text = format!("columns separated by {by}: a comma in a number is a decimal one");
        notes.push(Note::new(NoteKind::Converted, text));
    }
    let mut filler = Filler::new(header.clone(), sources, text.len() / header_length);
    let mut wrong = Wrong::default();
    let ends = text.ends_with(['\n', '\r']);
    // the header again is no row that was logged
    let (mut rows, mut headers) = (0, 0);
    while let Some((number, line)) = lines.next() {
        rows += 1;
        match splitter.split(line) {
            Err(error) => wrong.add(error, number),
            Ok(()) if first.is_some_and(|(_, header)| header == line) => {
                headers += 1;
                wrong.add(Error::new(ErrorKind::Format, "the header again", "delete the line"), number);
            }
            // whoever wrote it was cut off in the middle of a row
            Ok(()) if splitter.fields < header.len() && !ends && lines.peek().is_none() => {
                let (found, wanted) = (splitter.fields, header.len());
                let text = format!(
                    "line {number}, the last, is cut off after {found} of {wanted} fields and was left out"
                );
                notes.push(Note::new(NoteKind::Missing, text));
            }
            Ok(()) if splitter.fields != header.len() => {
                wrong.add(wrong_width(splitter.fields, header.len()), number);
            }
            Ok(()) => filler.push(&splitter, rows - 1 - headers, number, &mut wrong),
        }
    }
    notes.extend(wrong.of(rows)?);
    Ok(filler.table)
}

fn wrong_width(found: usize, expected: usize) -> Error {
    let advice = if found > expected {
        "delete what is too much (a decimal comma or a comma inside a text also splits a field: semicolons or tabs between columns let it stand), or name the columns"
    } else {
        "complete the row, or delete it: a log that was cut off often ends in half a row"
    };
    Error::new(ErrorKind::Format, counted(found, "field"), advice)
        .expecting(format!("{expected} fields, as the header has"))
}

/// Puts the cells of a row where they belong.
struct Filler {
    header: Vec<String>,
    table: Table,
    section: Option<Source>,
    supervised: Option<Source>,
    label_of: BTreeMap<String, u32>,
}

impl Filler {
    fn new(header: Vec<String>, sources: Vec<Source>, rows: usize) -> Self {
        let (mut section, mut supervised) = (None, None);
        let mut table = Table::default();
        for source in sources {
            match source.role {
                Role::Time => table.time = source,
                Role::Section => section = Some(source),
                Role::Supervised => supervised = Some(source),
                _ => table.signals.push(Signal { source, values: Vec::with_capacity(rows) }),
            }
        }
        Self { header, table, section, supervised, label_of: BTreeMap::new() }
    }

    /// The row at `place` among those that were logged, in this line.
    fn push(&mut self, row: &Splitter, place: usize, line: usize, wrong: &mut Wrong) {
        let table = &mut self.table;
        let mut take = |source: &Source, largest| match value(row, place, &self.header, source, largest) {
            Ok(value) => value,
            Err(error) => {
                wrong.add(error, line);
                f64::NAN
            }
        };
        table.t.push(take(&table.time, LARGEST_TIME));
        for signal in &mut table.signals {
            signal.values.push(take(&signal.source, LARGEST_VALUE));
        }
        if let Some(source) = &self.supervised {
            let before = table.supervised.last().copied().unwrap_or(false);
            table.supervised.push(flag(row, source, before).unwrap_or_else(|error| {
                wrong.add(error, line);
                before
            }));
        }
        if let Some(source) = &self.section {
            let label = match cell(row, source) {
                "" => "-",
                label => label,
            };
            let before = table.labels.last().copied();
            let same = before.filter(|&i| table.label_names[i as usize] == label);
            let known = same.or_else(|| self.label_of.get(label).copied());
            let index = known.unwrap_or_else(|| {
                let is_garbled = label.contains(['\0', char::REPLACEMENT_CHARACTER]);
                if is_garbled {
                    let found = format!("found {}", quote(label));
                    let error = Error::new(ErrorKind::Value, found, "write the name in UTF-8");
                    wrong.add(error.in_column(source.name.as_str()).expecting("the name of a section"), line);
                }
                before.filter(|_| is_garbled).unwrap_or_else(|| {
                    let name = if is_garbled { "-" } else { label };
                    let index = u32::try_from(table.label_names.len()).unwrap_or(u32::MAX);
                    table.label_names.push(name.to_owned());
                    self.label_of.insert(name.to_owned(), index);
                    index
                })
            });
            table.labels.push(index);
        }
        table.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
    }
}

/// The cell of a source that is one column.
fn cell<'r>(row: &'r Splitter, source: &Source) -> &'r str {
    source.places.first().map_or("", |&place| row.field(place))
}

/// What the expression of `source` gives in this row, which is the one at `place`, in SI units; NaN where a cell is missing or it
/// divides by zero.
fn value(
    row: &Splitter,
    place: usize,
    header: &[String],
    source: &Source,
    largest: f64,
) -> Result<f64, Error> {
    let name = |column: usize| header.get(column).map_or(ROW, String::as_str);
    let number = |column: usize| match column < header.len() {
        true => row.number(column, name(column)),
        false => Ok(place as f64),
    };
    let beyond = |found: String, column: &str| {
        let found = format!("{found}, beyond any measurement in this unit (±{largest:e})");
        let advice = "look for a broken logger or a wrong unit; correct the cell or delete the row";
        Err(Error::new(ErrorKind::Value, found, advice).in_column(column).expecting("a finite number"))
    };
    if let [column] = source.places[..]
        && source.expression.as_column().is_some()
    {
        let raw = number(column)?;
        let value = source.factor * raw;
        let fits = value.is_nan() || value.abs() <= largest;
        let found = || if column < header.len() { quote(row.field(column)) } else { raw.to_string() };
        return if fits { Ok(value) } else { beyond(format!("found {}", found()), name(column)) };
    }
    let cells = source.places.iter().map(|&column| number(column));
    let value = source.factor * source.expression.value(&cells.collect::<Result<Vec<f64>, Error>>()?);
    match value {
        _ if value.abs() <= largest => Ok(value),
        _ if !value.is_finite() => Ok(f64::NAN),
        _ => beyond(format!("{} gives {value}", source.name), source.role.column()),
    }
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

/// A flag; where there is none, as it was `before`.
fn flag(row: &Splitter, source: &Source, before: bool) -> Result<bool, Error> {
    let cell = cell(row, source);
    match cell {
        "0" => Ok(false),
        "1" => Ok(true),
        _ if missing::is_missing(cell) => Ok(before),
        _ => match cell.parse::<f64>() {
            Ok(0.0) => Ok(false),
            Ok(1.0) => Ok(true),
            _ => Err(Error::new(
                ErrorKind::Value,
                format!("found {}", quote(cell)),
                "write 1 where the supervisor overrode the excitation, else 0; or delete the column",
            )
            .in_column(source.name.as_str())
            .expecting("0 or 1")),
        },
    }
}
