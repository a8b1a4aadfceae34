//! From bytes to columns of numbers: one pass over the lines, no allocation per cell.

use std::collections::BTreeMap;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::assign::{Source, assign};
use super::columns::{KNOWN_COLUMNS, Role};
use super::options::{ColumnMap, ReadOptions};
use super::{Note, sniff};
use crate::error::{Error, ErrorKind, quote};

/// A number beyond this is no measurement in SI units.
const LARGEST_VALUE: f64 = 1e9;
/// Time stamps may be nanoseconds since 1970; their unit is judged from the step.
const LARGEST_TIME: f64 = 1e19;

/// One numeric column other than time, in SI units.
#[derive(Clone, Debug)]
pub(super) struct Signal {
    pub(super) source: Source,
    pub(super) values: Vec<f64>,
}

/// The rows of a file as they stand in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    pub(super) t: Vec<f64>,
    pub(super) time_column: String,
    pub(super) signals: Vec<Signal>,
    /// Per row an index into `label_names`; empty without a `section` column.
    pub(super) labels: Vec<u32>,
    pub(super) label_names: Vec<String>,
    /// Empty without a `supervised` column.
    pub(super) supervised: Vec<bool>,
    /// Line of the file of each row; empty where the rows come from no file of lines.
    pub(super) lines: Vec<u32>,
}

impl Table {
    /// The table of signals that are not read from lines; rows are counted from 1 in errors.
    pub(super) fn of_signals(t: Vec<f64>, signals: Vec<(ColumnMap, Vec<f64>)>) -> Result<Self, Error> {
        let mut table = Self { t, time_column: Role::Time.column().to_owned(), ..Self::default() };
        check_finite(&table.t, LARGEST_TIME, &table.time_column, table.t.len())?;
        for (index, (map, values)) in signals.into_iter().enumerate() {
            let Some((role, factor)) = Role::of(&map.target) else {
                let found = format!("{} is not a column of the format", quote(&map.target));
                let advice = format!("use one of {}", KNOWN_COLUMNS.join(", "));
                return Err(Error::new(ErrorKind::Column, found, advice));
            };
            check_finite(&values, LARGEST_VALUE, &map.source, table.t.len())?;
            let values = values.into_iter().map(|value| factor * value).collect();
            let source = Source { role, index, name: map.source, factor: factor * map.factor };
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
    bytes: Vec<u8>,
    ends: Vec<usize>,
    fields: usize,
}

impl Splitter {
    fn new() -> Self {
        Self { reader: ReaderBuilder::new().build(), bytes: vec![0; 4096], ends: vec![0; 256], fields: 0 }
    }

    /// Splits `line` (without its line end) at commas, quotes removed.
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
}

/// The lines that carry data or the header, with their numbers from 1; comments and blank lines are left out.
fn content_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let lines = text.split(separator).map(|line| line.strip_suffix('\r').unwrap_or(line));
    let numbered = lines.enumerate().map(|(index, line)| (index + 1, line));
    numbered.filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty())
}

/// Reads header and rows; errors carry line and column, the caller adds the file.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Vec<Note>) -> Result<Table, Error> {
    let text = sniff::text(bytes)?;
    let mut lines = content_lines(text);
    let Some((header_line, header_text)) = lines.next() else {
        return Err(Error::new(
            ErrorKind::Format,
            "only comments and blank lines",
            "check that the logger has written it",
        )
        .expecting("a header line and one line per sample"));
    };
    let mut splitter = Splitter::new();
    let at_header = |error: Error| error.at_line(header_line);
    sniff::separator(header_text).map_err(at_header)?;
    splitter.split(header_text).map_err(at_header)?;
    let header: Vec<String> = (0..splitter.fields).map(|i| splitter.field(i).to_owned()).collect();
    if header.iter().all(|name| name.parse::<f64>().is_ok()) {
        let found = format!("a row of numbers where the header belongs: {}", quote(header_text));
        let advice = "put a first line with the column names, e.g. t_s,u_rad,q_rad_s";
        return Err(at_header(Error::new(ErrorKind::Column, found, advice)));
    }
    let sources = assign(&header, &options.columns, notes).map_err(at_header)?;
    let mut filler = Filler::new(sources, text.len() / header_text.len().max(1));
    for (number, line) in lines {
        splitter.split(line).map_err(|error| error.at_line(number))?;
        if splitter.fields != header.len() {
            return Err(wrong_width(splitter.fields, header.len()).at_line(number));
        }
        filler.push(&splitter, number).map_err(|error| error.at_line(number))?;
    }
    Ok(filler.table)
}

