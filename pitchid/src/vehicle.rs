//! The vehicle's file, `pitchid.toml`: what would otherwise stand on every command line.
//!
//! It is found in the working directory or the nearest folder above, up to the home folder. Options of the command line go first.

use crate::axes::AxisChoice;
use crate::failure::Failure;
use crate::format::plural;
use crate::output;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use sysid::error::{Error, ErrorKind};
use sysid::files;
use sysid::legal::Legal;
use sysid::model::file::{ModelFile, PlantSection};
use sysid::recording::{ColumnMap, InputHold, Note, NoteKind, Recording, SectionSpec};
use sysid::toml_file::{Entry, Source};

/// Its name.
pub const NAME: &str = "pitchid.toml";
const ADVICE: &str = "docs/formats.md lists the keys; --no-vehicle-file goes on without the file";

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
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Limits {
    /// Largest attitude, rad.
    pub attitude_rad: Option<f64>,
    /// Largest input, in its unit.
    pub input: Option<f64>,
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
    let passed_over = |mut error: Error| {
        error.advice = format!("{}; {ADVICE}", error.advice).into();
        error.in_file(name)
    };
    Ok(parse(path, &text).map_err(passed_over)?)
}

/// What is legal of an inertia.
const INERTIA: Legal = Legal::positive("kg m²");

fn parse(path: &Path, text: &str) -> Result<Vehicle, Error> {
    let source = Source::new(text);
    let document = source.document(ADVICE)?;
    let root = source.root(&document);
    root.only(&["axis", "input", "model", "inertia_kg_m2", "columns", "sections", "limits"]);
    let word = |key: &str, legal: &str| Some((root.get(key)?, root.text(key, legal)?));
    let (axes, holds) = ("roll, pitch, yaw or all", "held or interpolated");
    let axis = word("axis", axes).and_then(|(entry, word)| {
        <AxisChoice as ValueEnum>::from_str(word, false).map_err(|_| entry.refuse(axes)).ok()
    });
    let input = word("input", holds)
        .and_then(|(entry, word)| word.parse::<InputHold>().map_err(|_| entry.refuse(holds)).ok());
    let folder = path.parent().unwrap_or(Path::new(""));
    let model = root.text("model", "the name of a model file").map(|model| folder.join(model));
    let texts = |section: &str, legal: &'static str| -> Vec<(Entry<'_>, String)> {
        let entries = root.table(section).into_iter().flat_map(|table| table.entries());
        entries.filter_map(|entry| Some((entry, entry.text(legal)?.to_owned()))).collect()
    };
    let mut columns = Vec::new();
    for (entry, text) in texts("columns", "a column or an expression over columns") {
        match ColumnMap::from_str(&format!("{}={text}", entry.key)) {
            Ok(map) => columns.push(map),
            Err(error) => source.keep(placed(error, entry)),
        }
    }
    let (mut sections, mut labels) = (Vec::new(), Vec::new());
    for (entry, text) in texts("sections", "a time FROM..TO in s, or a label of the file") {
        if !text.contains("..") {
            labels.push((entry.key.to_owned(), text));
            continue;
        }
        match SectionSpec::from_str(&format!("{}={text}", entry.key)) {
            Ok(spec) => sections.push(spec),
            Err(error) => source.keep(placed(error, entry)),
        }
    }
    let limits = root.table("limits").map_or(Limits::default(), |table| {
        table.only(&["attitude_rad", "input"]);
        Limits {
            attitude_rad: table.number("attitude_rad", &Legal::positive("rad")),
            input: table.number("input", &Legal::positive("")),
        }
    });
    let inertia = root.number("inertia_kg_m2", &INERTIA);
    source.finish(Some(Vehicle {
        path: path.to_owned(),
        axis,
        input,
        model,
        inertia,
        columns,
        sections,
        labels,
        limits,
    }))
}

/// An option's refusal at the key of the file where it stands.
fn placed(mut error: Error, at: Entry<'_>) -> Error {
    error.kind = ErrorKind::Model;
    error.at_line(at.line).in_column(at.key)
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

    const WORDS: [&str; 24] = [
        "axis",
        "input",
        "model",
        "inertia_kg_m2",
        "[columns]",
        "[sections]",
        "[limits]",
        "attitude_rad",
        "q_rad_s",
        "u_norm",
        "I",
        "IV",
        " = ",
        "\"",
        "\n",
        "roll",
        "held",
        "-gy*pi/180",
        "5..30",
        "hold",
        "0.3",
        "-1e400",
        "[[",
        "\u{b0}",
    ];

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(2000))]

        /// Whatever stands in it is taken or refused with the line, and what is taken can be told.
        #[test]
        fn anything_is_taken_or_refused(words in proptest::collection::vec(0..WORDS.len(), 0..40), other in "\\PC{0,12}") {
            let text: String = words.iter().map(|i| WORDS[*i]).chain([other.as_str()]).collect();
            match vehicle(&text) {
                Ok(found) => proptest::prop_assert!(!found.told().is_empty()),
                Err(error) => proptest::prop_assert!(error.line.is_some(), "{error:?}"),
            }
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, line, says) in [
            ("axis = \"roll\"\nmass = 3\n", 2, "key mass: unknown key"),
            ("\naxis = \"up\"\n", 2, "key axis: found \"up\"\n  expected: roll, pitch, yaw or all"),
            ("axis = 3\n", 1, "found 3\n  expected: roll, pitch, yaw or all, in quotes"),
            ("input = \"hold\"\n", 1, "key input: found \"hold\"\n  expected: held or interpolated"),
            ("inertia_kg_m2 = 0.0\n", 1, "inertia_kg_m2: found 0.0\n  expected: a number above 0"),
            ("inertia_kg_m2 = 1e300\n", 1, "up to 1e12, in kg m²"),
            ("inertia_kg_m2 = \"0.1\"\n", 1, "found \"0.1\""),
            ("model = 3\n", 1, "the name of a model file, in quotes"),
            ("[columns]\nq_rad_s = \"gy\"\nspeed = \"v\"\n", 3, "speed"),
            ("[columns]\n\nq_rad_s = \"gy*\"\n", 3, "ends too early"),
            ("[columns]\nq_rad_s = 3\n", 2, "a column or an expression over columns, in quotes"),
            ("columns = 3\n", 1, "a section [columns]"),
            ("[sections]\nIV = \"9..3\"\n", 2, "IV"),
            ("# attitude_rad\n[limits]\nattitude_rad = -0.1\n", 3, "attitude_rad: found -0.1"),
            ("[limits]\ninput = inf\n", 2, "input: found inf\n  expected: a number above 0 and up to 1e12"),
            ("[limits]\ninput = nan\n", 2, "input: found nan"),
            ("[limits]\ndegrees = 3\n", 2, "key degrees: unknown key\n  expected: one of "),
            ("axis = \n", 1, ""),
        ] {
            let error = vehicle(text).unwrap_err();
            assert_eq!(error.line, Some(line), "{text}: {error}");
            assert!(error.to_string().contains(says), "{text}: {error}");
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
