//! Model files: what the user's simulation contains, as TOML, read and written.
//!
//! ```toml
//! [plant]
//! inertia_kg_m2 = 0.1705
//! delay_s = 0.06
//! dM_dq_N_m_s = -0.27
//! dM_du_N_m = 23.0
//!
//! [[effect]]
//! id = "gravity_stiffness"
//! G = 0.4
//!
//! [[effect]]                    # a term without a name: docs/unlisted-terms.md
//! id = "unlisted"
//! shape = "of_theta_by_side"
//! c1_N_m = -0.021
//! c2_N_m = 0.034
//! scale_q_rad_s = 0.31          # what rate, angle, input and time are divided by in its shapes
//! scale_theta_rad = 0.12
//! scale_u = 0.015
//! duration_s = 98.4
//! ```
//!
//! A vehicle has a model per axis: `[roll]`, `[pitch]` and `[yaw]` have the keys of `[plant]`, which is that of the axes without
//! one; an effect with `axis = "roll"` is of that axis alone, an interval too by a key that begins with `roll.`.

mod axes;
mod effect;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::error::{Error, ErrorKind};
use crate::files;
pub use axes::to_toml;
pub use effect::{EffectEntry, KnownEffect, SCALES};

/// A model: the plant, the effects it has besides, and what is known of the parameters' uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelFile {
    /// The grey-box plant.
    pub plant: PlantSection,
    /// Physics that this simulation already has.
    #[serde(rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectEntry>,
    /// Intervals by name: a key of `[plant]`, a parameter of an effect (`G`), or `id.parameter`.
    #[serde(rename = "interval", skip_serializing_if = "BTreeMap::is_empty")]
    pub intervals: BTreeMap<String, Interval>,
}

/// The plant; what is absent is not modelled, without the three mount values the IMU is rigidly fixed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantSection {
    /// Pitch inertia Iyy, kg m²; > 0. With 1.0 every moment is per unit inertia.
    pub inertia_kg_m2: f64,
    /// Delay τ of the input, s; ≥ 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// ∂M/∂q, N m s/rad.
    #[serde(rename = "dM_dq_N_m_s", skip_serializing_if = "Option::is_none")]
    pub dm_dq: Option<f64>,
    /// ∂M/∂u, N m per unit of the recording's input column.
    #[serde(rename = "dM_du_N_m", skip_serializing_if = "Option::is_none")]
    pub dm_du: Option<f64>,
    /// Mount stiffness k, N m/rad; > 0.
    #[serde(rename = "mount_k_N_m", skip_serializing_if = "Option::is_none")]
    pub mount_k: Option<f64>,
    /// Mount damping c, N m s/rad; > 0.
    #[serde(rename = "mount_c_N_m_s", skip_serializing_if = "Option::is_none")]
    pub mount_c: Option<f64>,
    /// Inertia J on the mount, kg m²; > 0.
    #[serde(rename = "mount_J_kg_m2", skip_serializing_if = "Option::is_none")]
    pub mount_j: Option<f64>,
}

/// What is known of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// 95 % interval, low ≤ high, in the parameter's unit.
    pub ci95: [f64; 2],
}

/// The axes that a model file may tell apart.
pub const AXES: [&str; 3] = ["roll", "pitch", "yaw"];
/// The axis that is meant where none is said.
const USUAL: &str = "pitch";

/// The file as it stands, with the place of everything that is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    plant: Option<Spanned<PlantSection>>,
    roll: Option<Spanned<PlantSection>>,
    pitch: Option<Spanned<PlantSection>>,
    yaw: Option<Spanned<PlantSection>>,
    #[serde(default)]
    effect: Vec<effect::Raw>,
    #[serde(default)]
    interval: BTreeMap<Spanned<String>, Spanned<Interval>>,
}

/// Reads the model of `axis`, one of [`AXES`], in a model file; without one what a model of one axis has, else pitch. `effects` is
/// the catalogue against which ids and parameter names are checked.
///
/// # Errors
/// As [`parse`], and where the file cannot be read.
pub fn read(path: &Path, axis: Option<&str>, effects: &[KnownEffect]) -> Result<ModelFile, Error> {
    let text = files::read_text(path, "name a model file (TOML); recordings are given without --model")?;
    parse(&path.display().to_string(), &text, axis, effects)
}

/// Reads the text of a model file; `name` stands for the file in messages.
///
/// # Errors
/// No TOML, an unknown key, effect or parameter, a value of the wrong type or outside its legal range, a mount with
/// one or two of its three values, no plant of `axis`. The error names the file and the line.
pub fn parse(
    name: &str,
    text: &str,
    axis: Option<&str>,
    effects: &[KnownEffect],
) -> Result<ModelFile, Error> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    parse_unnamed(&Source { text }, axis, effects).map_err(|error| error.in_file(name))
}

