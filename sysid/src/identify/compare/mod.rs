//! All methods on the same data, side by side: each learns from the training sections, each chooses what it has to
//! choose there, and all are judged by their free runs over sections that took no part.
//!
//! | method | file |
//! | --- | --- |
//! | LMS taps as they would come from the autopilot, and their realisation | `black_box` |
//! | batch least-squares FIR | `black_box` |
//! | PI-MOESP, PO-MOESP | `black_box` |
//! | grey box by output-error maximum likelihood, white and coloured errors | `grey_box` |
//! | grey box matched to the PI-MOESP model in the H∞ norm | `matching` |

mod black_box;
mod cautions;
mod grey_box;
mod judging;
mod matching;

pub use matching::HinfReport;

use super::butterworth::Butterworth;
use super::cross_validation::Cell;
use super::linear_model::LinearModel;
use super::output_error::delay_profile::DelayProfile;
use super::output_error::identifiability::Identifiability;
use crate::dataset::Dataset;
use crate::error::{Error, ErrorKind};
use crate::estimate::Estimate;
use crate::estimate::per_inertia;
use crate::held_out::{Split, labels};
use crate::identify::lms::OnBoard;
use crate::model::baseline::{ASSUMED, Baseline};
use crate::model::file::ModelFile;
use crate::progress::Progress;
use crate::recording::{InputUnit, Recording};
use crate::validate::coherence::Line;
use crate::validate::cross_correlation::CrossCorrelation;
use crate::validate::whiteness::Whiteness;
use judging::Work;
use serde::Serialize;
use std::collections::BTreeMap;

/// What the methods found, and how each simulates the sections it was fitted on and those it was not.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// One line for each method.
    pub methods: Vec<MethodResult>,
    /// By held-out section, what an unstructured model reaches that was fitted to that very section: taps alone, or taps
    /// on what one of the methods leaves over.
    pub ceiling_vaf_percent: BTreeMap<String, f64>,
    /// The grey box's parameters (output error), with 95 % intervals.
    pub parameters: Vec<Estimate>,
    /// The same with the errors' colour modelled.
    pub parameters_coloured: Vec<Estimate>,
    /// Correlation of the estimates of `parameters`, row by row in their order.
    pub correlation: Vec<Vec<f64>>,
    /// What the data cannot tell; only with a mount.
    pub identifiability: Option<Identifiability>,
    /// The loop delay by profile likelihood.
    pub delay: Option<DelayProfile>,
    /// Order and block size of PI-MOESP: every cell, and the choice in words.
    pub subspace: Option<SubspaceChoice>,
    /// The H∞ match: certificate and intervals.
    pub hinf: Option<HinfReport>,
    /// Response and coherence of the training sections without a model.
    pub response: Vec<Line>,
    /// Sections that were fitted on.
    pub training: Vec<String>,
    /// Sections kept aside: an unused PRBS and the closed loop, as far as there are any.
    pub held_out: Vec<String>,
    /// What speaks against a controller that rests on the grey box's values; empty where nothing does.
    pub cautions: Vec<String>,
    /// What was noticed about the recordings.
    pub notes: Vec<String>,
    /// The grey box as a model file, with its intervals.
    #[serde(skip)]
    pub model: ModelFile,
}

/// One method's line.
#[derive(Clone, Debug, Serialize)]
pub struct MethodResult {
    /// Method.
    pub name: String,
    /// Order, number of taps, or what else was chosen.
    pub detail: String,
    /// Free-run VAF by section, per cent.
    pub vaf_percent: BTreeMap<String, f64>,
    /// What the user should know: converged or not, stable or not.
    pub remark: String,
    /// Residual tests by held-out section.
    pub tests: BTreeMap<String, ResidualTests>,
    /// Free runs over the held-out sections.
    #[serde(skip)]
    pub simulated: BTreeMap<String, Vec<f64>>,
    /// The model, where it is linear.
    #[serde(skip)]
    pub model: Option<LinearModel>,
}

/// What the errors of a free run say.
#[derive(Clone, Debug, Serialize)]
pub struct ResidualTests {
    /// Of the errors with themselves.
    pub whiteness: Whiteness,
    /// Of the errors with the input.
    pub input: CrossCorrelation,
}

/// How PI-MOESP's order and block size were chosen.
#[derive(Clone, Debug, Serialize)]
pub struct SubspaceChoice {
    /// Every order and block size.
    pub cells: Vec<Cell>,
    /// In words.
    pub reason: String,
}

/// What can be set.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The weight of the H∞ match; without one, order 15 at the cutoff that suits the data.
    pub weight: Option<Butterworth>,
    /// Records of the bootstrap that gives the H∞ match its intervals; 0 for none.
    pub replicates: usize,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// What the autopilot's own estimator came to in flight: a line of its own, and the settings of the one that is replayed.
    pub on_board: Option<OnBoard>,
    /// Whether to profile the delay and to say what the data cannot tell.
    pub thorough: bool,
}

