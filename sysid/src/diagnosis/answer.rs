//! The answer of a diagnosis, as it stands in JSON (`pitchid.diagnosis/1`).

use super::data_checks::DataCheck;
use super::questions::Question;
use crate::catalogue::find;
use crate::estimate::Estimate;
use crate::model::effect::Locus;
use serde::Serialize;
use std::collections::BTreeMap;

/// The six verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The baseline, its parameters estimated again, explains the data down to the noise.
    NoMismatch,
    /// The missing physics is identified, and its rivals are ruled out.
    Named,
    /// Physics is missing, and two or three named candidates remain.
    Ambiguous,
    /// Physics is missing, and nothing in the catalogue explains it.
    Unlisted,
    /// The data cannot tell.
    NotExcited,
    /// Something about the recording has to be put right before physics is asked.
    CheckData,
}

/// The whole answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// Always `pitchid.diagnosis/1`.
    pub schema: &'static str,
    /// The verdict.
    pub verdict: Verdict,
    /// One to three plain sentences with numbers and units.
    pub summary: String,
    /// The questions of a careful person, in their order.
    pub questions: Vec<Question>,
    /// The command that holds the vehicle, where a controller does or nothing else could be asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub balance: Option<BalanceAnswer>,
    /// The terms added to the model, all of them and no others, largest share first.
    pub effects: Vec<EffectAnswer>,
    /// The effects that the user's model has, estimated again.
    pub in_model: Vec<KnownAnswer>,
    /// What is left beside named terms and too small to change the verdict.
    pub remainder: Option<Remainder>,
    /// Where the residual is.
    pub location: Option<Location>,
    /// How well baseline and extended model fit.
    pub fit: FitAnswer,
    /// The experiment that would best tell the remaining candidates apart.
    pub next_experiment: Option<NextExperiment>,
    /// What makes model and measurement differ without missing physics: ruled out, found, or not to be told.
    pub data_checks: Vec<DataCheck>,
    /// Whether the inertia is not known: moments are per unit inertia, in rad/s².
    pub per_unit_inertia: bool,
    /// What was noticed about the recordings.
    pub notes: Vec<String>,
}

impl Answer {
    /// Whether what it names is a disturbance and nothing else: no simulation could repeat that, and no model lacks it.
    #[must_use]
    pub fn disturbance_alone(&self) -> bool {
        self.verdict == Verdict::Named
            && !self.effects.is_empty()
            && self.effects.iter().all(|effect| effect.locus == Locus::Environment)
    }

    /// Whether an effect of the catalogue is among what it tells, be it as left.
    #[must_use]
    pub fn tells_a_name(&self) -> bool {
        self.fit.chosen_in.keys().any(|id| find(id).is_some())
    }

    /// The model whose values are told: the extended one where a term is.
    #[must_use]
    pub fn told(&self) -> &ModelAnswer {
        if self.effects.is_empty() { &self.fit.baseline } else { &self.fit.extended }
    }
}

/// The balance of the means.
#[derive(Clone, Debug, Serialize)]
pub struct BalanceAnswer {
    /// The command that holds the vehicle, and the model's.
    pub words: String,
    /// The command that holds the vehicle, in the unit of the input.
    pub command: Estimate,
    /// Whether they differ, and only the balance shows it: the constant moment is listed without a share.
    pub out_of_trim: bool,
}

/// One effect that was added.
#[derive(Clone, Debug, Serialize)]
pub struct EffectAnswer {
    /// Id of the catalogue, or `unlisted`.
    pub id: String,
    /// Where it sits.
    pub locus: Locus,
    /// The term that was added.
    pub equation: String,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// Its parameters as each part of the data has them by itself, all else held.
    pub by_part: BTreeMap<String, Vec<WithError>>,
    /// Posterior probability that this term is in the model, over all models visited.
    pub probability: f64,
    /// Of what the fullest model gains over the baseline, the part that is lost without this term.
    pub share: f64,
    /// Candidates which the data cannot rule out.
    pub alternatives: Vec<Alternative>,
    /// What speaks for it.
    pub evidence: Evidence,
}

/// An effect that the user's model has.
#[derive(Clone, Debug, Serialize)]
pub struct KnownAnswer {
    /// Id of the catalogue.
    pub id: String,
    /// What the user's model says of its parameters, in their order.
    pub given: Vec<f64>,
    /// Its parameters, estimated again.
    pub parameters: Vec<Estimate>,
}

/// A candidate that the data cannot rule out.
#[derive(Clone, Debug, Serialize)]
pub struct Alternative {
    /// Id of the catalogue.
    pub id: String,
    /// Posterior probability, 0.05 or more.
    pub probability: f64,
}

/// What speaks for a term: it alone, the model with it against the model without it.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Evidence {
    /// Gain of the log posterior, calibrated by blocks.
    pub log_evidence: f64,
    /// Odds of so large a gain in likelihood by chance.
    pub p_value: f64,
    /// Gain of free-run VAF on held-out data, points.
    pub vaf_gain_points: WithError,
    /// Gain of 2 log likelihood of the one-step prediction on held-out data.
    pub held_out_log_likelihood: WithError,
}

