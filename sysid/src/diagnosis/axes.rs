//! The axes of one vehicle, diagnosed together: what they share once, and then each by itself.

use super::data_checks::{Loops, is_of_the_controller, is_the_controller_alone};
use super::diagnose::{Diagnosis, diagnose, diagnose_knowing};
use super::excitation::{too_little, too_weak};
use super::levels::PARTS;
use super::parts::parts;
use super::shared::{Asked, SharedTerm, shared};
use crate::catalogue::{CATALOGUE, find};
use crate::dataset::Dataset;
use crate::error::Error;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, fit_baseline};
use crate::likelihood::problem::Problem;
use crate::model::baseline::{ASSUMED, Baseline};
use crate::model::effect::Effect;
use crate::model::file::{EffectEntry, ModelFile};
use crate::progress::{Progress, Step};
use crate::recording::Recording;
use std::collections::BTreeMap;

/// One axis: its name, its recordings, and the user's model of it.
pub struct AxisRecordings {
    /// Name.
    pub name: String,
    /// Recordings in which the axis stands as the pitch axis does.
    pub recordings: Vec<Recording>,
    /// The user's simulation of it.
    pub model: Option<ModelFile>,
}

/// What the axes share, and the diagnosis of each with that in its model.
pub struct AxesDiagnosis {
    /// What several axes have alike.
    pub shared: Option<SharedTerm>,
    /// Each axis, with what is shared in its model.
    pub axes: Vec<(String, Diagnosis)>,
}

/// Diagnoses all `axes`. `progress` is told what is being done.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_axes(axes: &[AxisRecordings], progress: &Progress<'_>) -> Result<AxesDiagnosis, Error> {
    progress("looking for what the axes share".into());
    let shared = shared_by(axes)?;
    let mut diagnoses = Vec::with_capacity(axes.len());
    for axis in axes {
        let say = |step: Step<'_>| progress(Step { what: &format!("{}: {}", axis.name, step.what), ..step });
        let own = shared.as_ref().filter(|term| term.axes.contains(&axis.name));
        let mut diagnosis = match own {
            Some(term) => {
                let model = with(axis.model.as_ref(), term);
                diagnose_knowing(&axis.recordings, Some(&model), &[term.id], &without_kind(term), &say)?
            }
            None => diagnose(&axis.recordings, axis.model.as_ref(), &say)?,
        };
        if own.is_some() && axis.model.is_none() {
            diagnosis.answer.notes.push(ASSUMED.into());
        }
        diagnosis.answer.tell_of(&axis.name);
        diagnoses.push((axis.name.clone(), diagnosis));
    }
    Ok(AxesDiagnosis { shared, axes: diagnoses })
}

/// What the axes share, where that is more probable than nothing.
///
/// # Errors
/// As [`diagnose`].
pub fn shared_by(axes: &[AxisRecordings]) -> Result<Option<SharedTerm>, Error> {
    let mut known = Vec::with_capacity(axes.len());
    for axis in axes {
        let data = Dataset::new(&axis.recordings)?;
        let baseline = Baseline::new(axis.model.as_ref(), &data)?;
        if let Some((baseline, fit)) = excited(axis, &data, &baseline) {
            known.push((&axis.name, data, baseline, fit));
        }
    }
    let asked: Vec<Asked<'_>> =
        known.iter().map(|(name, data, baseline, fit)| Asked { name, data, baseline, fit }).collect();
    Ok(if asked.len() > 1 { shared(&asked) } else { None })
}

/// The baseline of an axis that its input moves, and its fit; `None` where the data cannot tell what the input does: it changes
/// too little, or a controller turns it with the motion and nothing else does; or where a lag cannot be told from smoothing.
fn excited(axis: &AxisRecordings, data: &Dataset, baseline: &Baseline) -> Option<(Baseline, Fit)> {
    let free = Problem::new(data, baseline, &[]);
    if !data.input_changes() || data.is_smoothed() || too_little(&free).is_some() {
        return None;
    }
    let fit = fit_baseline(&free)?;
    let input_first = is_of_the_controller(&axis.recordings, &free, &fit);
    let baseline = Baseline { input_first, ..baseline.clone() };
    let problem = Problem::new(data, &baseline, &[]);
    let fit = if input_first { fit_baseline(&problem)? } else { fit };
    if is_the_controller_alone(&problem, &fit, &Loops::new(&axis.recordings, &problem, &fit)) {
        return None;
    }
    let places: Vec<_> = parts(data, PARTS).into_iter().map(|part| part.places).collect();
    let information = Information::new(&problem, &fit, &places)?;
    too_weak(&problem, &fit, &information).is_none().then_some((baseline, fit))
}

/// The catalogue without what would stand for the same as a shared term: which of them it is, all axes together have said.
fn without_kind(term: &SharedTerm) -> Vec<&'static dyn Effect> {
    let kind = find(term.id).and_then(Effect::class);
    CATALOGUE.iter().copied().filter(|effect| kind.is_none() || effect.class() != kind).collect()
}

/// The model with what is shared in it.
fn with(model: Option<&ModelFile>, term: &SharedTerm) -> ModelFile {
    let mut model = model.cloned().unwrap_or_else(ModelFile::unknown);
    let parameters = BTreeMap::from([(term.parameter.name.clone(), term.parameter.value)]);
    match model.effects.iter_mut().find(|entry| entry.id == term.id) {
        Some(entry) => entry.parameters = parameters,
        None => model.effects.push(EffectEntry { id: term.id.into(), shape: None, parameters, remark: None }),
    }
    model
}

#[cfg(test)]
mod tests;