fn parse_unnamed(source: &Source, axis: Option<&str>, table: &[KnownEffect]) -> Result<ModelFile, Error> {
    let raw: Raw = toml::from_str(source.text).map_err(|error| source.syntax(&error))?;
    let plant = plant_of(source, axis, &raw)?;
    let axis = axis.unwrap_or(USUAL);
    let mut effects = Vec::new();
    for entry in raw.effect {
        let (of, entry) = effect::checked(source, entry, table)?;
        if of.is_none_or(|of| of == axis) {
            effects.push(entry);
        }
    }
    let mut intervals = BTreeMap::new();
    for (key, interval) in raw.interval {
        let line = source.line(interval.span().start);
        let Some(own) = axes::key_of(key.get_ref(), axis) else { continue };
        let interval = interval.into_inner();
        check_interval(own, interval, &effects)
            .map_err(|error| error.at_line(line).in_column(key.get_ref().as_str()))?;
        intervals.insert(own.to_owned(), interval);
    }
    Ok(ModelFile { plant, effects, intervals })
}

/// The plant of `axis`, all of them checked.
fn plant_of(source: &Source, axis: Option<&str>, raw: &Raw) -> Result<PlantSection, Error> {
    let of_axes = AXES.into_iter().zip([&raw.roll, &raw.pitch, &raw.yaw]);
    let all = || of_axes.clone().chain([("plant", &raw.plant)]).filter_map(|(n, p)| Some((n, p.as_ref()?)));
    for (_, plant) in all() {
        check_plant(plant.get_ref()).map_err(|error| {
            let key = error.column.as_deref().unwrap_or_default();
            let line = source.line_of_key(plant.span().start, key);
            error.at_line(line)
        })?;
    }
    let section = |name: &str| all().find(|(own, _)| *own == name).map(|(_, plant)| *plant.get_ref());
    let found = match axis {
        Some(axis) => section(axis).or_else(|| section("plant")),
        None => section("plant").or_else(|| section(USUAL)),
    };
    found.ok_or_else(|| {
        let names: Vec<String> = all().map(|(name, _)| format!("[{name}]")).collect();
        let found = match names.is_empty() {
            true => "no plant".to_owned(),
            false => format!("no plant of {}, only {}", axis.unwrap_or(USUAL), names.join(", ")),
        };
        let help = "add a section [plant] with inertia_kg_m2 = NUMBER, or one for each axis";
        Error::new(ErrorKind::Model, found, help)
    })
}

/// The text, for the lines of messages.
struct Source<'a> {
    text: &'a str,
}

impl Source<'_> {
    fn line(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|&b| b == b'\n').count()
    }

    /// The line on which `key` is set in the table that begins at `table`, or the table's own line.
    fn line_of_key(&self, table: usize, key: &str) -> usize {
        let first = self.line(table);
        let lines = self.text.lines().enumerate().skip(first.saturating_sub(1));
        let found = lines
            .filter(|(_, line)| {
                line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='))
            })
            .map(|(index, _)| index + 1)
            .next();
        found.unwrap_or(first)
    }

    fn syntax(&self, error: &toml::de::Error) -> Error {
        let message = error.message().replace('\n', ", ");
        let advice = match () {
            () if message.contains("unknown field") => "correct the key or delete the line",
            () if message.contains("missing field") => "add the key",
            () if message.contains("invalid type") => {
                "write a number, with a decimal point and without a unit"
            }
            () => {
                "correct the line: KEY = NUMBER, [plant] or [roll], [pitch], [yaw], [[effect]] or [interval.KEY]"
            }
        };
        let error_here = Error::new(ErrorKind::Model, message, advice);
        match error.span() {
            Some(span) => error_here.at_line(self.line(span.start)),
            None => error_here,
        }
    }
}

/// Key, value, whether a value is legal, what is legal in words.
type PlantCheck = (&'static str, Option<f64>, fn(f64) -> bool, &'static str);

