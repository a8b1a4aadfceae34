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
mod interval;
mod plant;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::error::{Error, ErrorKind};
use crate::files;
use crate::toml_file::{Source, Table};
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// 95 % interval, low ≤ high, in the parameter's unit.
    pub ci95: [f64; 2],
}

/// The axes that a model file may tell apart.
pub const AXES: [&str; 3] = ["roll", "pitch", "yaw"];
/// The axis that is meant where none is said.
const USUAL: &str = "pitch";

/// Said of an inertia of 1.
const UNIT_INERTIA: &str = " # not known, or 1: moments are per unit inertia, N m is rad/s²";

/// What a document is made of.
const ADVICE: &str =
    "correct the line: KEY = NUMBER, [plant] or [roll], [pitch], [yaw], [[effect]] or [interval.KEY]";

/// Reads the model of `axis`, one of [`AXES`], in a model file; without one what a model of one axis has, else pitch. `effects` is
/// the catalogue against which ids and parameters are checked.
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
/// No TOML, an unknown key, effect or parameter, an effect twice, a value of the wrong type or outside its legal range, a mount with
/// one or two of its three values, no plant of `axis`. The error names file, line and key, and what else is wrong with the file.
pub fn parse(
    name: &str,
    text: &str,
    axis: Option<&str>,
    effects: &[KnownEffect],
) -> Result<ModelFile, Error> {
    parse_unnamed(&Source::new(text), axis, effects).map_err(|error| error.in_file(name))
}

fn parse_unnamed(source: &Source<'_>, axis: Option<&str>, known: &[KnownEffect]) -> Result<ModelFile, Error> {
    let document = source.document(ADVICE)?;
    let root = source.root(&document);
    root.only(&["plant", AXES[0], AXES[1], AXES[2], "effect", "interval"]);
    let plant = plant_of(source, &root, axis);
    let axis = axis.unwrap_or(USUAL);
    let effects = effect::read(source, &root, known).into_iter();
    let effects: Vec<EffectEntry> =
        effects.filter(|(of, _)| of.as_ref().is_none_or(|of| of == axis)).map(|(_, effect)| effect).collect();
    let intervals = interval::read(source, &root, axis, &effects);
    source.finish(plant.map(|plant| ModelFile { plant, effects, intervals }))
}

/// The plant of `axis`, all of them checked.
fn plant_of(source: &Source<'_>, root: &Table<'_>, axis: Option<&str>) -> Option<PlantSection> {
    let names = || AXES.into_iter().chain(["plant"]).filter(|name| root.get(name).is_some());
    let plants: Vec<(&str, Option<PlantSection>)> =
        names().map(|name| (name, root.table(name).and_then(|table| plant::read(source, &table)))).collect();
    let section = |name: &str| plants.iter().find(|(own, _)| *own == name).map(|(_, plant)| *plant);
    let found = match axis {
        Some(axis) => section(axis).or_else(|| section("plant")),
        None => section("plant").or_else(|| section(USUAL)),
    };
    if found.is_none() {
        let names: Vec<String> = names().map(|name| format!("[{name}]")).collect();
        let found = match names.is_empty() {
            true => "no plant".to_owned(),
            false => format!("no plant of {}, only {}", axis.unwrap_or(USUAL), names.join(", ")),
        };
        let help = "add a section [plant] with inertia_kg_m2 = NUMBER, or one for each axis";
        source.keep(Error::new(ErrorKind::Model, found, help));
    }
    found.flatten()
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

    /// Whether its moments are per unit inertia, rad/s²: the inertia is 1, as it stands where it is not known.
    pub fn is_per_inertia(&self) -> bool {
        self.plant.inertia_kg_m2 == 1.0
    }

    /// The file's text; reads back to the same model.
    ///
    /// # Errors
    /// A value that is not finite, which TOML could write but [`parse`] would refuse.
    pub fn to_toml(&self) -> Result<String, Error> {
        plant::check(&self.plant)?;
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
            interval::check(key, *interval, &self.effects)?;
        }
        let text = toml::to_string(self).map_err(|error| {
            Error::new(ErrorKind::Model, format!("cannot be written as TOML: {error}"), "report this")
        })?;
        Ok(self.with_remarks(&text))
    }

    /// `text` with each effect's remark above its entry, and what an inertia of 1 means.
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
            if self.is_per_inertia() && line.starts_with("inertia_kg_m2") {
                whole.push_str(UNIT_INERTIA);
            }
            whole.push('\n');
        }
        whole
    }
}
