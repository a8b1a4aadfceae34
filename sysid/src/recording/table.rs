//! From bytes to columns of numbers: one pass over the lines, no allocation per cell.

use std::collections::BTreeMap;

use super::assign::{ROW, Source};
use super::clock::counted;
use super::columns::{KNOWN_COLUMNS, Role};
use super::expression::Expression;
use super::fields::{Splitter, content_lines};
use super::garbled::Wrong;
use super::layout::Layout;
use super::options::{ColumnMap, ReadOptions};
use super::{Note, NoteKind, missing, sniff, wall_clock};
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
    /// Rows in which no output was measured; empty where all were.
    pub(super) unmeasured: Vec<bool>,
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
            unmeasured: Vec::new(),
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
        remove_rows(&mut self.unmeasured, rows);
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

/// Reads header and rows; errors carry line and column, the caller adds the file.
pub(super) fn read(bytes: &[u8], options: &ReadOptions, notes: &mut Vec<Note>) -> Result<Table, Error> {
    let text = sniff::text(bytes)?;
    let layout = Layout::read(&text, &options.columns)?;
    let sources = layout.assigned(options, notes)?;
    let Layout { mut splitter, names: header, names_stand, rows_from, .. } = layout;
    let mut lines = content_lines(&text).skip_while(|(number, _)| *number < rows_from).peekable();
    let row_length = lines.peek().map_or(1, |(_, line)| line.len().max(1));
    let mut filler = Filler::new(header.clone(), sources, text.len() / row_length);
    let mut wrong = Wrong::default();
    let ends = text.ends_with(['\n', '\r']);
    // the header again is no row that was logged
    let (mut rows, mut headers) = (0, 0);
    while let Some((number, line)) = lines.next() {
        rows += 1;
        match splitter.split(line) {
            Err(error) => wrong.add(error, number),
            Ok(()) if names_stand.is_some_and(|(_, header)| header == line) => {
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
            Ok(()) if !splitter.has_width(header.len()) => {
                wrong.add(wrong_width(splitter.fields, header.len()), number);
            }
            Ok(()) => filler.push(&splitter, rows - 1 - headers, number, &mut wrong),
        }
    }
    notes.extend(wrong.of(rows)?);
    if filler.of_day == Some(true) {
        wall_clock::over_midnight(&mut filler.table.t);
    }
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
    /// The columns of flags: `supervised`, `unmeasured`.
    flags: [Option<Source>; 2],
    label_of: BTreeMap<String, u32>,
    /// Whether time stands as the time of day: as in the first row that has one.
    of_day: Option<bool>,
}

impl Filler {
    fn new(header: Vec<String>, sources: Vec<Source>, rows: usize) -> Self {
        let (mut section, mut flags) = (None, [None, None]);
        let mut table = Table::default();
        for source in sources {
            match source.role {
                Role::Time => table.time = source,
                Role::Section => section = Some(source),
                Role::Supervised => flags[0] = Some(source),
                Role::Unmeasured => flags[1] = Some(source),
                _ => table.signals.push(Signal { source, values: Vec::with_capacity(rows) }),
            }
        }
        Self { header, table, section, flags, label_of: BTreeMap::new(), of_day: None }
    }

    /// The row at `place` among those that were logged, in this line.
    fn push(&mut self, row: &Splitter, place: usize, line: usize, wrong: &mut Wrong) {
        let table = &mut self.table;
        if self.of_day.is_none() {
            let stamps = table.time.places.iter().filter(|&&place| place < row.fields);
            let mut stamps = stamps.map(|&place| row.field(place)).filter(|cell| !missing::is_missing(cell));
            let of_day = stamps.clone().any(|cell| wall_clock::seconds(cell).is_some());
            self.of_day = stamps.next().map(|_| of_day);
        }
        let cells = Row { fields: row, place, header: &self.header, of_day: self.of_day == Some(true) };
        let mut take = |source: &Source, largest| match cells.value(source, largest) {
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
        for (source, flags) in self.flags.iter().zip([&mut table.supervised, &mut table.unmeasured]) {
            let Some(source) = source else { continue };
            let before = flags.last().copied().unwrap_or(false);
            flags.push(flag(row, source, before).unwrap_or_else(|error| {
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
    source.places.first().filter(|&&place| place < row.fields).map_or("", |&place| row.field(place))
}

/// The cells of one row.
struct Row<'r> {
    fields: &'r Splitter,
    /// Among the rows that were logged.
    place: usize,
    header: &'r [String],
    /// Whether time stands as the time of day.
    of_day: bool,
}

impl Row<'_> {
    /// What the expression of `source` gives, in SI units; NaN where a cell is missing or it divides by zero.
    fn value(&self, source: &Source, largest: f64) -> Result<f64, Error> {
        let header = self.header;
        let name = |column: usize| header.get(column).map_or(ROW, String::as_str);
        let clock = |column: usize| {
            let reads = self.of_day && source.role == Role::Time;
            reads.then(|| wall_clock::seconds(self.fields.field(column))).flatten()
        };
        let number = |column: usize| match column < header.len() {
            true => clock(column).map_or_else(|| self.fields.number(column, name(column)), Ok),
            false => Ok(self.place as f64),
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
            let found = || {
                if column < header.len() { quote(self.fields.field(column)) } else { raw.to_string() }
            };
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
            _ => {
                let advice = format!("{}, else 0; or delete the column", source.role.set_where());
                let error = Error::new(ErrorKind::Value, format!("found {}", quote(cell)), advice);
                Err(error.in_column(source.name.as_str()).expecting("0 or 1"))
            }
        },
    }
}
