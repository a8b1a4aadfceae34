//! A file, step by step up to the first thing that is wrong.

use super::{Examined, Step};
use crate::axes::{AxisChoice, Readable};
use crate::commands::reading::{as_options, options_with};
use crate::commands::show::content::{ShownAxis, of_flight, of_recording};
use crate::failure::Failure;
use crate::format::plural;
use crate::input;
use crate::logs::excitation::Span;
use crate::logs::{Flight, Source, format_name, open, quoted};
use crate::vehicle::Vehicle;
use flight_logs::axes::Axis;
use std::path::Path;
use sysid::dataset::Dataset;
use sysid::diagnosis::data_checks::{Gravity, State, of_recordings};
use sysid::recording::{ColumnMap, ReadOptions, Recording};

/// Names of a folder that are listed.
const LISTED: usize = 5;

/// Flights below this length are no flights but the beginning of one, s.
const SHORTEST_S: f64 = 1.0;

/// Looks at one file.
pub fn examined(path: &Path, given: &[ColumnMap], vehicle: &Result<Option<Vehicle>, Failure>) -> Examined {
    let mut steps = Vec::new();
    let next = examine(path, given, vehicle, &mut steps).unwrap_or_else(|wrong| {
        steps.push(wrong);
        None
    });
    Examined { name: Some(input::name_of(path)), steps, next }
}

/// The next command; what is wrong ends it.
fn examine(
    path: &Path,
    given: &[ColumnMap],
    vehicle: &Result<Option<Vehicle>, Failure>,
    steps: &mut Vec<Step>,
) -> Result<Option<String>, Step> {
    steps.extend(there(path)?);
    let vehicle = vehicle.as_ref().map_err(Step::of)?.as_ref();
    let mut columns = given.to_vec();
    columns.extend(vehicle.map_or(Vec::new(), |vehicle| vehicle.columns_beside(given)));
    let options = ReadOptions {
        sections: vehicle.map_or(Vec::new(), |vehicle| vehicle.sections.clone()),
        ..options_with(vehicle.and_then(|vehicle| vehicle.input).unwrap_or_default(), &columns)
    };
    if let Some(vehicle) = vehicle {
        steps.push(Step::well(format!("from {}: {}", vehicle.path.display(), vehicle.told())));
    }
    let axis = vehicle.and_then(|vehicle| vehicle.axis).and_then(AxisChoice::one);
    let source = open(&[path.to_path_buf()], &columns).map_err(|failure| Step::of(&failure))?.swap_remove(0);
    match source {
        Source::Log(flights) => log(flights, axis, &options, steps),
        Source::Recording(_) => {
            let table = Readable::new(source, None, None).map_err(|failure| Step::of(&failure))?;
            let found = table.recording(axis, false, &options).map_err(|failure| Step::of(&failure))?;
            steps.push(Step::well(format!(
                "a recording: {} at {:.1} Hz, {:.1} s",
                plural(found.len() as u64, "row"),
                1.0 / found.step,
                found.len() as f64 * found.step
            )));
            checked(&found, steps)?;
            let option = axis.map_or(String::new(), |axis| format!(" --axis {axis}"));
            Ok(Some(format!("pitchid diagnose {}{}{option}", quoted(path), as_options(given))))
        }
    }
}

