//! Recordings: the CSV format that every part of the project reads and writes, read with all its checks.
//!
//! What comes out is on a uniform grid in SI units: the step T (s) is the median of the differences of the time
//! stamps, refined over the whole file; jitter of a few per cent of T is snapped to the grid, a step that varies more
//! is resampled (input held unless [`InputHold::Interpolated`], outputs linear), and a gap splits the recording into
//! segments. What lies on the ground, where the thrust was logged, is in none of them. Nothing of this is silent: [`Recording::notes`] says what was done and what looks wrong.
//! What cannot be used is an [`Error`] with file, line, column and advice.

mod airborne;
mod assign;
mod binary;
mod checks;
mod clock;
mod columns;
mod cut;
mod even_rows;
mod export;
mod expression;
mod fields;
mod full_turns;
mod garbled;
mod in_memory;
mod layout;
mod matlab;
mod missing;
mod options;
pub(crate) mod plateaus;
mod proposal;
pub(crate) mod rate_and_angle;
mod restarts;
mod same_stamps;
mod sections;
mod sniff;
mod stale;
mod stray_stamps;
mod summed_angle;
mod table;
mod wall_clock;
mod wild;
mod write;

use std::ops::Range;
use std::path::Path;

pub use columns::{INPUT_UNITS, InputUnit, KNOWN_COLUMNS};
pub use expression::Expression;
pub use in_memory::{Column, from_columns};
pub use options::{ColumnMap, InputHold, ReadOptions, SectionSpec};
pub(crate) use sections::WHOLE;

use crate::error::{Error, ErrorKind};
use crate::files;
use columns::Role;
use layout::Layout;
use table::Table;

/// A recording on a uniform grid, SI units; every series has the length of `t`, and every number is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The file's name as given, for messages.
    pub name: String,
    /// Time stamps, s: uniform with `step` inside a segment.
    pub t: Vec<f64>,
    /// Input, in `u_unit`: held over [t_k, t_k+1), or straight between samples (`input_hold`).
    pub u: Vec<f64>,
    /// Unit of the input.
    pub u_unit: InputUnit,
    /// Measured pitch rate, rad/s; present if `theta` is not.
    pub q: Option<Vec<f64>>,
    /// Measured pitch angle, rad; present if `q` is not.
    pub theta: Option<Vec<f64>>,
    /// Pitch acceleration, rad/s².
    pub qdot: Option<Vec<f64>>,
    /// Roll rate, rad/s.
    pub p: Option<Vec<f64>>,
    /// Yaw rate, rad/s.
    pub r: Option<Vec<f64>>,
    /// Roll angle, rad.
    pub phi: Option<Vec<f64>>,
    /// Attitude reference, rad.
    pub theta_ref: Option<Vec<f64>>,
    /// Command of the roll axis, in the unit of its column.
    pub u_roll: Option<Vec<f64>>,
    /// Collective thrust command, normalised.
    pub thrust: Option<Vec<f64>>,
    /// Supply voltage, V.
    pub battery: Option<Vec<f64>>,
    /// Where the supervisor overrode the excitation; all false without the column.
    pub supervised: Vec<bool>,
    /// Rows in which neither rate nor angle was measured: they were missing and are filled, or repeat the last reading of a slower
    /// sensor. Empty where there are none.
    pub unmeasured: Vec<bool>,
    /// Named stretches in order of time, each inside one segment; rows labelled `-` belong to none.
    pub sections: Vec<Section>,
    /// Stretches without a gap: they cover all rows but those on the ground.
    pub segments: Vec<Range<usize>>,
    /// Step of the grid, s.
    pub step: f64,
    /// How the input behaves between samples.
    pub input_hold: InputHold,
    /// Which column of the file each signal is, and the factor it was multiplied by.
    pub columns: Vec<ColumnMap>,
    /// What was done to the data and what looks wrong, for people.
    pub notes: Vec<Note>,
}

/// A contiguous run of one label inside one segment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Unique name: the file's label, and `IV#2`, `IV#3` for later runs of the same label.
    pub label: String,
    /// The label in the file; `all` where the file names no section.
    pub file_label: String,
    /// Rows of the recording.
    pub rows: Range<usize>,
}