impl Default for Settings {
    /// 100 records, everything that can be said.
    fn default() -> Self {
        Self { weight: None, replicates: 100, seed: 1, on_board: None, thorough: true }
    }
}

/// Identifies the pitch dynamics from recordings of one vehicle, starting from `model` where the user has one.
/// `progress` is told what is being done.
///
/// # Errors
/// Recordings that do not go together, or on which the grey box has no finite free run.
pub fn identify(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    progress: &Progress<'_>,
) -> Result<Identification, Error> {
    identify_with(recordings, model, &Settings::default(), progress)
}

/// The same with other settings.
///
/// # Errors
/// As [`identify`], and where the taps of an estimator on board are not of these recordings.
pub fn identify_with(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    settings: &Settings,
    progress: &Progress<'_>,
) -> Result<Identification, Error> {
    let data = Dataset::new(recordings)?;
    let baseline = Baseline::new(model, &data)?;
    let split = Split::for_validation(&data);
    let mut found = identify_on(&data, &split, &baseline, settings, progress)?;
    found.notes.extend(data.notes(recordings));
    if model.is_none() {
        found.notes.push(ASSUMED.into());
    }
    if model.is_none_or(ModelFile::is_per_inertia) {
        let matched = found.hinf.iter_mut().flat_map(|hinf| &mut hinf.parameters);
        for parameter in found.parameters.iter_mut().chain(&mut found.parameters_coloured).chain(matched) {
            parameter.unit = per_inertia(&parameter.unit);
        }
    }
    if found.model.plant.dm_du.is_some() {
        found.cautions.extend(cautions::at_odds(&found.parameters, &found.parameters_coloured));
    }
    Ok(found)
}

/// The same with the sections chosen by the caller.
///
/// # Errors
/// As [`identify`].
pub fn identify_on(
    data: &Dataset,
    split: &Split,
    baseline: &Baseline,
    settings: &Settings,
    progress: &Progress<'_>,
) -> Result<Identification, Error> {
    let work = Work::new(data, split)?;
    if let Some(flown) = &settings.on_board {
        belongs(flown, data, work.step)?;
    }
    progress("fitting the grey box".into());
    let grey = grey_box::fit_all(&work, baseline, settings.thorough)?;
    let mut methods = Vec::new();
    progress("replaying the on-board LMS".into());
    if data.has_rate {
        methods.extend(black_box::lms_and_kung(&work, settings.on_board.as_ref()));
    }
    methods.push(black_box::batch_fir(&work));
    progress("choosing subspace models by cross-validation".into());
    let [pi, po] = black_box::subspace(&work, grey.plant.delay);
    methods.extend([pi.line.clone(), po.line]);
    let mut cautions = grey.cautions;
    cautions.extend(cautions::delay_held(baseline, grey.delay.as_ref()));
    cautions.extend(cautions::one_frequency(data));
    cautions.extend(cautions::lacking(&grey.lines[0], &methods, &labels(&split.held_out)));
    methods.extend(grey.lines);
    let mut hinf = None;
    if data.has_rate {
        progress("matching the grey box in the H∞ norm".into());
        let weight = settings.weight.unwrap_or_else(|| work.weight());
        let (line, report) = matching::matched(&work, &pi, &grey.plant, &weight, settings, progress);
        methods.push(line);
        hinf = report;
    }
    Ok(Identification {
        ceiling_vaf_percent: work.ceilings(&methods),
        methods,
        parameters: grey.parameters,
        parameters_coloured: grey.parameters_coloured,
        correlation: grey.correlation,
        identifiability: grey.identifiability,
        delay: grey.delay,
        subspace: pi.chosen.map(|chosen| SubspaceChoice { cells: chosen.table, reason: chosen.reason }),
        hinf,
        response: work.response(),
        training: labels(&split.training),
        held_out: labels(&split.held_out),
        cautions,
        notes: Vec::new(),
        model: grey.model,
    })
}

/// Whether taps of an estimator on board can be those of the data.
fn belongs(flown: &OnBoard, data: &Dataset, step: f64) -> Result<(), Error> {
    let help = "give the taps that were written with this recording, or leave them out";
    let refuse = |found: String| Err(Error::new(ErrorKind::Options, found, help));
    if data.input_unit != InputUnit::Rad || !data.has_rate {
        return refuse(
            "taps of the on-board estimator are in rad/s per rad: they need u_rad and q_rad_s".into(),
        );
    }
    if (flown.fir.step / step - 1.0).abs() > 0.01 {
        return refuse(format!("the taps are {} s apart, the recording's samples {step} s", flown.fir.step));
    }
    Ok(())
}

/// The estimates with the unit of the input that the recordings have.
fn with_input_unit(mut estimates: Vec<Estimate>, unit: InputUnit) -> Vec<Estimate> {
    for estimate in estimates.iter_mut().filter(|e| e.name == "dM_du") {
        estimate.unit = unit.gain_unit().to_owned();
    }
    estimates
}
