//! Which column of a file plays which role.

use super::columns::{KNOWN_COLUMNS, Role};
use super::expression::Expression;
use super::options::ColumnMap;
use super::proposal;
use super::{Note, NoteKind};
use crate::error::{Error, ErrorKind, nearest, quote};

/// In an expression, the number of the row from 0, where the file has no column of this name. Its place is behind the last column.
pub(super) const ROW: &str = "row";

/// A signal and the columns of the file that make it.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) role: Role,
    pub(super) expression: Expression,
    /// Places in the row, from 0, of the names in the expression.
    pub(super) places: Vec<usize>,
    /// Name in the file's header, or the expression, for messages.
    pub(super) name: String,
    /// From the file's unit to SI.
    pub(super) factor: f64,
}

impl Source {
    pub(super) fn new(role: Role, expression: Expression, places: Vec<usize>, factor: f64) -> Self {
        Self { role, name: expression.label(), expression, places, factor }
    }

    /// As an option of the reader has it.
    pub(super) fn as_map(&self) -> ColumnMap {
        ColumnMap { target: self.role.column().into(), source: self.expression.clone(), factor: self.factor }
    }

    /// The option that multiplies this column by `factor` on top of what is done already.
    pub(super) fn scaled_by(&self, factor: f64) -> String {
        self.as_map().option_to_scale(factor)
    }
}

/// Assigns the columns of a header; notes what is converted, ignored or replaced.
pub(super) fn assign(
    header: &[String],
    maps: &[ColumnMap],
    notes: &mut Vec<Note>,
) -> Result<Vec<Source>, Error> {
    let mut sources: Vec<Source> = Vec::new();
    for map in maps {
        let source = mapped(header, map)?;
        if let Some(earlier) = sources.iter().find(|s| s.role.same_slot(source.role)) {
            let found = format!("--column gives {} twice ({}, {})", map.target, earlier.name, source.name);
            return Err(Error::new(ErrorKind::Options, found, "keep one of the two"));
        }
        let (role, name, factor) = (source.role.column(), &source.name, source.factor);
        let text = match source.expression.as_column() {
            Some(name) => format!("{role} is the file's column {} times {factor}, as asked", quote(name)),
            None if source.places.is_empty() => format!("{role} is {name} throughout, as asked"),
            None => format!("{role} is {name} of the file's columns, times {factor}, as asked"),
        };
        notes.push(Note::new(NoteKind::Converted, text));
        sources.push(source);
    }
    let from_maps = sources.len();
    for (index, name) in header.iter().enumerate() {
        let Some((role, factor)) = Role::of(name) else { continue };
        // A column that was asked for as another one is not that of its own name as well: a roll rate that is to be the rate has no roll
        // beside it.
        let alike =
            |s: &Source| role.is_motion() && s.role.is_motion() || role.is_command() && s.role.is_command();
        let is_another =
            |s: &Source| alike(s) && s.expression.as_column().is_some() && s.places.contains(&index);
        if sources[..from_maps].iter().any(|s| s.role.same_slot(role) || is_another(s)) {
            continue;
        }
        add_own_column(&mut sources, Source::new(role, Expression::column(name), vec![index], factor))?;
    }
    require(&sources, header)?;
    note_conversions(&sources[from_maps..], notes);
    note_ignored(header, &sources, notes);
    Ok(sources)
}

fn mapped(header: &[String], map: &ColumnMap) -> Result<Source, Error> {
    let option = format!("--column {}={}", map.target, map.source);
    let Some((role, unit)) = Role::of(&map.target) else {
        let found = format!("{option}: {} is not a column of the format", quote(&map.target));
        let advice = format!("use one of {}", KNOWN_COLUMNS.join(", "));
        return Err(Error::new(ErrorKind::Options, found, advice));
    };
    let place = |name: &String| {
        let mut places = header.iter().enumerate().filter(|(_, known)| *known == name);
        match (places.next(), places.next()) {
            (Some((index, _)), None) => Ok(index),
            (Some(_), Some(_)) => Err(double_column(name)),
            (None, _) if name == ROW => Ok(header.len()),
            (None, _) if let Some(place) = by_place(name, header.len()) => Ok(place),
            (None, _) => {
                let found = format!("{option}: the file has no column {}", quote(name));
                let advice = "name a column of the file, in the same upper and lower case, and between \"quotes\" where it has other signs \
                              than letters, digits, blanks, _ . [ ]";
                let names = nearest(header.iter().map(String::as_str), name);
                Err(Error::new(ErrorKind::Options, found, advice).expecting(format!("one of {names}")))
            }
        }
    };
    let places = map.source.names().iter().map(place).collect::<Result<Vec<usize>, Error>>()?;
    Ok(Source::new(role, map.source.clone(), places, unit * map.factor))
}