/// The error names the key.
fn check_plant(plant: &PlantSection) -> Result<(), Error> {
    let checks: [PlantCheck; 7] = [
        ("inertia_kg_m2", Some(plant.inertia_kg_m2), positive, "a number above 0, in kg m²"),
        ("delay_s", plant.delay_s, |v| (0.0..=10.0).contains(&v), "a number from 0 to 10, in s"),
        ("dM_dq_N_m_s", plant.dm_dq, f64::is_finite, "a finite number, in N m s/rad"),
        ("dM_du_N_m", plant.dm_du, f64::is_finite, "a finite number, in N m per unit of the input"),
        ("mount_k_N_m", plant.mount_k, positive, "a number above 0, in N m/rad"),
        ("mount_c_N_m_s", plant.mount_c, positive, "a number above 0, in N m s/rad"),
        ("mount_J_kg_m2", plant.mount_j, positive, "a number above 0, in kg m²"),
    ];
    for (key, value, legal, expected) in checks {
        if let Some(value) = value.filter(|&v| !legal(v)) {
            let error = Error::new(ErrorKind::Model, format!("found {value}"), "correct the value");
            return Err(error.expecting(expected).in_column(key));
        }
    }
    let mount = &checks[4..];
    let given: Vec<&str> = mount.iter().filter(|check| check.1.is_some()).map(|check| check.0).collect();
    let Some(key) = mount.iter().map(|check| check.0).find(|key| given.contains(key)) else { return Ok(()) };
    if given.len() == mount.len() {
        return Ok(());
    }
    let advice = "add what is missing, or delete these lines for an IMU that is rigidly fixed";
    let error = Error::new(ErrorKind::Model, format!("a mount with only {}", given.join(", ")), advice);
    let error = error.expecting("mount_k_N_m, mount_c_N_m_s and mount_J_kg_m2, all three or none");
    Err(error.in_column(key))
}

fn positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

const PLANT_KEYS: [&str; 7] =
    ["inertia_kg_m2", "delay_s", "dM_dq_N_m_s", "dM_du_N_m", "mount_k_N_m", "mount_c_N_m_s", "mount_J_kg_m2"];

fn check_interval(key: &str, interval: Interval, effects: &[EffectEntry]) -> Result<(), Error> {
    let [low, high] = interval.ci95;
    if !(low.is_finite() && high.is_finite() && low <= high) {
        let found = format!("ci95 = [{low}, {high}]");
        return Err(Error::new(ErrorKind::Model, found, "correct the interval")
            .expecting("[low, high], finite, low first"));
    }
    let of_effect = |effect: &EffectEntry| {
        let name =
            key.strip_prefix(effect.id.as_str()).and_then(|rest| rest.strip_prefix('.')).unwrap_or(key);
        effect.parameters.contains_key(name)
    };
    if PLANT_KEYS.contains(&key) || effects.iter().any(of_effect) {
        return Ok(());
    }
    let advice = "correct the name or delete the interval";
    Err(Error::new(ErrorKind::Model, "an interval of something that is not in this file", advice)
        .expecting(format!("{}, or a parameter of an effect above", PLANT_KEYS.join(", "))))
}

impl ModelFile {
    /// The model of who has none: unit inertia, by which every moment is divided, and nothing else.
    pub fn unknown() -> Self {
        let plant = PlantSection {
            inertia_kg_m2: 1.0,
            delay_s: None,
            dm_dq: None,
            dm_du: None,
            mount_k: None,
            mount_c: None,
            mount_j: None,
        };
        Self { plant, effects: Vec::new(), intervals: BTreeMap::new() }
    }

    /// The file's text; reads back to the same model.
    ///
    /// # Errors
    /// A value that is not finite, which TOML could write but [`parse`] would refuse.
    pub fn to_toml(&self) -> Result<String, Error> {
        check_plant(&self.plant)?;
        let values = self.effects.iter().flat_map(|effect| &effect.parameters);
        if let Some((key, value)) = values.into_iter().find(|(_, value)| !value.is_finite()) {
            let error = Error::new(
                ErrorKind::Model,
                format!("found {value}"),
                "do not write a model that did not converge",
            );
            return Err(error.in_column(key.as_str()).expecting("a finite number"));
        }
        for (key, interval) in &self.intervals {
            check_interval(key, *interval, &self.effects).map_err(|error| error.in_column(key.as_str()))?;
        }
        let text = toml::to_string(self).map_err(|error| {
            Error::new(ErrorKind::Model, format!("cannot be written as TOML: {error}"), "report this")
        })?;
        Ok(self.with_remarks(&text))
    }

