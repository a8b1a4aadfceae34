//! The axes of recordings of several: `u_roll_norm`, `p_rad_s` and so on read as one axis.

use crate::failure::Failure;
use crate::logs::recording::recording;
use crate::logs::{Flight, Source, Table, TimeSpan, choose, refuse_options};
use clap::ValueEnum;
use flight_logs::axes::Axis;
use sysid::recording::{ColumnMap, Expression, INPUT_UNITS, NoteKind, ReadOptions, Recording, header, parse};

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

/// Name, and begin of the names of rate and angle, of an axis in a recording.
fn names(axis: Axis) -> [&'static str; 3] {
    match axis {
        Axis::Roll => ["roll", "p_", "phi_"],
        Axis::Pitch => ["pitch", "q_", "theta_"],
        Axis::Yaw => ["yaw", "r_", "psi_"],
    }
}

/// What a column tells of an axis.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Tells {
    Input,
    Rate,
    Angle,
}

/// What the column `name` tells of which axis, and in which unit; `None` where it is of no axis of several.
fn told(name: &str) -> Option<(Axis, Tells, &str)> {
    Axis::ALL.into_iter().find_map(|axis| {
        let [word, rate, angle] = names(axis);
        let command = name.strip_prefix("u_").and_then(|rest| rest.strip_prefix(word)?.strip_prefix('_'));
        let input = command.filter(|unit| INPUT_UNITS.contains(unit)).map(|unit| (axis, Tells::Input, unit));
        let of = |begin: &str, units: [&str; 2], tells| {
            let unit = name.strip_prefix(begin).filter(|unit| units.contains(unit))?;
            Some((axis, tells, unit))
        };
        input
            .or_else(|| of(rate, ["rad_s", "deg_s"], Tells::Rate))
            .or_else(|| of(angle, ["rad", "deg"], Tells::Angle))
    })
}

/// Where a recording of `axis` alone has what a column `tells` of an axis: what stands beside an axis stands there as roll and yaw
/// stand beside pitch.
fn place(axis: Axis, (of, tells, unit): (Axis, Tells, &str)) -> Option<String> {
    let [first, second] = neighbours(axis);
    let begin = match tells {
        Tells::Input if of == axis => "u_",
        Tells::Input if of == first && axis != Axis::Yaw => "u_roll_",
        Tells::Rate if of == axis => "q_",
        Tells::Rate if of == first => "p_",
        Tells::Rate if of == second => "r_",
        Tells::Angle if of == axis => "theta_",
        Tells::Angle if (axis, of) == (Axis::Pitch, Axis::Roll) => "phi_",
        Tells::Input | Tells::Rate | Tells::Angle => return None,
    };
    Some(format!("{begin}{unit}"))
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
    pub fn axes(&self, options: &ReadOptions) -> Vec<Axis> {
        match self {
            Self::Log(_) => Axis::ALL.to_vec(),
            Self::Table(table, _) => {
                let names = header(&table.name, &table.text);
                names.map_or(Vec::new(), |header| axes_of(&header, options))
            }
        }
    }

    /// Reads one axis, alone or one `of_several` that are asked; without one a log's pitch, and of a recording what it has.
    pub fn recording(
        &self,
        axis: Option<Axis>,
        of_several: bool,
        options: &ReadOptions,
    ) -> Result<Recording, Failure> {
        match self {
            Self::Log(flight) => recording(flight, axis.unwrap_or(Axis::Pitch), options),
            Self::Table(table, time) => {
                let mut recording = recording_of(table, axis, of_several, options)?;
                let Some(TimeSpan { from, to }) = time else { return Ok(recording) };
                // what lies near the ground is used where nothing else is meant
                if recording.cut(*from, *to).is_err() {
                    let all = ReadOptions { on_ground: true, ..options.clone() };
                    recording = recording_of(table, axis, of_several, &all)?;
                    recording.cut(*from, *to)?;
                }
                Ok(recording)
            }
        }
    }
}

/// The axes of which there are an input and a rate among the columns of the file and those that the user maps; none where they are of
/// one axis alone.
fn axes_of(header: &[String], options: &ReadOptions) -> Vec<Axis> {
    let mapped = options.columns.iter().map(|map| map.target.as_str());
    let all: Vec<(Axis, Tells, &str)> =
        header.iter().map(String::as_str).chain(mapped).filter_map(told).collect();
    let has = |axis: Axis, tells: Tells| all.iter().any(|(of, what, _)| *of == axis && *what == tells);
    Axis::ALL.into_iter().filter(|&axis| has(axis, Tells::Input) && has(axis, Tells::Rate)).collect()
}

/// What the user maps, as a recording of `axis` alone has it. What is mapped as the rate or angle of a recording of one axis is that of
/// `axis`, and pitch's where this is mapped by its own name, or is one `of_several` that are asked.
fn maps_for(axis: Axis, of_several: bool, maps: &[ColumnMap]) -> Vec<ColumnMap> {
    let is_own = |map: &ColumnMap, asked: Tells| {
        told(&map.target).is_some_and(|(of, tells, _)| of == axis && tells == asked)
    };
    let for_axis = |map: &ColumnMap| {
        let Some(what) = told(&map.target) else { return Some(map.clone()) };
        let (of, tells, _) = what;
        let of_one_alone = of == Axis::Pitch && tells != Tells::Input;
        if of_one_alone && !of_several && !maps.iter().any(|other| is_own(other, tells)) {
            return Some(map.clone());
        }
        Some(ColumnMap { target: place(axis, what)?, ..map.clone() })
    };
    maps.iter().filter_map(for_axis).collect()
}

