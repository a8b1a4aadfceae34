//! The baseline of a diagnosis: the user's simulation, or the grey-box pitch model with values to start from.

use super::effects::{CATALOGUE, Effect, find};
use super::scaled::{self, UNLISTED};
use crate::dataset::{Amplitudes, Dataset, decorrelation};
use crate::error::{Error, ErrorKind};
use crate::model::file::{EffectEntry, KnownEffect, ModelFile, PlantSection};
use crate::model::grey_box::{Mount, Plant};
use crate::model::pitch::{OWN_STATES, Term};
use crate::recording::InputUnit;
use nalgebra::{Matrix3, Vector3};
use std::path::Path;

/// The simulation in use: what a diagnosis starts from.
#[derive(Clone)]
pub struct Baseline {
    /// The plant. Its inertia is held; all else is estimated again, the mount under a prior.
    pub plant: Plant,
    /// Whether the loop delay is estimated (otherwise the model's value is trusted, and `extra_delay` questions it).
    pub delay_free: bool,
    /// Physics that the simulation already has, with its values.
    pub terms: Vec<Term>,
}

/// Iyy of the vehicle of the reference experiment, kg m² (Riccardi, Panizza, Lovera, ERF 2014).
const REFERENCE_INERTIA: f64 = 0.1705;
/// Loop delay adopted there, s.
const REFERENCE_DELAY: f64 = 0.06;
/// Most states that the effects have which a diagnosis adds: three of the catalogue, and a term without a name.
const STATES_OF_CANDIDATES: usize = 3 * 2 + 3;

impl Baseline {
    /// Without a user's model: a recording whose input is blade pitch in rad is taken for the reference vehicle (known
    /// inertia, soft mount); any other rig has unknown inertia (moments per unit inertia) and a rigid IMU.
    /// The loop delay is estimated.
    pub fn from_data(data: &Dataset) -> Self {
        let plant = if data.input_unit == InputUnit::Rad {
            Plant {
                inertia: REFERENCE_INERTIA,
                dm_dq: -0.27,
                dm_du: 23.0,
                delay: REFERENCE_DELAY,
                mount: Some(Mount { stiffness: 3.8689, damping: 0.02639, inertia: 5e-4 }),
            }
        } else {
            regression(data)
        };
        Self { plant, delay_free: true, terms: Vec::new() }
    }

    /// The user's simulation from a model file; what the file leaves out is started from the data.
    pub fn from_file(path: &Path, data: &Dataset) -> Result<Self, Error> {
        Self::from_model(&read_model(path)?, data)
    }

    /// The same, from a model that has been read.
    pub fn from_model(model: &ModelFile, data: &Dataset) -> Result<Self, Error> {
        let fallback = Self::from_data(data).plant;
        let inertia = model.plant.inertia_kg_m2;
        let scale = inertia / fallback.inertia;
        let mount = match (model.plant.mount_k, model.plant.mount_c, model.plant.mount_j) {
            (Some(stiffness), Some(damping), Some(inertia)) => Some(Mount { stiffness, damping, inertia }),
            _ => None,
        };
        let plant = Plant {
            inertia,
            dm_dq: model.plant.dm_dq.unwrap_or(fallback.dm_dq * scale),
            dm_du: model.plant.dm_du.unwrap_or(fallback.dm_du * scale),
            delay: model.plant.delay_s.unwrap_or(fallback.delay),
            mount,
        };
        let terms = model.effects.iter().map(term).collect::<Result<Vec<_>, Error>>()?;
        let states: usize = terms.iter().map(|term| term.effect.states()).sum();
        if states + STATES_OF_CANDIDATES > OWN_STATES {
            let found = format!("effects with {states} states of their own");
            let most = OWN_STATES - STATES_OF_CANDIDATES;
            return Err(Error::new(ErrorKind::Model, found, "leave out those that matter least")
                .expecting(format!("at most {most} (lags have 1, modes 2, terms with a memory 3)")));
        }
        Ok(Self { plant, delay_free: model.plant.delay_s.is_none(), terms })
    }

    /// As a model file.
    pub fn to_model_file(&self) -> ModelFile {
        model_file(&self.plant, &self.terms)
    }
}

/// A plant with its effects as a model file. Terms without a name have their scales ([`scaled::carried`]).
pub fn model_file(plant: &Plant, terms: &[Term]) -> ModelFile {
    ModelFile {
        plant: PlantSection {
            inertia_kg_m2: plant.inertia,
            delay_s: Some(plant.delay),
            dm_dq: Some(plant.dm_dq),
            dm_du: Some(plant.dm_du),
            mount_k: plant.mount.map(|m| m.stiffness),
            mount_c: plant.mount.map(|m| m.damping),
            mount_j: plant.mount.map(|m| m.inertia),
        },
        effects: terms.iter().map(|term| scaled::entry(term, &parameter_names(term.effect))).collect(),
        intervals: Default::default(),
    }
}