/// The place from 0 of the column called c1, c2, ... from the left, of so many.
fn by_place(name: &str, columns: usize) -> Option<usize> {
    let place = name.strip_prefix('c')?.parse::<usize>().ok()?;
    (1..=columns).contains(&place).then(|| place - 1)
}

fn double_column(name: &str) -> Error {
    Error::new(ErrorKind::Column, "two columns of this name", "delete or rename one of them").in_column(name)
}

/// A column in degrees gives way to the same signal in radians, a command in degrees to any other; anything else twice is an error.
fn add_own_column(sources: &mut Vec<Source>, new: Source) -> Result<(), Error> {
    let Some(position) = sources.iter().position(|s| s.role.same_slot(new.role)) else {
        sources.push(new);
        return Ok(());
    };
    let old = &sources[position];
    if old.name == new.name {
        return Err(double_column(&new.name));
    }
    if new.name != new.role.column() {
        return Ok(());
    }
    if old.name != old.role.column() {
        sources[position] = new;
        return Ok(());
    }
    let found = format!("two input columns, {} and {}", old.name, new.name);
    let advice = format!("choose one, e.g. --column {0}={0}, or delete the other", old.name);
    Err(Error::new(ErrorKind::Column, found, advice).expecting("exactly one input column for each axis"))
}

fn require(sources: &[Source], header: &[String]) -> Result<(), Error> {
    let has = |wanted: fn(Role) -> bool| sources.iter().any(|s| wanted(s.role));
    let (what, expected, more) = if !has(|r| r == Role::Time) {
        (
            "no column t_s",
            "t_s, the time of each sample in seconds",
            "'t_s=NAME*0.001' for milliseconds; where no time was logged, 't_s=row*0.01' counts rows of 0.01 s",
        )
    } else if !has(|r| matches!(r, Role::Input(_))) {
        (
            "no input column",
            "one of u_rad (or u_deg), u_pct, u_V, u_A, u_N_m, u_N, u_norm",
            "where nothing was commanded (a release, a ring-down), --column u_norm=0",
        )
    } else if !has(|r| matches!(r, Role::Q | Role::Theta)) {
        (
            "neither pitch rate nor pitch angle",
            "q_rad_s or theta_rad (or q_deg_s, theta_deg)",
            "a sign that is reversed: 'q_rad_s=-NAME'",
        )
    } else {
        return Ok(());
    };
    let option =
        format!("{}, with the names and units that are right ({more})", proposal::options(header, has));
    let alike = header
        .iter()
        .find(|name| KNOWN_COLUMNS.iter().any(|known| known.eq_ignore_ascii_case(name) && known != name));
    let found = format!("{what} among {}", listed(header));
    let advice = match alike {
        Some(name) => {
            format!("names are case-sensitive: look at {}; or map the columns with {option}", quote(name))
        }
        None => format!("map the columns with {option}"),
    };
    Err(Error::new(ErrorKind::Column, found, advice).expecting(expected))
}

/// Column names for a message, cut after the twelfth.
fn listed(header: &[String]) -> String {
    const MOST: usize = 12;
    let mut names: Vec<String> = header
        .iter()
        .take(MOST)
        .map(|name| name.chars().take(40).flat_map(char::escape_debug).collect())
        .collect();
    if header.len() > MOST {
        names.push(format!("and {} more", header.len() - MOST));
    }
    names.join(", ")
}

fn note_conversions(own: &[Source], notes: &mut Vec<Note>) {
    for source in own.iter().filter(|s| s.name != s.role.column()) {
        let text = format!("{} was converted from degrees to {}", source.name, source.role.column());
        notes.push(Note::new(NoteKind::Converted, text));
    }
}

fn note_ignored(header: &[String], sources: &[Source], notes: &mut Vec<Note>) {
    let ignored: Vec<String> = header
        .iter()
        .enumerate()
        .filter(|(index, name)| !name.is_empty() && sources.iter().all(|s| !s.places.contains(index)))
        .map(|(_, name)| name.clone())
        .collect();
    if !ignored.is_empty() {
        notes.push(Note::new(NoteKind::Ignored, format!("columns not used: {}", listed(&ignored))));
    }
}