/// The begin of a column's name, which says what it is whatever the unit.
fn slot(name: &str) -> &str {
    let of_two = ["u_roll_", "theta_ref_"].into_iter().find(|begin| name.starts_with(begin));
    of_two.unwrap_or_else(|| name.find('_').map_or(name, |end| &name[..=end]))
}

/// Reads one axis of a recording as if it were the only one; what the user maps goes first.
fn recording_of(
    table: &Table,
    axis: Option<Axis>,
    of_several: bool,
    options: &ReadOptions,
) -> Result<Recording, Failure> {
    let Table { name, text, .. } = table;
    let header = header(name, text)?;
    let pitch = || axes_of(&header, options).contains(&Axis::Pitch).then_some(Axis::Pitch);
    let Some(axis) = axis.or_else(pitch) else {
        return Ok(parse(name, text, options)?);
    };
    let maps = maps_for(axis, of_several, &options.columns);
    let mut own: Vec<ColumnMap> = Vec::new();
    // a column in degrees gives way to the same signal in another unit
    for in_degrees in [false, true] {
        for column in &header {
            let Some(what) = told(column).filter(|(.., unit)| unit.starts_with("deg") == in_degrees) else {
                continue;
            };
            let Some(target) = place(axis, what) else { continue };
            if !maps.iter().chain(&own).any(|map| slot(&map.target) == slot(&target)) {
                own.push(ColumnMap { target, source: Expression::column(column), factor: 1.0 });
            }
        }
    }
    let has = |wanted: &str| maps.iter().chain(&own).any(|map| slot(&map.target) == wanted);
    let missing = [("u_", "an input"), ("q_", "a rate")].into_iter().find(|(slot, _)| !has(slot));
    // a recording of one axis calls it pitch
    if axis != Axis::Pitch
        && let Some((_, what)) = missing
    {
        let found = format!("{name}: no column for {what} of {axis} among {}", header.join(", "));
        let [word, rate, _] = names(axis);
        let help =
            format!("{axis} needs u_{word}_norm (or another unit) and {rate}rad_s; map others with --column");
        return Err(Failure::new(found, help));
    }
    let angle_is_own = has("theta_");
    own.retain(|map| map.source.as_column() != Some(&map.target));
    let found: Vec<String> = own.iter().map(|map| format!("{} is the file's column", map.target)).collect();
    let columns = maps.into_iter().chain(own).collect();
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
        let options = ReadOptions::default();
        let names = header(&table.name, &table.text).unwrap();
        assert_eq!(axes_of(&names, &options), [Axis::Roll, Axis::Yaw]);
        let roll = recording_of(&table, Some(Axis::Roll), false, &options).unwrap();
        assert_eq!((roll.u[3], roll.q.unwrap()[3]), (3.0, 9.0));
        assert!(roll.theta.is_none(), "the angle of pitch is none of roll's");
        assert_eq!(roll.p.unwrap()[3], 12.0, "pitch stands beside roll as roll beside pitch");
        let yaw = recording_of(&table, Some(Axis::Yaw), false, &options).unwrap();
        assert_eq!((yaw.u[3], yaw.q.unwrap()[3]), (6.0, 3_f64.sin()));
        let mapped = ReadOptions { columns: vec!["q_rad_s=-p_rad_s".parse().unwrap()], ..options };
        let turned = recording_of(&table, Some(Axis::Roll), false, &mapped).unwrap();
        assert_eq!(turned.q.unwrap()[3], -9.0);
        assert!(
            recording_of(&table, Some(Axis::Pitch), false, &mapped).is_err(),
            "there is no input of pitch"
        );
    }

    #[test]
    fn columns_of_other_names_are_mapped_by_the_names_of_the_axes() {
        let mut text = "time,m_roll,m_pitch,gx,gy,q_deg_s\n".to_owned();
        for k in 0..60 {
            let x = f64::from(k);
            text += &format!("{},{x},{},{},{},{}\n", 0.02 * x, 2.0 * x, 3.0 * x, 4.0 * x, x.sin());
        }
        let table = Table { name: "flight.csv".into(), text: text.into_bytes() };
        let options = |maps: &[&str]| ReadOptions {
            columns: maps.iter().map(|map| map.parse().unwrap()).collect(),
            ..ReadOptions::default()
        };
        let both =
            options(&["t_s=time", "u_roll_norm=m_roll", "u_pitch_norm=m_pitch", "p_rad_s=gx", "q_rad_s=gy"]);
        let names = header(&table.name, &table.text).unwrap();
        assert_eq!(axes_of(&names, &both), [Axis::Roll, Axis::Pitch]);
        let roll = recording_of(&table, Some(Axis::Roll), false, &both).unwrap();
        assert_eq!((roll.u[3], roll.q.unwrap()[3], roll.p.unwrap()[3]), (3.0, 9.0, 12.0));
        for axis in [Some(Axis::Pitch), None] {
            let pitch = recording_of(&table, axis, false, &both).unwrap();
            assert_eq!((pitch.u[3], pitch.q.unwrap()[3], pitch.p.unwrap()[3]), (6.0, 12.0, 9.0));
        }
        let as_one = options(&["t_s=time", "u_norm=m_roll", "q_rad_s=gx"]);
        let roll = recording_of(&table, Some(Axis::Roll), false, &as_one).unwrap();
        assert_eq!((roll.u[3], roll.q.unwrap()[3]), (3.0, 9.0), "of the axis that is asked");
        assert!(recording_of(&table, Some(Axis::Yaw), false, &both).is_err(), "there is no input of yaw");
    }
}