    /// `text` with each effect's remark above its entry.
    fn with_remarks(&self, text: &str) -> String {
        let mut remarks = self.effects.iter().map(|effect| effect.remark.as_deref());
        let mut whole = String::new();
        for line in text.lines() {
            if line == "[[effect]]"
                && let Some(remark) = remarks.next().flatten()
            {
                whole.push_str(&format!("# {remark}\n"));
            }
            whole.push_str(line);
            whole.push('\n');
        }
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> [KnownEffect; 2] {
        let named = |id, parameters| KnownEffect { id, shape: None, parameters };
        [named("gravity_stiffness", vec!["G"]), named("inflow_lag", vec!["g", "T_lambda"])]
    }
    const FULL: &str = "# in use\n[plant]\ninertia_kg_m2 = 0.1705\ndelay_s = 0.06\ndM_dq_N_m_s = -0.27\n\
        dM_du_N_m = 23\nmount_k_N_m = 3.87\nmount_c_N_m_s = 0.0264\nmount_J_kg_m2 = 5.0e-4\n\n\
        [[effect]]\nid = \"gravity_stiffness\"\nG = 0.4\n\n[[effect]]\nid = \"inflow_lag\"\ng = 0.3\nT_lambda = 1\n\n\
        [interval.dM_dq_N_m_s]\nci95 = [-0.29, -0.25]\n[interval.G]\nci95 = [0.3, 0.5]\n\
        [interval.\"inflow_lag.g\"]\nci95 = [0, 1]\n";

    fn refused(text: &str) -> Error {
        parse("m.toml", text, None, &table()).expect_err("this model must be refused")
    }

    #[test]
    fn reads_every_part() {
        let model = parse("m.toml", FULL, None, &table()).unwrap();
        assert_eq!((model.plant.dm_dq, model.plant.dm_du), (Some(-0.27), Some(23.0)));
        assert_eq!(model.plant.mount_j, Some(5.0e-4));
        assert_eq!(model.effects[1].parameters["T_lambda"], 1.0);
        assert_eq!(model.intervals["G"].ci95, [0.3, 0.5]);
        let least = parse("m.toml", "[plant]\ninertia_kg_m2 = 1.0", None, &table()).unwrap();
        assert_eq!((least.plant.delay_s, least.plant.mount_k), (None, None));
    }

    #[test]
    fn what_is_written_reads_back() {
        let model = parse("m.toml", FULL, None, &table()).unwrap();
        let text = model.to_toml().unwrap();
        assert_eq!(parse("m.toml", &text, None, &table()).unwrap(), model, "{text}");
        let mut broken = model;
        broken.plant.dm_dq = Some(f64::NAN);
        assert!(broken.to_toml().is_err());
    }

    #[test]
    fn malformed_models_name_line_key_and_advice() {
        let full = |from: &str, to: &str| FULL.replacen(from, to, 1);
        let cases: [(String, usize, &str); 18] = [
            (full("delay_s", "delay"), 4, "unknown field `delay`"),
            (full("inertia_kg_m2 = 0.1705", "inertia_kg_m2 = \"a\""), 3, "invalid type"),
            (full("inertia_kg_m2 = 0.1705", "inertia_kg_m2 = 0.1705 kg"), 3, "advice"),
            (full("inertia_kg_m2 = 0.1705\n", ""), 2, "missing field `inertia_kg_m2`"),
            (full("0.1705", "-0.1705"), 3, "inertia_kg_m2: found -0.1705\n  expected: a number above 0"),
            (full("0.1705", "nan"), 3, "found NaN"),
            (full("delay_s = 0.06", "delay_s = -0.06"), 4, "a number from 0 to 10, in s"),
            (full("-0.27", "inf"), 5, "dM_dq_N_m_s: found inf"),
            (full("3.87", "0"), 7, "mount_k_N_m: found 0"),
            (full("mount_c_N_m_s = 0.0264\n", ""), 7, "only mount_k_N_m, mount_J_kg_m2"),
            (
                full("gravity_stiffness", "gravity"),
                12,
                "unknown effect \"gravity\"\n  expected: one of gravity_stiffness, inflow_lag",
            ),
            (full("id = \"gravity_stiffness\"\n", ""), 11, "an effect without id"),
            (full("G = 0.4", "K = 0.4"), 13, "K: unknown parameter\n  expected: gravity_stiffness with G"),
            (full("G = 0.4", "G = \"x\""), 13, "a finite number"),
            (full("T_lambda = 1\n", ""), 16, "inflow_lag without T_lambda"),
            (full("interval.G", "interval.H"), 22, "not in this file"),
            (full("[0.3, 0.5]", "[0.5, 0.3]"), 22, "low first"),
            (full("[[effect]]", "[[effects]]"), 11, "unknown field `effects`"),
        ];
        for (text, line, part) in cases {
            let error = refused(&text);
            let message = error.to_string();
            assert_eq!(error.line, Some(line), "{message}\n{text}");
            assert!(message.starts_with(&format!("m.toml, line {line}")), "{message}");
            assert!(message.contains(part) && message.contains("advice: "), "{part} is not in\n{message}");
        }
    }
}