fn wrong_width(found: usize, expected: usize) -> Error {
    let advice = if found > expected {
        "delete what is too much (a decimal comma or a comma inside a text also splits a field), or name the columns"
    } else {
        "complete the row, or delete it: a log that was cut off often ends in half a row"
    };
    Error::new(ErrorKind::Format, format!("{found} fields"), advice)
        .expecting(format!("{expected} fields, as the header has"))
}

/// Puts the cells of a row where they belong.
struct Filler {
    table: Table,
    time: Source,
    section: Option<Source>,
    supervised: Option<Source>,
    label_of: BTreeMap<String, u32>,
}

impl Filler {
    fn new(sources: Vec<Source>, rows: usize) -> Self {
        let mut time = Source { role: Role::Time, index: 0, name: "t_s".into(), factor: 1.0 };
        let (mut section, mut supervised) = (None, None);
        let mut table = Table::default();
        for source in sources {
            match source.role {
                Role::Time => time = source,
                Role::Section => section = Some(source),
                Role::Supervised => supervised = Some(source),
                _ => table.signals.push(Signal { source, values: Vec::with_capacity(rows) }),
            }
        }
        table.time_column.clone_from(&time.name);
        Self { table, time, section, supervised, label_of: BTreeMap::new() }
    }

    fn push(&mut self, row: &Splitter, line: usize) -> Result<(), Error> {
        let table = &mut self.table;
        table.t.push(number(row, &self.time, LARGEST_TIME)?);
        for signal in &mut table.signals {
            signal.values.push(number(row, &signal.source, LARGEST_VALUE)?);
        }
        if let Some(source) = &self.supervised {
            table.supervised.push(flag(row, source)?);
        }
        if let Some(source) = &self.section {
            let label = match row.field(source.index) {
                "" => "-",
                label => label,
            };
            let same = table.labels.last().copied().filter(|&i| table.label_names[i as usize] == label);
            let index = match same.or_else(|| self.label_of.get(label).copied()) {
                Some(index) => index,
                None => {
                    let index = u32::try_from(table.label_names.len()).unwrap_or(u32::MAX);
                    table.label_names.push(label.to_owned());
                    self.label_of.insert(label.to_owned(), index);
                    index
                }
            };
            table.labels.push(index);
        }
        table.lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        Ok(())
    }
}

fn number(row: &Splitter, source: &Source, largest: f64) -> Result<f64, Error> {
    let cell = row.field(source.index);
    let parsed = cell.parse::<f64>();
    if let Ok(raw) = parsed {
        let value = raw * source.factor;
        if value.abs() <= largest {
            return Ok(value);
        }
    }
    let (found, advice) = match parsed {
        Err(_) if cell.is_empty() => ("an empty cell".into(), sniff::number_advice(cell)),
        Ok(value) if value.is_nan() => (quote(cell), sniff::number_advice(cell)),
        Err(_) => (quote(cell), sniff::number_advice(cell)),
        Ok(_) if cell.to_ascii_lowercase().contains("inf") => {
            (quote(cell), "delete the rows without a measurement: a missing row is treated as a gap")
        }
        Ok(_) => (
            format!("{}, beyond any measurement in this unit (±{largest:e})", quote(cell)),
            "look for a broken logger or a wrong unit; correct the cell or delete the row",
        ),
    };
    Err(Error::new(ErrorKind::Value, format!("found {found}"), advice)
        .in_column(source.name.as_str())
        .expecting("a finite number"))
}

fn flag(row: &Splitter, source: &Source) -> Result<bool, Error> {
    let cell = row.field(source.index);
    match cell {
        "0" => Ok(false),
        "1" => Ok(true),
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