/// Whether it is there and holds something.
fn there(path: &Path) -> Result<Option<Step>, Step> {
    if input::is_stdin(path) {
        return Ok(None);
    }
    if path.is_dir() {
        let names = std::fs::read_dir(path).into_iter().flatten().flatten();
        let mut names: Vec<String> = names.map(|entry| entry.file_name().display().to_string()).collect();
        names.sort();
        let listed = names.iter().take(LISTED).cloned().collect::<Vec<_>>().join(", ");
        let inside = if names.is_empty() { "it is empty".to_owned() } else { format!("in it are {listed}") };
        return Err(Step::wrong("this is a folder", format!("name a file inside it; {inside}")));
    }
    let metadata = std::fs::metadata(path)
        .map_err(|error| Step::of(&sysid::error::Error::from_io(&input::name_of(path), &error).into()))?;
    if metadata.is_file() && metadata.len() == 0 {
        let remedy = "copy it again from the card or the board; a log that was not closed can be empty";
        return Err(Step::wrong("the file is empty", remedy));
    }
    Ok(metadata.is_file().then(|| Step::well(format!("the file is there: {}", size(metadata.len())))))
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => plural(bytes, "byte"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// The flights of a log: the next command is that of the longest motion.
fn log(
    flights: Vec<Flight>,
    axis: Option<Axis>,
    options: &ReadOptions,
    steps: &mut Vec<Step>,
) -> Result<Option<String>, Step> {
    let axes: Vec<Axis> = axis.map_or(Axis::ALL.to_vec(), |axis| vec![axis]);
    let mut best: Option<(f64, String, Flight, Axis)> = None;
    let mut hindered = Vec::new();
    for flight in flights {
        let shown = of_flight(&flight, &axes);
        let span = flight.log.span_s().map_or(0.0, |[from, to]| to - from);
        let firmware = shown.firmware.as_deref().unwrap_or("firmware unknown");
        let which = if flight.one_of_several { format!("flight {}: ", flight.number) } else { String::new() };
        steps.push(Step::well(format!("{which}{}, {firmware}; {span:.1} s", format_name(flight.log.format))));
        if let [first, rest @ ..] = flight.log.notes.as_slice() {
            let more = if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
            steps.push(Step::doubtful(format!("{first}{more}"), "what is whole is used all the same"));
        }
        if span < SHORTEST_S {
            let remedy = "copy it again whole from the card or the board; pitchid show tells what is in it";
            hindered
                .push(Step::wrong(format!("{which}only {span:.1} s of measurements can be read"), remedy));
            continue;
        }
        let mut serving = Vec::new();
        for (shown, axis) in shown.axes.iter().zip(&axes) {
            if shown.can_serve {
                serving.push((shown, *axis));
            } else {
                hindered.push(shown_hindrance(shown));
            }
        }
        let longest = |spans: &[Span]| {
            spans.iter().map(|span| span.time_s).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
        };
        let found = serving.iter().filter_map(|(shown, axis)| Some((longest(&shown.excitation)?, *axis)));
        let found = found.max_by(|(a, _), (b, _)| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        if let Some(([from, to], axis)) = found
            && best.as_ref().is_none_or(|(length, ..)| to - from > *length)
        {
            let number =
                if flight.one_of_several { format!(" --flight {}", flight.number) } else { String::new() };
            let time = format!(" --time {}..{}", from.floor(), to.ceil());
            let command = format!("pitchid diagnose {} --axis {axis}{number}{time}", flight.files());
            best = Some((to - from, command, flight, axis));
        }
    }
    let Some((length, command, flight, axis)) = best else {
        return Err(hindered.into_iter().next().unwrap_or_else(|| {
            let remedy = "excite an axis in flight: doublets by stick, a sweep, or pitchid fly; pitchid show tells where it moves";
            Step::wrong("no axis moves for three seconds on end", remedy)
        }));
    };
    steps.push(Step::well(format!("{axis} can be asked: its input moves for {length:.0} s")));
    let readable =
        Readable::new(Source::Log(vec![flight]), None, None).map_err(|failure| Step::of(&failure))?;
    let found = readable.recording(Some(axis), true, options).map_err(|failure| Step::of(&failure))?;
    checked(&found, steps)?;
    Ok(Some(command))
}

/// Why an axis cannot serve, and what to set.
fn shown_hindrance(axis: &ShownAxis) -> Step {
    let settings: Vec<String> =
        axis.settings.iter().map(|s| format!("{} = {} ({})", s.parameter, s.value, s.effect)).collect();
    let remedy = match settings.is_empty() {
        true => "pitchid show tells what is in the log, and where something moves".to_owned(),
        false => format!("before the next flight set {}", settings.join(", ")),
    };
    Step::wrong(format!("{} cannot serve: {}", axis.axis, axis.hindrances.join("; ")), remedy)
}

/// What the recording alone says: motion, and the checks of the data.
fn checked(recording: &Recording, steps: &mut Vec<Step>) -> Result<(), Step> {
    let shown = of_recording(recording, None);
    if shown.excitation.is_empty() {
        let remedy =
            "excite the axis: doublets, a sweep, or a PRBS as pitchid fly and pitchid simulate make it";
        return Err(Step::wrong("the input moves nowhere for three seconds on end", remedy));
    }
    let moving: f64 = shown.excitation.iter().map(|span| span.time_s[1] - span.time_s[0]).sum();
    steps.push(Step::well(format!("the input moves for {moving:.0} s")));
    let recordings = std::slice::from_ref(recording);
    let data = Dataset::new(recordings).map_err(|error| Step::of(&error.into()))?;
    for check in
        of_recordings(recordings, &data, None).into_iter().filter(|check| check.state == State::Found)
    {
        let remedy = "the option that puts it right stands above; pitchid diagnose tells the same";
        match check.gravity {
            Gravity::Stops => return Err(Step::wrong(check.words, remedy)),
            Gravity::Told | Gravity::Headline => {
                steps.push(Step::doubtful(
                    check.words,
                    "nothing has to be done: pitchid diagnose takes it into account",
                ));
            }
        }
    }
    steps.push(Step::well("clock, channels, signs and units: nothing that stops a diagnosis"));
    Ok(())
}
