//! `pitchid compare`: what changed on a craft between two recordings.

use crate::axes::{AxisChoice, Readable};
use crate::commands::reading::{model_at, options_with};
use crate::failure::Failure;
use crate::logs::{TimeSpan, open};
use crate::progress::Progress;
use crate::text::comparison::{AxisAnswer, picture, text};
use crate::vehicle::{Vehicle, Wanted};
use crate::{input, output};
use clap::Args;
use flight_logs::axes::Axis;
use std::path::{Path, PathBuf};
use sysid::compare::compare;
use sysid::progress::Step;
use sysid::recording::{ColumnMap, InputHold};

/// Says what changed on a craft between two recordings or flight logs of it
///
/// Compares, axis by axis: trim, effectiveness dM/du, damping dM/dq, lag and delay of the actuators, the background, and dry
/// friction where asked. Each with both values, the difference with its 95 % interval, and whether it changed, no change is
/// seen (and which would have been), or the data cannot tell. Where thrust is logged, what stands on the ground is left out.
#[derive(Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The recording (CSV) or flight log before; - is standard input, for one of the two
    before: PathBuf,

    /// The one after
    after: PathBuf,

    /// The axis [default: all that have an input and a rate]
    #[arg(long, value_name = "AXIS")]
    axis: Option<AxisChoice>,

    /// The simulation in use: gives the inertia, so that moments are in N m, and where the fits start
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,

    /// Compare dry friction too
    #[arg(long)]
    friction: bool,

    /// A column of another name, or arithmetic over columns, of both (see pitchid diagnose --help)
    #[arg(long = "column", value_name = "NAME=EXPR", help_heading = "Reading")]
    columns: Vec<ColumnMap>,

    /// The input between samples: held (a command) or interpolated (it was measured)
    /// [default: held]
    #[arg(long, value_name = "HOLD", help_heading = "Reading")]
    input: Option<InputHold>,

    /// The part to use, in seconds of the own clock; given twice, of BEFORE and of AFTER
    #[arg(long, value_name = "FROM..TO", help_heading = "Reading", allow_hyphen_values = true)]
    time: Vec<TimeSpan>,

    /// Which flight of a log that holds several, counted from 1; given twice, of BEFORE and of AFTER
    #[arg(long, value_name = "N", help_heading = "Reading")]
    flight: Vec<usize>,

    #[command(flatten)]
    wanted: Wanted,

    /// Write the answer as JSON; - is standard output, which then carries nothing else
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,

    /// Draw how far each quantity moved, in half-widths of its 95 % interval
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
In free flight, without a model, moments are angular accelerations: effectiveness and inertia cannot be told apart, as a
heavier craft answers like one with weaker rotors.

A craft that is the same gets a change told in one of a hundred comparisons of an axis at the most.

Examples:
  pitchid compare monday.csv friday.csv
  pitchid compare monday.csv friday.csv --plot changes.svg
  pitchid compare before.ulg after.ulg --axis roll --time 20..80 --time 15..75
  pitchid compare flight.bbl flight.bbl --flight 1 --flight 3 --json changes.json

Exit status: 0 compared, whatever it says; 2 the input could not be used.";

/// Compares.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let vehicle = arguments.wanted.find()?;
    if let Some(vehicle) = &vehicle {
        vehicle.say();
    }
    let vehicle = vehicle.as_ref();
    let mut inputs = vec![arguments.before.as_path(), arguments.after.as_path()];
    inputs.extend(arguments.model(vehicle));
    let outputs = [&arguments.json, &arguments.plot];
    output::check(outputs.into_iter().flatten().map(PathBuf::as_path), &inputs)?;
    input::say_what_is_large(inputs.iter().copied());
    let progress = Progress::start("reading");
    let answers = compared(arguments, vehicle, &|step| progress.say(step))?;
    drop(progress);
    output::print(&text(&answers))?;
    if let Some(path) = &arguments.plot {
        output::write(path, &picture(&answers))?;
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    output::write(path, &json(&arguments.names(), &answers)?)
}

/// The answers as JSON, with the names of what was before and after.
pub fn json([before, after]: &[String; 2], answers: &[AxisAnswer]) -> Result<String, Failure> {
    output::json(&serde_json::json!({
        "schema": "pitchid.comparisons/1",
        "before": before,
        "after": after,
        "axes": answers,
    }))
}

