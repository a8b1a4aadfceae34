//! The vehicle's file, `pitchid.toml`: what would otherwise stand on every command line.
//!
//! It is found in the working directory or the nearest folder above, up to the home folder. Options of the command line go first.

use crate::axes::AxisChoice;
use crate::failure::Failure;
use crate::format::plural;
use crate::output;
use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use sysid::error::{Error, ErrorKind};
use sysid::files;
use sysid::model::file::{ModelFile, PlantSection};
use sysid::recording::{ColumnMap, InputHold, Note, NoteKind, Recording, SectionSpec};
use toml::Spanned;

/// Its name.
pub const NAME: &str = "pitchid.toml";
const ADVICE: &str = "docs/formats.md lists the keys; --no-vehicle-file goes on without it";

/// Whether the file is wanted.
#[derive(Args, Clone, Debug, Default)]
pub struct Wanted {
    /// Do not look for pitchid.toml, in which axis, columns, sections, model, inertia and limits of a vehicle may stand
    /// (see docs/formats.md)
    #[arg(long, help_heading = "Reading")]
    no_vehicle_file: bool,
}

/// What the file says.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// Where it was found.
    pub path: PathBuf,
    /// The axis that is meant.
    pub axis: Option<AxisChoice>,
    /// The input between samples.
    pub input: Option<InputHold>,
    /// The model in use, as seen from the working directory.
    pub model: Option<PathBuf>,
    /// Moment of inertia, kg m², where there is no model.
    pub inertia: Option<f64>,
    /// Columns of other names.
    pub columns: Vec<ColumnMap>,
    /// Sections by time.
    pub sections: Vec<SectionSpec>,
    /// Sections by the file's labels: the name, and the label.
    labels: Vec<(String, String)>,
    /// Within what it is to stay.
    pub limits: Limits,
}

/// Within what the vehicle is to stay.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest attitude, rad.
    pub attitude_rad: Option<f64>,
    /// Largest input, in its unit.
    pub input: Option<f64>,
}

/// The file as it stands.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    axis: Option<Spanned<String>>,
    input: Option<Spanned<String>>,
    model: Option<PathBuf>,
    inertia_kg_m2: Option<Spanned<f64>>,
    #[serde(default)]
    columns: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    sections: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    limits: Limits,
}

impl Wanted {
    /// The vehicle's file, where there is one and it is wanted.
    pub fn find(&self) -> Result<Option<Vehicle>, Failure> {
        if self.no_vehicle_file { Ok(None) } else { find() }
    }
}

/// Looks for the file, and reads it.
pub fn find() -> Result<Option<Vehicle>, Failure> {
    place().map(|path| read(&path)).transpose()
}

/// Where it is, as seen from the working directory: `pitchid.toml`, `../pitchid.toml`, ...
fn place() -> Option<PathBuf> {
    let here = std::env::current_dir().ok()?;
    let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE")).map(PathBuf::from);
    let mut up = PathBuf::new();
    for folder in here.ancestors() {
        let path = up.join(NAME);
        if path.is_file() {
            return Some(path);
        }
        if home.as_deref() == Some(folder) {
            return None;
        }
        up.push("..");
    }
    None
}

fn read(path: &Path) -> Result<Vehicle, Failure> {
    let text = files::read_text(path, ADVICE)?;
    let name = path.display().to_string();
    Ok(parse(path, &text).map_err(|error| error.in_file(name))?)
}

