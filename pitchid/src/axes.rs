//! The axes of recordings of several: `u_roll_norm`, `p_rad_s` and so on read as one axis.

use crate::failure::Failure;
use crate::logs::recording::recording;
use crate::logs::{Flight, Source, Table, TimeSpan, choose, refuse_options};
use clap::ValueEnum;
use flight_logs::axes::Axis;
use sysid::recording::{ColumnMap, Expression, NoteKind, ReadOptions, Recording, header, parse};

/// Units of an input, as they end its name.
const UNITS: [&str; 7] = ["rad", "deg", "pct", "V", "N_m", "N", "norm"];

/// `--axis`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AxisChoice {
    /// About the axis that points forward
    Roll,
    /// About the axis that points to the right
    Pitch,
    /// About the axis that points down
    Yaw,
    /// Each that has an input and a rate
    All,
}

impl AxisChoice {
    /// The one axis that is meant; `None` for all.
    pub fn one(self) -> Option<Axis> {
        match self {
            Self::Roll => Some(Axis::Roll),
            Self::Pitch => Some(Axis::Pitch),
            Self::Yaw => Some(Axis::Yaw),
            Self::All => None,
        }
    }

    /// The one axis that is meant, where only one may be.
    pub fn single(self) -> Result<Axis, Failure> {
        let help = "choose --axis roll, pitch or yaw";
        self.one().ok_or_else(|| Failure::new("--axis all: one axis at a time here", help))
    }

    /// Whether no axis was chosen.
    pub fn is_all(self) -> bool {
        self == Self::All
    }

    /// The axes to ask, of those that each side has; `None` stands for the one of a recording that names none.
    pub fn wanted(self, before: &[Axis], after: &[Axis]) -> Vec<Option<Axis>> {
        match self {
            Self::Roll | Self::Pitch | Self::Yaw => vec![self.one()],
            Self::All if before.is_empty() && after.is_empty() => vec![None],
            // The side that has none says itself why when it is read.
            Self::All if before.is_empty() => after.iter().copied().map(Some).collect(),
            Self::All if after.is_empty() => before.iter().copied().map(Some).collect(),
            Self::All => before.iter().filter(|axis| after.contains(axis)).map(|axis| Some(*axis)).collect(),
        }
    }
}

/// Name, rate and angle of an axis in a recording.
fn columns(axis: Axis) -> [&'static str; 3] {
    match axis {
        Axis::Roll => ["roll", "p_rad_s", "phi_rad"],
        Axis::Pitch => ["pitch", "q_rad_s", "theta_rad"],
        Axis::Yaw => ["yaw", "r_rad_s", "psi_rad"],
    }
}

/// The column of the axis' input, and what a recording of one axis calls it.
fn input(names: &[String], axis: Axis) -> Option<(String, String)> {
    let [word, ..] = columns(axis);
    let mut all = UNITS.iter().map(|unit| (format!("u_{word}_{unit}"), format!("u_{unit}")));
    all.find(|(own, _)| names.contains(own))
}

/// What stands beside an axis as roll and yaw stand beside pitch: the name there, and the file's.
fn beside(names: &[String], axis: Axis) -> Vec<(String, String)> {
    let rates = ["p_rad_s", "r_rad_s"].into_iter().zip(neighbours(axis).map(|other| columns(other)[1]));
    let mut all: Vec<(String, String)> =
        rates.map(|(place, column)| (place.to_owned(), column.to_owned())).collect();
    if axis == Axis::Roll {
        all.extend(UNITS.iter().map(|unit| (format!("u_roll_{unit}"), format!("u_pitch_{unit}"))));
    }
    all.retain(|(place, column)| place != column && names.contains(column));
    all
}

/// The axes that stand beside one in the places of roll and yaw beside pitch.
pub fn neighbours(axis: Axis) -> [Axis; 2] {
    match axis {
        Axis::Pitch => [Axis::Roll, Axis::Yaw],
        Axis::Roll => [Axis::Pitch, Axis::Yaw],
        Axis::Yaw => [Axis::Roll, Axis::Pitch],
    }
}

/// What axes are read of.
pub enum Readable {
    /// One flight of a log, cut to the part that is meant.
    Log(Box<Flight>),
    /// A recording, and the part of it that is meant.
    Table(Table, Option<TimeSpan>),
}

impl Readable {
    /// The flight of a log that is meant, or a recording; and the part of it.
    pub fn new(source: Source, number: Option<usize>, time: Option<&TimeSpan>) -> Result<Self, Failure> {
        match source {
            Source::Log(flights) => {
                let mut flight = choose(flights, number)?;
                flight.cut(time)?;
                Ok(Self::Log(Box::new(flight)))
            }
            Source::Recording(table) => {
                refuse_options(&table.name, [("--flight", number.is_some())])?;
                Ok(Self::Table(table, time.cloned()))
            }
        }
    }

    /// The axes that may be asked, a log says itself which of them it has not; none of a recording of one axis alone.
    pub fn axes(&self) -> Vec<Axis> {
        match self {
            Self::Log(_) => Axis::ALL.to_vec(),
            Self::Table(table, _) => {
                header(&table.name, &table.text).map_or(Vec::new(), |names| axes_of(&names))
            }
        }
    }