/// What a [`Note`] is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum NoteKind {
    /// A column was converted, mapped, or made continuous over full turns.
    Converted,
    /// Columns that were not used.
    Ignored,
    /// Section labels were replaced, or say nothing.
    Sections,
    /// Time stamps jitter by a few per cent of the step, or stand still in a few rows, and were put right.
    Snapped,
    /// The step varies; the data were resampled.
    Resampled,
    /// One or two missing samples were filled.
    Filled,
    /// Samples are missing; the recording is split there.
    Gap,
    /// Cells without a number, garbled lines, stray time stamps: their rows were left out, or bridged where they are not needed.
    Missing,
    /// Rows that stood twice were dropped.
    Duplicate,
    /// Samples far from all around were left out.
    Wild,
    /// What was not flown is not used.
    Ground,
    /// A signal stays at its extreme value again and again.
    Clipped,
    /// A unit looks wrong.
    Unit,
    /// A sign looks reversed.
    Sign,
    /// A signal is logged faster than it is measured.
    Repeated,
    /// An output is constant.
    DeadOutput,
    /// The input is constant.
    DeadInput,
}

/// Something that a user of the recording should know: used with care, and said so.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// What it is about.
    pub kind: NoteKind,
    /// First and last time concerned, s; `None`: the whole recording.
    pub time_s: Option<[f64; 2]>,
    /// One or two sentences, with the option that fixes it where there is one.
    pub text: String,
}

impl Note {
    fn new(kind: NoteKind, text: impl Into<String>) -> Self {
        Self { kind, time_s: None, text: text.into() }
    }

    fn over(kind: NoteKind, from: f64, to: f64, text: impl Into<String>) -> Self {
        Self { kind, time_s: Some([from, to]), text: text.into() }
    }
}

/// Reads a recording from a file: CSV, a Parquet table, or the vectors of a MATLAB file (up to version 7).
///
/// # Errors
/// As [`parse`], and where the file cannot be read.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording, Error> {
    let name = path.display().to_string();
    let bytes = files::read(path, files::LARGEST_RECORDING)?;
    parse(&name, &as_csv(&name, bytes)?, options)
}

/// The names of the columns of a CSV file, in order; `name` stands for the file in messages.
///
/// # Errors
/// No header line.
pub fn header(name: &str, text: &[u8]) -> Result<Vec<String>, Error> {
    let text = sniff::text(text).map_err(|error| error.in_file(name))?;
    Layout::read(&text, &[]).map(|layout| layout.names).map_err(|error| error.in_file(name))
}

/// A recording's bytes as CSV, made of a Parquet table or a MATLAB file where they are one; `name` stands for the file in messages.
///
/// # Errors
/// A table that cannot be read.
pub fn as_csv(name: &str, bytes: Vec<u8>) -> Result<Vec<u8>, Error> {
    binary::as_csv(bytes).map_err(|error| error.in_file(name))
}

/// Reads a recording from the bytes of a CSV file; `name` stands for the file in messages.
///
/// # Errors
/// Whatever makes the data unusable: no UTF-8 CSV, a column missing, double or contradictory, text or an infinity where
/// a number belongs, time stamps that stand still in more than one row in a hundred, run backwards or have an impossible step, too few
/// samples, options that fit nothing in the file. Cells that are empty or NaN are gaps, and so is what a garbled line lacks where one line in a hundred or fewer are, and a
/// row whose stamp alone is out of order. The error names file, line, column, what was found and what to do, and
/// what else is wrong with cells and time stamps of the same file.
pub fn parse(name: &str, text: &[u8], options: &ReadOptions) -> Result<Recording, Error> {
    parse_unnamed(name, text, options).map_err(|error| error.in_file(name))
}

fn parse_unnamed(name: &str, text: &[u8], options: &ReadOptions) -> Result<Recording, Error> {
    let mut notes = Vec::new();
    let mut table = table::read(text, options, &mut notes)?;
    missing::leave_out(&mut table, options.input_hold, &mut notes)?;
    on_grid(name, table, options, notes)
}

/// Makes a recording of signals that stand in no CSV file, e.g. of a flight log: times `t` (s) and as many values of
/// each signal, in the unit of its column.
///
/// Each [`ColumnMap`] names the column of the format (`target`) and what the user knows the signal as (`source`), so that
/// a remedy reads `--column 'target=source*factor'`. Clock, sections and checks are those of [`parse`];
/// [`ReadOptions::columns`] is not used.
///
/// # Errors
/// As [`parse`], without lines; a number that is not finite, and signals that are not as long as `t`.
pub fn from_signals(
    name: &str,
    t: Vec<f64>,
    signals: Vec<(ColumnMap, Vec<f64>)>,
    options: &ReadOptions,
) -> Result<Recording, Error> {
    let table = Table::of_signals(t, signals).map_err(|error| error.in_file(name))?;
    on_grid(name, table, options, Vec::new()).map_err(|error| error.in_file(name))
}

