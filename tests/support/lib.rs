//! Shared by the tests of this package: a simulated flight handed over as a recording, and its diagnosis.

pub mod chip;

use host_sim::{Background, Plant, Scenario, Setting, cost_of_leaving_out, fly};
use std::path::{Path, PathBuf};
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::model::file::{ModelFile, PlantSection};
use sysid::recording::{ReadOptions, Recording, parse};

/// The model that the user of the reference vehicle has: nominal values, up to 30 % off a drawn plant's.
pub fn nominal_model() -> ModelFile {
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

/// Campaign 4 at 0.015 rad on a plant drawn by `seed`, nothing concealed.
pub fn scenario(seed: u64, background: Background) -> Scenario {
    let nominal = Scenario::campaign(4, 0.015, seed).expect("campaign 4 exists");
    Scenario { plant: Plant::drawn(seed), background, ..nominal }
}

/// `effect` at the size, among a dozen over its usual range, whose omission costs nearest to `points` of held-out VAF,
/// and that cost. (The cost is not monotone in the size: the supervisor trips at other times.)
pub fn at_cost(scenario: &Scenario, effect: &Setting, points: f64) -> (Setting, f64) {
    const SIZES: i32 = 12;
    let [small, large] = effect.entry().parameters[0].range;
    let size = |i: i32| small * (large / small).powf(f64::from(i) / f64::from(SIZES - 1));
    (0..SIZES)
        .map(|i| {
            let resized = effect.resized(size(i));
            let flown = Scenario { effects: vec![resized.clone()], ..scenario.clone() };
            (resized, cost_of_leaving_out(&flown).expect("the scenario flies"))
        })
        .min_by(|a, b| (a.1 - points).abs().total_cmp(&(b.1 - points).abs()))
        .expect("there are sizes")
}

/// Flies `scenario` and reads what it logged, through the text of the recording alone.
pub fn record(scenario: &Scenario) -> Recording {
    let flight = fly(scenario).expect("the scenario flies");
    parse("flight.csv", flight.recording().as_bytes(), &ReadOptions::default()).expect("the recording reads")
}

/// Diagnoses a recording against the nominal model.
pub fn diagnosed(recording: Recording) -> Diagnosis {
    diagnose(&[recording], Some(&nominal_model()), &|_| ()).expect("the recording is diagnosed")
}

/// The CSV files of real rigs, in order of their names; `None` where they are not beside this checkout.
pub fn real_recordings() -> Option<Vec<PathBuf>> {
    let mut files: Vec<_> =
        std::fs::read_dir(beside("real")).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "csv"));
    files.sort();
    Some(files)
}

/// The folder of flights of real vehicles; `None` where it is not beside this checkout.
pub fn real_vehicles() -> Option<PathBuf> {
    Some(beside("vehicles")).filter(|folder| folder.is_dir())
}

fn beside(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(folder)
}