/// A figure with its standard error over blocks.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct WithError {
    /// The figure.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl From<(f64, f64)> for WithError {
    fn from((value, standard_error): (f64, f64)) -> Self {
        Self { value, standard_error }
    }
}

/// What is left beside the named terms, or what no name explains.
#[derive(Clone, Debug, Serialize)]
pub struct Remainder {
    /// In one phrase.
    pub words: String,
    /// What it depends on; `none` where the tests do not say.
    pub variable: String,
    /// The terms without a name that were added, with their sizes.
    pub equation: String,
    /// Their coefficients.
    pub parameters: Vec<Estimate>,
    /// Of all that can be closed, the part that the named terms do not close.
    pub share: f64,
    /// Tests that the extended model fails.
    pub tests: Vec<FailedTest>,
}

/// A test of the extended model's innovations that fails.
#[derive(Clone, Debug, Serialize)]
pub struct FailedTest {
    /// Name.
    pub name: &'static str,
    /// p-value before Holm's correction.
    pub p_value: f64,
}

/// Where the residual is concentrated.
#[derive(Clone, Debug, Serialize)]
pub struct Location {
    /// Where in the loop.
    pub locus: Locus,
    /// Time windows [from, to], s; the whole recording if nowhere in particular.
    pub time_s: Vec<[f64; 2]>,
    /// Band that holds the middle 80 % of the difference's power, rad/s.
    pub band_rad_s: [f64; 2],
    /// The signal that the residual moment depends on most.
    pub variable: String,
    /// In words.
    pub condition: String,
    /// Share of the residual moment's variance that each variable explains.
    pub dependence: Vec<Dependence>,
}

/// How the residual moment depends on one variable.
#[derive(Clone, Debug, Serialize)]
pub struct Dependence {
    /// The variable.
    pub variable: String,
    /// Its unit.
    pub unit: String,
    /// Share of the variance it explains, beyond what chance gives; 0..1.
    pub share: f64,
    /// Mean residual moment by class of the variable: (mean of the variable, mean moment in N m, its standard error).
    pub classes: Vec<[f64; 3]>,
}

/// Baseline against extended model.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FitAnswer {
    /// The baseline, estimated again on all data.
    pub baseline: ModelAnswer,
    /// With the terms, on all data.
    pub extended: ModelAnswer,
    /// By section: VAF of models that were selected and fitted without that section.
    pub held_out: BTreeMap<String, HeldOutAnswer>,
    /// How far ahead the terms tell the motion of sections held out; none where none was.
    pub predicted: Option<Predicted>,
    /// For each term, in how many of how many rotations it was chosen.
    pub chosen_in: BTreeMap<String, [usize; 2]>,
    /// By section, what an unstructured linear model reaches that was fitted to the section itself.
    pub ceiling_vaf_percent: BTreeMap<String, f64>,
}

/// How far ahead a model tells the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Predicted {
    /// At least half of it 1 s ahead.
    Far,
    /// At least half of what its past does not tell of the next 0.1 s, as where gusts drive it.
    Near,
    /// Less.
    Little,
}

/// One section, held out.
#[derive(Clone, Debug, Serialize)]
pub struct HeldOutAnswer {
    /// The baseline.
    pub baseline: VafAnswer,
    /// The model that was selected without the section.
    pub extended: VafAnswer,
    /// VAF 0.1 s ahead of a prediction from the outputs' past alone, per cent: what the input adds is beyond that.
    pub past_alone: f64,
    /// The same 1 s ahead.
    pub past_alone_far: f64,
    /// Its share of the motion of all sections (squares about the mean), by which it counts in a mean over them.
    pub share_of_motion: f64,
    /// Its terms.
    pub terms: Vec<String>,
}

/// VAF by horizon, per cent.
#[derive(Clone, Debug, Default, Serialize)]
pub struct VafAnswer {
    /// Of the free run.
    pub free_run: f64,
    /// By horizon in s.
    #[serde(flatten)]
    pub horizons: BTreeMap<&'static str, WithError>,
}

/// One model's fit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ModelAnswer {
    /// Free-run VAF by section, per cent.
    pub vaf_percent: BTreeMap<String, f64>,
    /// VAF of predictions by section and horizon, per cent.
    pub horizon_vaf_percent: BTreeMap<String, BTreeMap<&'static str, WithError>>,
    /// Its parameters, by maximum likelihood.
    pub parameters: Vec<Estimate>,
}

/// The excitation that would best tell candidates apart.
#[derive(Clone, Debug, Serialize)]
pub struct NextExperiment {
    /// Dwell of the PRBS [min, max], s.
    pub switching_s: [f64; 2],
    /// Amplitude, in the unit of the input.
    pub amplitude_rad: f64,
    /// Length after which the likelihood ratio is expected to decide, s.
    pub length_s: f64,
    /// Kind of section.
    pub section: &'static str,
    /// Candidates it separates.
    pub separates: [String; 2],
    /// Why, with the expected likelihood ratio.
    pub why: String,
}