fn parse(path: &Path, text: &str) -> Result<Vehicle, Error> {
    let at = |start: usize, found: String| {
        let line = 1 + text[..start].matches('\n').count();
        Error::new(ErrorKind::Options, found, ADVICE).at_line(line)
    };
    let written: Written = toml::from_str(text)
        .map_err(|error| at(error.span().map_or(0, |span| span.start), error.message().trim().to_owned()))?;
    let axis = written.axis.map(|word| {
        let choice = <AxisChoice as ValueEnum>::from_str(word.get_ref(), false);
        choice.map_err(|_| {
            at(word.span().start, format!("axis {:?}", word.get_ref())).expecting("roll, pitch, yaw or all")
        })
    });
    let input = written.input.map(|word| {
        let hold = word.get_ref().parse::<InputHold>();
        hold.map_err(|_| {
            at(word.span().start, format!("input {:?}", word.get_ref())).expecting("held or interpolated")
        })
    });
    let inertia = written.inertia_kg_m2.map(|value| match *value.get_ref() {
        inertia if inertia > 0.0 && inertia.is_finite() => Ok(inertia),
        other => Err(at(value.span().start, format!("inertia_kg_m2 = {other}"))
            .expecting("a number above zero, kg m²")),
    });
    let limits = [("attitude_rad", written.limits.attitude_rad), ("input", written.limits.input)];
    if let Some((key, _)) =
        limits.into_iter().find(|(_, limit)| limit.is_some_and(|limit| limit.is_nan() || limit <= 0.0))
    {
        let start = text.find(key).unwrap_or(0);
        return Err(at(start, format!("the limit {key} is not above zero")).expecting("a number above zero"));
    }
    let columns = written.columns.iter().map(|(target, source)| {
        let map = ColumnMap::from_str(&format!("{target}={}", source.get_ref()));
        map.map_err(|error| placed(error, &at(source.span().start, String::new())))
    });
    let (mut sections, mut labels) = (Vec::new(), Vec::new());
    for (name, of) in &written.sections {
        if of.get_ref().contains("..") {
            let spec = SectionSpec::from_str(&format!("{name}={}", of.get_ref()));
            sections.push(spec.map_err(|error| placed(error, &at(of.span().start, String::new())))?);
        } else {
            labels.push((name.clone(), of.get_ref().clone()));
        }
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(Vehicle {
        path: path.to_owned(),
        axis: axis.transpose()?,
        input: input.transpose()?,
        model: written.model.map(|model| folder.join(model)),
        inertia: inertia.transpose()?,
        columns: columns.collect::<Result<_, _>>()?,
        sections,
        labels,
        limits: written.limits,
    })
}

/// An option's refusal at the line of the file where it stands.
fn placed(mut error: Error, at: &Error) -> Error {
    error.line = at.line;
    error.advice = ADVICE.into();
    error
}

impl Vehicle {
    /// The columns that are not mapped by `given`: of input, rate and angle one each.
    pub fn columns_beside(&self, given: &[ColumnMap]) -> Vec<ColumnMap> {
        let slot = |map: &ColumnMap| {
            let slots = ["u_", "q_", "theta_r", "theta_d"];
            let own = |start: &&str| map.target.starts_with(start) && map.target != "theta_ref_rad";
            slots.iter().position(own).map_or(map.target.clone(), |place| place.min(2).to_string())
        };
        let free = |map: &&ColumnMap| !given.iter().any(|other| slot(other) == slot(map));
        self.columns.iter().filter(free).cloned().collect()
    }

    /// A model of the inertia alone.
    pub fn inertia_model(&self) -> Option<(String, ModelFile)> {
        let inertia_kg_m2 = self.inertia?;
        let plant = PlantSection { inertia_kg_m2, ..ModelFile::unknown().plant };
        Some((self.path.display().to_string(), ModelFile { plant, ..ModelFile::unknown() }))
    }

    /// Names sections by the file's labels, and notes where the vehicle leaves its limits.
    pub fn complete(&self, recording: &mut Recording) {
        for (name, label) in &self.labels {
            let own = recording.sections.iter_mut().filter(|section| section.file_label == *label);
            for (section, count) in own.zip(1..) {
                section.label = if count == 1 { name.clone() } else { format!("{name}#{count}") };
                section.file_label.clone_from(name);
            }
        }
        let unit = recording.u_unit.symbol();
        let beyond = [
            ("angle", self.limits.attitude_rad, "rad", recording.theta.as_deref()),
            ("input", self.limits.input, unit, Some(&recording.u[..])),
        ];
        let note = |(what, limit, unit, values): (&str, Option<f64>, &str, Option<&[f64]>)| {
            let (limit, values) = limit.zip(values)?;
            let rows: Vec<usize> = (0..values.len()).filter(|&k| values[k].abs() > limit).collect();
            let (first, last) = rows.first().zip(rows.last())?;
            let unit = crate::format::unit(unit);
            let text = format!(
                "the {what} leaves the vehicle's limit of ±{limit} {unit} at {}, first at {:.2} s",
                plural(rows.len() as u64, "sample"),
                recording.t[*first]
            );
            let time_s = Some([recording.t[*first], recording.t[*last]]);
            Some(Note { kind: NoteKind::Converted, time_s, text: text.replace("  ", " ") })
        };
        let notes: Vec<Note> = beyond.into_iter().filter_map(note).collect();
        recording.notes.extend(notes);
    }

    /// What it holds, in a line: `axis roll, 2 columns`.
    pub fn told(&self) -> String {
        let mut parts = Vec::new();
        parts.extend(
            self.axis.and_then(|axis| Some(format!("axis {}", axis.to_possible_value()?.get_name()))),
        );
        parts.extend(self.model.as_ref().map(|model| format!("model {}", model.display())));
        parts.extend(self.inertia.map(|inertia| format!("inertia {inertia} kg m²")));
        parts.extend(self.input.map(|hold| match hold {
            InputHold::Held => "a held input".to_owned(),
            InputHold::Interpolated => "an interpolated input".to_owned(),
        }));
        let counted = [
            (self.columns.len(), "column"),
            (self.sections.len() + self.labels.len(), "section"),
            (
                usize::from(self.limits.attitude_rad.is_some()) + usize::from(self.limits.input.is_some()),
                "limit",
            ),
        ];
        parts.extend(
            counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| plural(*count as u64, what)),
        );
        if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") }
    }

    /// Says on standard error what is taken from it.
    pub fn say(&self) {
        if !output::is_quiet() {
            eprintln!("from {}: {}", self.path.display(), self.told());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle(text: &str) -> Result<Vehicle, Error> {
        parse(Path::new("../pitchid.toml"), text)
    }

    #[test]
    fn what_stands_in_it_is_taken() {
        let text = "axis = \"roll\"\ninput = \"interpolated\"\nmodel = \"craft.toml\"\n\n[columns]\nq_rad_s = \"-gy*pi/180\"\nu_norm = \"m\"\n\n\
                    [sections]\nI = \"5..30\"\nIV = \"hold\"\n\n[limits]\nattitude_rad = 0.3\n";
        let found = vehicle(text).unwrap();
        assert_eq!(
            found.told(),
            "axis roll, model ../craft.toml, an interpolated input, 2 columns, 2 sections, 1 limit"
        );
        let given = ["q_deg_s=g".parse().unwrap()];
        let beside = found.columns_beside(&given);
        assert_eq!(beside.len(), 1, "the rate of the command line goes first: {beside:?}");
        assert_eq!(beside[0].target, "u_norm");
        assert_eq!(vehicle("").unwrap().told(), "nothing");
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, line, says) in [
            ("axis = \"roll\"\nmass = 3\n", 2, "mass"),
            ("\naxis = \"up\"\n", 2, "axis \"up\""),
            ("inertia_kg_m2 = 0.0\n", 1, "inertia_kg_m2"),
            ("[columns]\nq_rad_s = \"gy\"\nspeed = \"v\"\n", 3, "speed"),
            ("[columns]\n\nq_rad_s = \"gy*\"\n", 3, "ends too early"),
            ("[sections]\nIV = \"9..3\"\n", 2, "IV"),
            ("[limits]\nattitude_rad = -0.1\n", 2, "attitude_rad"),
            ("[limits]\ndegrees = 3\n", 2, "degrees"),
            ("axis = \n", 1, ""),
        ] {
            let error = vehicle(text).unwrap_err();
            assert_eq!(error.line, Some(line), "{text}: {error}");
            assert!(error.to_string().contains(says), "{text}: {error}");
            assert!(error.to_string().contains("--no-vehicle-file"), "{error}");
        }
    }

    #[test]
    fn labels_are_renamed_and_limits_are_watched() {
        let mut text = "t_s,u_rad,q_rad_s,theta_rad,section\n".to_owned();
        for k in 0..200 {
            let t = 0.02 * f64::from(k);
            text += &format!(
                "{t:.2},{},{},{},{}\n",
                t.sin(),
                t.cos(),
                0.4 * t.sin(),
                if k < 100 { "hold" } else { "x" }
            );
        }
        let mut recording = sysid::recording::parse("a.csv", text.as_bytes(), &Default::default()).unwrap();
        vehicle("[sections]\nIV = \"hold\"\n[limits]\nattitude_rad = 0.3\ninput = 2.0\n")
            .unwrap()
            .complete(&mut recording);
        assert_eq!(recording.sections[0].label, "IV");
        let notes: Vec<&str> = recording.notes.iter().map(|note| note.text.as_str()).collect();
        assert_eq!(notes.iter().filter(|note| note.contains("limit of ±0.3 rad at")).count(), 1, "{notes:?}");
        assert!(!notes.iter().any(|note| note.contains("the input leaves")), "{notes:?}");
    }
}