/// Reads a model file against the catalogue of effects.
pub fn read_model(path: &Path) -> Result<ModelFile, Error> {
    let named = CATALOGUE.iter().map(|&effect| KnownEffect {
        id: effect.about().id,
        shape: None,
        parameters: parameter_names(effect),
    });
    let nameless = scaled::all().map(|effect| KnownEffect {
        id: UNLISTED,
        shape: Some(effect.about().id),
        parameters: parameter_names(effect),
    });
    crate::model::file::read(path, &named.chain(nameless).collect::<Vec<_>>())
}

/// An entry of a model file as a term of the model.
fn term(entry: &EffectEntry) -> Result<Term, Error> {
    let effect: Option<&'static dyn Effect> = match &entry.shape {
        Some(shape) if entry.id == UNLISTED => scaled::find(shape).map(|scaled| scaled as _),
        _ => find(&entry.id),
    };
    let effect = effect.ok_or_else(|| unknown_effect(&entry.id))?;
    let names = parameter_names(effect);
    let values: Vec<f64> = names.iter().filter_map(|name| entry.parameters.get(*name).copied()).collect();
    if values.len() == names.len() { Ok(Term { effect, values }) } else { Err(unknown_effect(&entry.id)) }
}

/// Names of an effect's parameters.
fn parameter_names(effect: &dyn Effect) -> Vec<&'static str> {
    let any = Amplitudes { u: 1.0, q: 1.0, theta: 1.0, moment: 1.0, step: 0.02, duration: 100.0 };
    effect.parameters(&any).iter().map(|p| p.name).collect()
}

fn unknown_effect(id: &str) -> Error {
    let known: Vec<&str> = CATALOGUE.iter().map(|e| e.about().id).collect();
    Error::new(
        ErrorKind::Model,
        format!("no effect \"{id}\" with these parameters"),
        "use an id of the catalogue",
    )
    .expecting(format!("one of {}", known.join(", ")))
}

/// ∂M/∂u per unit inertia, roughly, by a regression of the measured motion alone: nothing is known of the plant there, and
/// no missing physics bends it by more than a small factor.
pub fn rough_gain(data: &Dataset) -> f64 {
    regression(data).dm_du
}

/// Values to start from for a rig of unknown inertia: least squares of
/// q[k+m] = a q[k] + b ū[k−d .. k−d+m] + c over the delay d, with m samples over which q decorrelates a little.
fn regression(data: &Dataset) -> Plant {
    let step = data.runs.first().map_or(0.02, |run| run.step);
    let rates: Vec<Vec<f64>> = data.runs.iter().map(crate::dataset::Run::rate_or_slope).collect();
    let stride = decorrelation(&rates).min((0.1 / step).ceil() as usize).max(1);
    let longest = (0.15 / step).ceil() as usize;
    let mut best = (f64::INFINITY, -1.0, 1.0, 0.0);
    for delay in 0..=longest {
        let Some((error, a, b)) = regress_at(data, &rates, stride, delay) else { continue };
        if error < best.0 {
            let a = a.clamp(0.05, 0.999);
            let decay = -a.ln() / (stride as f64 * step);
            best = (error, -decay, b * decay / (1.0 - a), delay as f64 * step);
        }
    }
    let (_, dm_dq, dm_du, delay) = best;
    Plant { inertia: 1.0, dm_dq, dm_du, delay, mount: None }
}

/// Mean square error, a and b of the regression for one delay.
fn regress_at(data: &Dataset, rates: &[Vec<f64>], stride: usize, delay: usize) -> Option<(f64, f64, f64)> {
    let (mut normal, mut right, mut power, mut count) = (Matrix3::zeros(), Vector3::zeros(), 0.0, 0.0);
    for (run, rate) in data.runs.iter().zip(rates) {
        for k in delay..run.len().saturating_sub(stride) {
            let input = run.u[k - delay..k - delay + stride].iter().sum::<f64>() / stride as f64;
            let row = Vector3::new(rate[k], input, 1.0);
            normal += row * row.transpose();
            right += row * rate[k + stride];
            power += rate[k + stride] * rate[k + stride];
            count += 1.0;
        }
    }
    let solution = normal.cholesky()?.solve(&right);
    Some(((power - solution.dot(&right)) / count, solution[0], solution[1]))
}