impl Arguments {
    /// The model that is meant.
    fn model<'a>(&'a self, vehicle: Option<&'a Vehicle>) -> Option<&'a Path> {
        self.model.as_deref().or(vehicle.and_then(|vehicle| vehicle.model.as_deref()))
    }

    /// The vehicle's file, where it is wanted.
    pub fn vehicle(&self) -> Result<Option<Vehicle>, Failure> {
        self.wanted.find()
    }

    /// What was before and after, as people call them.
    pub fn names(&self) -> [String; 2] {
        [&self.before, &self.after].map(|path| input::name_of(path))
    }
}

/// What changed, by axis.
pub fn compared(
    arguments: &Arguments,
    vehicle: Option<&Vehicle>,
    progress: &sysid::progress::Progress<'_>,
) -> Result<Vec<AxisAnswer>, Failure> {
    let mut columns = arguments.columns.clone();
    columns.extend(vehicle.into_iter().flat_map(|vehicle| vehicle.columns_beside(&arguments.columns)));
    let model = arguments.model(vehicle);
    let choice = arguments.axis.or(vehicle.and_then(|vehicle| vehicle.axis)).unwrap_or(AxisChoice::All);
    let input = arguments.input.or(vehicle.and_then(|vehicle| vehicle.input)).unwrap_or_default();
    input::once([arguments.before.as_path(), arguments.after.as_path()])?;
    refuse_itself(arguments)?;
    let options = options_with(input, &columns);
    let sides =
        [side(arguments, &columns, &arguments.before, 0)?, side(arguments, &columns, &arguments.after, 1)?];
    let axes: Vec<Option<Axis>> = choice.wanted(&sides[0].axes(&options), &sides[1].axes(&options));
    let several = axes.len() > 1;
    let (mut answers, mut refusals) = (Vec::new(), Vec::new());
    for axis in axes {
        let read = |side: &Readable| side.recording(axis, several, &options);
        let pair = read(&sides[0]).and_then(|before| Ok([before, read(&sides[1])?]));
        match pair {
            Ok([before, after]) => {
                let say = |step: Step<'_>| {
                    let what = axis.map_or(step.what.to_owned(), |axis| format!("{axis}: {}", step.what));
                    progress(Step { what: &what, ..step });
                };
                let model = match model {
                    Some(path) => Some(model_at(path, axis)?),
                    // the inertia of one axis is none of another's
                    None if choice.is_all() && axis.is_some() => None,
                    None => vehicle.and_then(Vehicle::inertia_model).map(|(_, model)| model),
                };
                let found = compare(&[before], &[after], model.as_ref(), arguments.friction, &say)?;
                answers.push(AxisAnswer::new(axis, found));
            }
            Err(refusal) => refusals.push(refusal),
        }
    }
    // an axis that cannot be read stands in nobody's way, unless it was asked for or there is no other
    if let Some(refusal) = refusals.into_iter().next()
        && (answers.is_empty() || !choice.is_all())
    {
        return Err(refusal);
    }
    Ok(answers)
}

/// Refuses the same part of the same file twice: it did not change.
fn refuse_itself(arguments: &Arguments) -> Result<(), Failure> {
    let file = |path: &Path| std::fs::canonicalize(path).ok();
    let same_file = file(&arguments.before).is_some_and(|before| file(&arguments.after) == Some(before));
    let differ = |given: &[String]| given.len() > 1 && given[0] != given[1];
    let times: Vec<String> = arguments.time.iter().map(|span| format!("{span:?}")).collect();
    let flights: Vec<String> = arguments.flight.iter().map(ToString::to_string).collect();
    if !same_file || differ(&times) || differ(&flights) {
        return Ok(());
    }
    Err(Failure::new(
        format!("{}: before and after are the same", arguments.before.display()),
        "give two files, or two parts of one: --time FROM..TO --time FROM..TO, or --flight N --flight M",
    ))
}

/// One of the two.
fn side(
    arguments: &Arguments,
    columns: &[ColumnMap],
    path: &Path,
    place: usize,
) -> Result<Readable, Failure> {
    let time = arguments.time.get(place).or(arguments.time.last());
    let number = arguments.flight.get(place).or(arguments.flight.last()).copied();
    let mut sources = open(&[path.to_path_buf()], columns)?;
    // there is one for each file
    Readable::new(sources.swap_remove(0), number, time)
}