fn on_grid(
    name: &str,
    mut table: Table,
    options: &ReadOptions,
    mut notes: Vec<Note>,
) -> Result<Recording, Error> {
    stray_stamps::leave_out(&mut table, &mut notes);
    restarts::put_behind(&mut table, &mut notes);
    sections::relabel(&mut table, options, &mut notes)?;
    let in_turns = full_turns::add(&mut table, &mut notes);
    summed_angle::leave_out(&mut table, &mut notes);
    wild::bridge(&mut table, &mut notes);
    let mut grid = clock::onto_grid(&mut table, options, &mut notes)?;
    if !options.on_ground {
        airborne::keep(&table, &mut grid, &options.sections, &mut notes);
    }
    let sections = sections::runs(&table, &grid.segments);
    checks::inspect(&table, &grid, in_turns, &mut notes);

    let input = table.signals.iter().find_map(|s| match s.source.role {
        Role::Input(unit) => Some(unit),
        _ => None,
    });
    let u_unit = input.ok_or_else(|| Error::new(ErrorKind::Column, "no input column", "add one"))?;
    let roll_input = table.signals.iter().map(|s| s.source.role).find(|r| matches!(r, Role::RollInput(_)));
    let columns = table.signals.iter().map(|signal| signal.source.as_map()).collect();
    let mut take = |role: Role| {
        let signal = table.signals.iter_mut().find(|s| s.source.role == role);
        signal.map(|s| std::mem::take(&mut s.values))
    };
    Ok(Recording {
        name: name.to_owned(),
        u: take(Role::Input(u_unit)).unwrap_or_default(),
        u_unit,
        q: take(Role::Q),
        theta: take(Role::Theta),
        qdot: take(Role::Qdot),
        p: take(Role::P),
        r: take(Role::R),
        phi: take(Role::Phi),
        theta_ref: take(Role::ThetaRef),
        u_roll: roll_input.and_then(&mut take),
        thrust: take(Role::Thrust),
        battery: take(Role::Battery),
        supervised: if table.supervised.is_empty() { vec![false; table.t.len()] } else { table.supervised },
        unmeasured: if table.unmeasured.contains(&true) { table.unmeasured } else { Vec::new() },
        t: table.t,
        sections,
        segments: grid.segments,
        step: grid.step,
        input_hold: options.input_hold,
        columns,
        notes,
    })
}

impl Recording {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Never true of a recording that was read.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// The option that reads the signal `target` (`q_rad_s`, `u_rad`, ...) times `factor`, on top of what is done to it
    /// already.
    #[must_use]
    pub fn option_to_scale(&self, target: &str, factor: f64) -> Option<String> {
        self.columns.iter().find(|map| map.target == target).map(|map| map.option_to_scale(factor))
    }

    /// The option that holds a column between two values.
    #[must_use]
    pub fn option_to_limit(&self, target: &str, ends: [f64; 2]) -> Option<String> {
        self.columns.iter().find(|map| map.target == target).map(|map| map.option_to_limit(ends))
    }

    /// The section of this name.
    ///
    /// # Errors
    /// An unknown name; the error lists those that there are.
    pub fn section(&self, label: &str) -> Result<&Section, Error> {
        self.sections.iter().find(|s| s.label == label).ok_or_else(|| {
            let names: Vec<&str> = self.sections.iter().map(|s| s.label.as_str()).collect();
            let advice = "name one of these, or name a section by time with --section NAME=FROM..TO";
            Error::new(ErrorKind::Section, format!("no section {}", crate::error::quote(label)), advice)
                .in_file(self.name.as_str())
                .expecting(format!("one of {}", names.join(", ")))
        })
    }

    /// Checks that `section` has the samples that a method needs.
    ///
    /// # Errors
    /// Fewer than `needed`; `method` names in the message who needs them.
    pub fn require(&self, section: &Section, needed: usize, method: &str) -> Result<(), Error> {
        let found = section.rows.len();
        if found >= needed {
            return Ok(());
        }
        Err(clock::too_short(found, self.step)
            .in_file(self.name.as_str())
            .expecting(format!("at least {needed} samples in section {}, for {method}", section.label)))
    }
}
