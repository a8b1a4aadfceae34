//! Model files against the catalogue: read, made a baseline, written.

use crate::catalogue::CATALOGUE;
use crate::catalogue::find;
use crate::catalogue::legal::legal;
use crate::catalogue::scaled_shape::{self, UNLISTED};
use crate::dataset::{Amplitudes, Dataset};
use crate::error::{Error, ErrorKind};
use crate::model::baseline::{Baseline, is_likely_gain};
use crate::model::effect::Effect;
use crate::model::file::{EffectEntry, KnownEffect, ModelFile, PlantSection};
use crate::model::pitch::{OWN_STATES, Term};
use crate::model::plant::{Mount, Plant};
use std::path::Path;

/// Signals of any size: the names of parameters do not hang on them, nor do their signs.
pub(super) const ANY: Amplitudes = Amplitudes {
    inertia: 1.0,
    u: 1.0,
    q: 1.0,
    theta: 1.0,
    turned: 8.0,
    angles: [0.0; 3],
    moment: 1.0,
    moves: 0.0,
    step: 0.02,
    duration: 100.0,
    rate_limit: None,
};
/// Most states that the effects have which a diagnosis adds: five of the catalogue, and two terms without a name.
const STATES_OF_CANDIDATES: usize = 5 * 2 + 2 * 3;

impl Baseline {
    /// The user's simulation where there is one, and otherwise [`Self::from_data`].
    pub fn new(model: Option<&ModelFile>, data: &Dataset) -> Result<Self, Error> {
        model.map_or_else(|| Ok(Self::from_data(data)), |model| Self::from_model(model, data))
    }

    /// The effects of these ids that it does not have.
    pub fn missing<'a>(&self, ids: impl Iterator<Item = &'a str>) -> Vec<&'static dyn Effect> {
        let has = |id: &str| self.terms.iter().any(|term| term.effect.about().id == id);
        ids.filter(|id| !has(id)).filter_map(find).collect()
    }

    /// The user's simulation from a model file; what the file leaves out is started from the data.
    pub fn from_file(path: &Path, data: &Dataset) -> Result<Self, Error> {
        Self::from_model(&read_model(path, None)?, data)
    }

    /// The same, from a model that has been read.
    pub fn from_model(model: &ModelFile, data: &Dataset) -> Result<Self, Error> {
        let fallback = Self::from_data(data).plant;
        let inertia = model.plant.inertia_kg_m2;
        let given = model.plant.dm_du.filter(|gain| is_likely_gain(data, gain / inertia));
        let mount = match (model.plant.mount_k, model.plant.mount_c, model.plant.mount_j) {
            (Some(stiffness), Some(damping), Some(inertia)) => Some(Mount { stiffness, damping, inertia }),
            _ => None,
        };
        let plant = Plant {
            inertia,
            dm_dq: model.plant.dm_dq.unwrap_or(fallback.dm_dq * inertia),
            dm_du: given.unwrap_or(fallback.dm_du * inertia),
            delay: model.plant.delay_s.unwrap_or(fallback.delay),
            mount,
        };
        let mut terms = model.effects.iter().map(term).collect::<Result<Vec<_>, Error>>()?;
        for term in &mut terms {
            for moment in term.effect.moments() {
                term.values[moment] -= data.origin();
            }
        }
        let has = |id: &str| terms.iter().any(|term| term.effect.about().id == id);
        if has("gyro_lag") && has("angle_lag") {
            let found = "gyro_lag and angle_lag, of which the model has room for one";
            return Err(Error::new(ErrorKind::Model, found, "leave out the one that matters less"));
        }
        let states: usize = terms.iter().map(|term| term.effect.states()).sum();
        if states + STATES_OF_CANDIDATES > OWN_STATES {
            let found = format!("effects with {states} states of their own");
            let most = OWN_STATES - STATES_OF_CANDIDATES;
            return Err(Error::new(ErrorKind::Model, found, "leave out those that matter least")
                .expecting(format!("at most {most} (lags have 1, modes 2, terms with a memory 3)")));
        }
        let delay_free = model.plant.delay_s.is_none();
        Ok(Self { plant, delay_free, input_first: false, terms, held: Vec::new() })
    }
}

/// A plant with its effects as a model file; their moments in time are counted from `origin`, s. Terms without a name have their scales ([`carried`](super::scaled_shape::carried)).
pub fn model_file(plant: &Plant, terms: &[Term], origin: f64) -> ModelFile {
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
        effects: terms
            .iter()
            .map(|term| {
                let mut term = term.clone();
                for moment in term.effect.moments() {
                    term.values[moment] += origin;
                }
                scaled_shape::entry(&term, &parameter_names(term.effect))
            })
            .collect(),
        intervals: Default::default(),
    }
}

/// Reads the model of `axis` ([`crate::model::file::AXES`]) in a model file against the catalogue of effects; without one what a
/// model of one axis has, else pitch.
///
/// # Errors
/// As [`crate::model::file::read`].
pub fn read_model(path: &Path, axis: Option<&str>) -> Result<ModelFile, Error> {
    crate::model::file::read(path, axis, &known())
}

/// The same of the text of a file; `name` stands for it in messages.
///
/// # Errors
/// As [`crate::model::file::parse`].
pub fn parse_model(name: &str, text: &str, axis: Option<&str>) -> Result<ModelFile, Error> {
    crate::model::file::parse(name, text, axis, &known())
}

/// All effects that a file may have.
fn known() -> Vec<KnownEffect> {
    let named = CATALOGUE.iter().map(|&effect| KnownEffect {
        id: effect.about().id,
        shape: None,
        parameters: legal(effect),
    });
    let nameless = scaled_shape::all().map(|effect| KnownEffect {
        id: UNLISTED,
        shape: Some(effect.name_in_file()),
        parameters: legal(effect),
    });
    named.chain(nameless).collect()
}

/// An entry of a model file as a term of the model.
fn term(entry: &EffectEntry) -> Result<Term, Error> {
    let effect: Option<&'static dyn Effect> = match &entry.shape {
        Some(shape) if entry.id == UNLISTED => scaled_shape::find_in_file(shape).map(|scaled| scaled as _),
        _ => find(&entry.id),
    };
    let effect = effect.ok_or_else(|| unknown_effect(&entry.id))?;
    let names = parameter_names(effect);
    let values: Vec<f64> = names.iter().filter_map(|name| entry.parameters.get(*name).copied()).collect();
    if values.len() == names.len() { Ok(Term { effect, values }) } else { Err(unknown_effect(&entry.id)) }
}

/// Names of an effect's parameters.
fn parameter_names(effect: &dyn Effect) -> Vec<&'static str> {
    effect.parameters(&ANY).iter().map(|p| p.name).collect()
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
