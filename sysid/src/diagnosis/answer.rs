//! The answer of a diagnosis, as it stands in JSON (`pitchid.diagnosis/1`).

use super::data_checks::DullCause;
use crate::estimate::Estimate;
use crate::model::effect::Locus;
use serde::Serialize;
use std::collections::BTreeMap;

/// The five verdicts.
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
    /// The effects added to the model, largest contribution first.
    pub effects: Vec<EffectAnswer>,
    /// Where the residual is.
    pub location: Option<Location>,
    /// How well baseline and extended model fit.
    pub fit: FitAnswer,
    /// The experiment that would best tell the remaining candidates apart.
    pub next_experiment: Option<NextExperiment>,
    /// What makes model and measurement differ without missing physics: ruled out, found, or not to be told.
    pub dull_causes: Vec<DullCause>,
    /// What was noticed about the recordings.
    pub notes: Vec<String>,
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
    /// Posterior probability among all candidates.
    pub probability: f64,
    /// Candidates which the data cannot rule out.
    pub alternatives: Vec<Alternative>,
    /// What speaks for it.
    pub evidence: Evidence,
}

impl EffectAnswer {
    /// What has no name and no parameters, told in words.
    pub fn undescribed(locus: Locus, words: String) -> Self {
        Self {
            id: "unlisted".into(),
            locus,
            equation: words,
            parameters: Vec::new(),
            probability: 1.0,
            alternatives: Vec::new(),
            evidence: Evidence {
                delta_bic: 0.0,
                p_value: 1.0,
                vaf_gain_points: 0.0,
                held_out_log_likelihood_gain: 0.0,
            },
        }
    }
}

/// A candidate that the data cannot rule out.
#[derive(Clone, Debug, Serialize)]
pub struct Alternative {
    /// Id of the catalogue.
    pub id: String,
    /// Posterior probability, 0.05 or more.
    pub probability: f64,
}

/// What speaks for an effect.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Evidence {
    /// BIC without the effect less BIC with it.
    pub delta_bic: f64,
    /// Odds of so large a gain in likelihood by chance.
    pub p_value: f64,
    /// Gain of free-run VAF on held-out data by all effects together, points.
    pub vaf_gain_points: f64,
    /// Gain of 2 log likelihood of the one-step prediction on held-out data by all effects together.
    pub held_out_log_likelihood_gain: f64,
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
#[derive(Clone, Debug, Serialize)]
pub struct FitAnswer {
    /// The baseline, estimated again.
    pub baseline: ModelAnswer,
    /// With the effects.
    pub extended: ModelAnswer,
    /// Sections that no parameter and no choice was fitted on.
    pub held_out: Vec<String>,
    /// What the best unstructured model reaches on the same section.
    pub ceiling_vaf_percent: BTreeMap<String, f64>,
    /// With a term in the effects' place that nothing calls for; `None` where no effect was added.
    pub placebo: Option<PlaceboAnswer>,
}

/// What a term of the same size as the effects gains that nothing calls for: sines of arbitrary frequencies.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceboAnswer {
    /// Number of its parameters.
    pub parameters: usize,
    /// BIC of the baseline less BIC with it.
    pub delta_bic: f64,
    /// Free-run VAF by section, per cent.
    pub vaf_percent: BTreeMap<String, f64>,
    /// Gain of free-run VAF on held-out data, points.
    pub vaf_gain_points: f64,
    /// Gain of 2 log likelihood of the one-step prediction on held-out data.
    pub held_out_log_likelihood_gain: f64,
}

/// One model's fit.
#[derive(Clone, Debug, Serialize)]
pub struct ModelAnswer {
    /// Free-run VAF by section, per cent.
    pub vaf_percent: BTreeMap<String, f64>,
    /// Its parameters, by maximum likelihood.
    pub parameters: Vec<Estimate>,
    /// The values that fit the free run best (output error on the sections not held out).
    pub simulation_parameters: BTreeMap<String, f64>,
}

impl ModelAnswer {
    /// The same parameters, the free run by another model.
    pub fn simulated_by(self, vaf_percent: BTreeMap<String, f64>) -> Self {
        Self { vaf_percent, ..self }
    }
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
