//! Truths and answers as they are read back, as far as they are compared.

use host_sim::proof_case::Kind;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// What was concealed.
#[derive(Deserialize)]
pub struct Truth {
    pub case: u64,
    pub kind: Kind,
    pub ids: Vec<String>,
    pub near: Vec<String>,
    pub level: String,
    pub size: String,
    pub cost_points: f64,
    pub imu_rigid: bool,
    pub true_vaf_percent: BTreeMap<String, f64>,
    pub flight: TrueFlight,
}

/// The part of it that the simulator wrote.
#[derive(Deserialize)]
pub struct TrueFlight {
    pub effects: Vec<TrueEffect>,
}

/// One effect.
#[derive(Deserialize)]
pub struct TrueEffect {
    pub id: String,
    pub parameters: Vec<TrueParameter>,
    #[serde(default)]
    pub location_time_s: Option<[f64; 2]>,
}

/// One parameter.
#[derive(Deserialize)]
pub struct TrueParameter {
    pub name: String,
    pub value: f64,
}

/// What the diagnosis said, read from its JSON.
#[derive(Deserialize)]
pub struct Said {
    pub verdict: String,
    pub effects: Vec<SaidEffect>,
    pub location: Option<SaidLocation>,
    pub fit: SaidFit,
    /// What is there besides the names, as an object.
    #[serde(default)]
    pub remainder: Value,
}

/// One effect.
#[derive(Deserialize)]
pub struct SaidEffect {
    pub id: String,
    pub parameters: Vec<SaidParameter>,
    pub probability: Option<f64>,
    pub alternatives: Vec<SaidAlternative>,
}

/// One parameter; an end of the interval that is not finite is not there.
#[derive(Deserialize)]
pub struct SaidParameter {
    pub name: String,
    pub value: Option<f64>,
    pub ci95: [Option<f64>; 2],
}

/// A candidate that was not ruled out.
#[derive(Deserialize)]
pub struct SaidAlternative {
    pub id: String,
    pub probability: Option<f64>,
}

/// Where the difference is.
#[derive(Deserialize)]
pub struct SaidLocation {
    pub time_s: Vec<[f64; 2]>,
}

/// How well the models fit.
#[derive(Deserialize)]
pub struct SaidFit {
    pub baseline: SaidModel,
    pub extended: SaidModel,
    /// Labels of the sections that were held out; or by label what both models reach on a section when they are fitted
    /// on the others.
    #[serde(default)]
    pub held_out: Value,
}

impl SaidFit {
    /// VAF (%) before and after, mean over the sections that were held out in turn; none where none were.
    pub fn held_out_in_turn(&self) -> Option<[f64; 2]> {
        let free_run = |model: &Value| model.as_f64().or_else(|| model.get("free_run")?.as_f64());
        let both = |section: &Value| {
            Some([free_run(section.get("baseline")?)?, free_run(section.get("extended")?)?])
        };
        let found: Vec<[f64; 2]> = self.held_out.as_object()?.values().filter_map(both).collect();
        let mean = |model: usize| found.iter().map(|vaf| vaf[model]).sum::<f64>() / found.len() as f64;
        (!found.is_empty()).then(|| [0, 1].map(mean))
    }
}

/// One model.
#[derive(Deserialize)]
pub struct SaidModel {
    pub vaf_percent: BTreeMap<String, f64>,
}

/// What the two methods beside the diagnosis found on the same recording.
#[derive(Serialize, Deserialize)]
pub struct Beside {
    /// Sparse regression.
    pub sparse: Sparse,
    /// VAF (%) by held-out section of the baseline with a black-box correction, and its number of parameters.
    pub black_box_vaf_percent: BTreeMap<String, f64>,
    pub black_box_parameters: usize,
}

/// What sparse regression found.
#[derive(Serialize, Deserialize)]
pub struct Sparse {
    /// The terms that were kept, besides q and u.
    pub terms: Vec<String>,
    /// The ids that each kept term stands for: one, or several that it cannot tell apart.
    pub ids: Vec<Vec<String>>,
    /// VAF (%) of the simulated rate by held-out section.
    pub vaf_percent: BTreeMap<String, f64>,
}
