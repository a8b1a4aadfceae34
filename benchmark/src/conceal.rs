//! Makes a case: recording, the user's model, and the sealed truth.

use crate::{Error, files};
use host_sim::flight::Truth;
use host_sim::proof_case::{Kind, Trial};
use host_sim::{Air, Background};
use serde::Serialize;
use std::collections::BTreeMap;
use sysid::model::file::{ModelFile, PlantSection};

/// A truth as it is written; [`crate::truth`] reads it.
#[derive(Serialize)]
struct Sealed<'a> {
    schema: &'static str,
    case: u64,
    kind: Kind,
    ids: Vec<&'static str>,
    /// Ids of the catalogue that come near to what is outside it.
    near: Vec<&'static str>,
    level: Background,
    size: &'static str,
    cost_points: f64,
    imu_rigid: bool,
    true_vaf_percent: BTreeMap<String, f64>,
    flight: &'a Truth,
}

/// The files of a case before anyone has been asked.
#[derive(Clone, Debug)]
pub struct Case {
    /// What was logged, as CSV.
    pub recording: String,
    /// The user's model.
    pub model: String,
    /// What was concealed, as JSON.
    pub truth: String,
}

/// Draws case `number` of the proof of `seed`, and flies it in `air`. Nothing else leaves this function.
///
/// # Errors
/// A case that could not be flown.
pub fn conceal(seed: u64, air: Air, number: u64) -> Result<Case, Error> {
    let trial = Trial::new(seed, number)?.with_air(air);
    let kind = trial.kind;
    let concealed = trial.fly()?;
    let scenario = &concealed.scenario;
    let entries = || scenario.effects.iter().map(host_sim::Setting::entry);
    let mut model = nominal();
    let imu_rigid = scenario.plant.mount.is_none();
    if imu_rigid {
        (model.plant.mount_k, model.plant.mount_c, model.plant.mount_j) = (None, None, None);
    }
    let sealed = Sealed {
        schema: "pitchid.proof.truth/1",
        case: number,
        kind,
        ids: entries().map(|entry| entry.id).collect(),
        near: entries().flat_map(|entry| entry.near.iter().copied()).collect(),
        level: scenario.background,
        size: concealed.size,
        cost_points: concealed.cost_points,
        imu_rigid,
        true_vaf_percent: concealed.true_vaf_percent.iter().cloned().collect(),
        flight: &concealed.flight.truth,
    };
    Ok(Case {
        recording: concealed.flight.recording(),
        model: model.to_toml()?,
        truth: files::json(&sealed)?,
    })
}

/// The model that a user has before the first flight: numbers from blade-element theory and the data sheet.
#[must_use]
pub fn nominal() -> ModelFile {
    let plant = PlantSection {
        inertia_kg_m2: 0.1705,
        delay_s: Some(0.06),
        dm_dq: Some(-0.27),
        dm_du: Some(23.0),
        mount_k: Some(3.8689),
        mount_c: Some(0.02639),
        mount_j: Some(5e-4),
    };
    ModelFile { plant, effects: Vec::new(), intervals: Default::default() }
}
