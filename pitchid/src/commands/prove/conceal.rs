//! Makes a case: recording, the user's model, and the sealed truth.

use super::folder::{Folder, MODEL, RECORDING};
use crate::commands::demo::nominal;
use crate::failure::Failure;
use crate::output;
use host_sim::Background;
use host_sim::flight::Truth;
use host_sim::trial::{Kind, Trial};
use serde::Serialize;
use std::collections::BTreeMap;

/// A truth as it is written; [`super::truth`] reads it.
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

/// Draws case `number` of the proof of `seed`, flies it and writes its files. Nothing else leaves this function.
pub fn conceal(folder: &Folder, seed: u64, number: u64) -> Result<(), Failure> {
    let trial = Trial::new(seed, number)?;
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
    folder.make(number)?;
    output::write(&folder.of(number, RECORDING), &concealed.flight.recording())?;
    output::write(&folder.of(number, MODEL), &model.to_toml()?)?;
    folder.seal(number, &output::json(&sealed)?)
}