    /// Reads one axis; without one a log's pitch, and of a recording what it has.
    pub fn recording(&self, axis: Option<Axis>, options: &ReadOptions) -> Result<Recording, Failure> {
        match self {
            Self::Log(flight) => recording(flight, axis.unwrap_or(Axis::Pitch), options),
            Self::Table(table, time) => {
                let mut recording = recording_of(table, axis, options)?;
                if let Some(TimeSpan { from, to }) = time {
                    recording.cut(*from, *to)?;
                }
                Ok(recording)
            }
        }
    }
}

/// The axes that a recording with these columns has an input and a rate of; none where it is of one axis alone.
fn axes_of(names: &[String]) -> Vec<Axis> {
    let has =
        |axis: &Axis| input(names, *axis).is_some() && names.iter().any(|name| name == columns(*axis)[1]);
    Axis::ALL.into_iter().filter(has).collect()
}

/// Reads one axis of a recording as if it were the only one; what the user maps goes first.
fn recording_of(table: &Table, axis: Option<Axis>, options: &ReadOptions) -> Result<Recording, Failure> {
    let Table { name, text, .. } = table;
    let names = header(name, text)?;
    let Some(axis) = axis.or_else(|| axes_of(&names).contains(&Axis::Pitch).then_some(Axis::Pitch)) else {
        return Ok(parse(name, text, options)?);
    };
    let [_, rate, angle] = columns(axis);
    let of = |target: &str, source: &str| ColumnMap {
        target: target.into(),
        source: Expression::column(source),
        factor: 1.0,
    };
    let is_there = |name: &str| names.iter().any(|known| known == name);
    let mut own: Vec<ColumnMap> =
        input(&names, axis).iter().map(|(column, target)| of(target, column)).collect();
    own.extend(is_there(rate).then(|| of("q_rad_s", rate)));
    own.extend(is_there(angle).then(|| of("theta_rad", angle)));
    own.extend(beside(&names, axis).iter().map(|(target, column)| of(target, column)));
    let is_mapped = |start: &str| options.columns.iter().any(|map| map.target.starts_with(start));
    let slots = [("u_", "an input"), ("q_", "a rate"), ("theta_", "an angle")];
    own.retain(|map| !slots.iter().any(|(start, _)| map.target.starts_with(start) && is_mapped(start)));
    let has = |start: &str| is_mapped(start) || own.iter().any(|map| map.target.starts_with(start));
    let missing = slots[..2].iter().find(|(start, _)| !has(start));
    // a recording of one axis calls it pitch
    if axis != Axis::Pitch
        && let Some((_, what)) = missing
    {
        let found = format!("{name}: no column for {what} of {axis} among {}", names.join(", "));
        let [word, rate, _] = columns(axis);
        let help =
            format!("{axis} needs u_{word}_norm (or another unit) and {rate}; map others with --column");
        return Err(Failure::new(found, help));
    }
    let angle_is_own = has("theta_");
    own.retain(|map| map.source.as_column() != Some(&map.target));
    let found: Vec<String> = own.iter().map(|map| format!("{} is the file's column", map.target)).collect();
    let columns = options.columns.iter().cloned().chain(own).collect();
    let mut recording = parse(name, text, &ReadOptions { columns, ..options.clone() })?;
    if !angle_is_own {
        recording.theta = None;
    }
    // that an axis is read from its own columns goes without saying
    recording.notes.retain(|note| {
        note.kind != NoteKind::Ignored && !found.iter().any(|begin| note.text.starts_with(begin))
    });
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_is_read_as_the_only_one() {
        let mut text =
            "# a comment\nt_s,u_roll_norm,u_yaw_norm,p_rad_s,q_rad_s,r_rad_s,theta_rad,thrust_norm\n"
                .to_owned();
        for k in 0..60 {
            let x = f64::from(k);
            text += &format!(
                "{},{x},{},{},{},{},{},0.5\n",
                0.02 * x,
                2.0 * x,
                3.0 * x,
                4.0 * x,
                x.sin(),
                x.cos()
            );
        }
        let table = Table { name: "flight.csv".into(), text: text.into_bytes() };
        assert_eq!(axes_of(&header(&table.name, &table.text).unwrap()), [Axis::Roll, Axis::Yaw]);
        let options = ReadOptions::default();
        let roll = recording_of(&table, Some(Axis::Roll), &options).unwrap();
        assert_eq!((roll.u[3], roll.q.unwrap()[3]), (3.0, 9.0));
        assert!(roll.theta.is_none(), "the angle of pitch is none of roll's");
        assert_eq!(roll.p.unwrap()[3], 12.0, "pitch stands beside roll as roll beside pitch");
        let yaw = recording_of(&table, Some(Axis::Yaw), &options).unwrap();
        assert_eq!((yaw.u[3], yaw.q.unwrap()[3]), (6.0, 3_f64.sin()));
        let mapped = ReadOptions { columns: vec!["q_rad_s=-p_rad_s".parse().unwrap()], ..options };
        let turned = recording_of(&table, Some(Axis::Roll), &mapped).unwrap();
        assert_eq!(turned.q.unwrap()[3], -9.0);
        assert!(recording_of(&table, Some(Axis::Pitch), &mapped).is_err(), "there is no input of pitch");
    }
}
