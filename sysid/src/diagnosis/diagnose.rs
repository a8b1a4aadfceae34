//! The whole diagnosis: recordings and a baseline in, an answer out.

use super::answer::{Alternative, Answer, EffectAnswer, Evidence, FitAnswer, Location, Verdict};
use super::baseline::Baseline;
use super::effects::Locus;
use super::excitation;
use super::experiment;
use super::free_run::{judged, judged_channel, simulate, starting_points};
use super::held_out::Split;
use super::judge::{Judged, Trace, held_out_gain, labels, traces};
use super::locate::{band, dependences, time_windows};
use super::problem::Problem;
use super::rank::{Finding, Selection, select, without};
use super::words::{self, digits};
use crate::dataset::Dataset;
use crate::error::{Error, ErrorKind};
use crate::identify::fir::ceiling_vaf;
use crate::model::file::ModelFile;
use crate::recording::Recording;
use crate::validate::vaf::variance;
use std::collections::BTreeMap;

/// Where no effect is found, a mean distance of the sections that were fitted on to their ceilings beyond this, in points
/// of VAF, says that physics is missing all the same. The ceiling is fitted to each section itself and so lies a few
/// points too high under strong disturbance.
const UNEXPLAINED_POINTS: f64 = 12.0;

/// An answer with what a report shows beside it.
pub struct Diagnosis {
    /// The answer.
    pub answer: Answer,
    /// Measured against simulated, section by section.
    pub traces: Vec<Trace>,
    /// The extended model, its parameters fitted for simulation.
    pub model: ModelFile,
}

/// Diagnoses recordings of one vehicle against `model` (the user's simulation), or against the grey-box pitch model
/// where there is none. `progress` is told what is being done.
///
/// # Errors
/// Recordings that do not go together, or for which not even the baseline has a finite likelihood.
pub fn diagnose(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, Error> {
    let data = Dataset::new(recordings)?;
    let baseline = match model {
        Some(model) => Baseline::from_model(model, &data)?,
        None => Baseline::from_data(&data),
    };
    let split = Split::new(&data);
    let problem = Problem::new(&data, &baseline, &split.held_out);
    let notes = data.notes(recordings);
    if let Some(reason) = excitation::too_little(&problem, &split) {
        return Ok(not_excited(&problem, &split, reason, notes));
    }
    let selection = select(&problem, progress).ok_or_else(|| {
        Error::new(
            ErrorKind::Numerical,
            "the baseline has no finite likelihood on these data",
            "check the units of the columns and the values of the model file",
        )
    })?;
    if let Some(reason) = excitation::too_weak(&problem, &split, &selection.baseline) {
        return Ok(not_excited(&problem, &split, reason, notes));
    }
    progress("judging on held-out data");
    Ok(Judgement::new(&problem, &split, selection).into_diagnosis(notes))
}

/// Everything the answer is made from.
struct Judgement<'p, 'd> {
    problem: &'p Problem<'d>,
    split: &'p Split,
    findings: Vec<Finding>,
    baseline: Judged,
    extended: Judged,
    likelihood_gain: f64,
    /// Effects that the training data asked for and the held-out data did not confirm.
    refused: Vec<&'static str>,
}

impl<'p, 'd> Judgement<'p, 'd> {
    /// Takes the weakest effect out again, one after the other, until the held-out data are predicted better than by
    /// the baseline.
    fn new(problem: &'p Problem<'d>, split: &'p Split, selection: Selection) -> Self {
        let Selection { baseline, mut extended, mut findings } = selection;
        let mut refused = Vec::new();
        let mut gain = 0.0;
        while let Some(weakest) = findings.last() {
            gain = held_out_gain(problem, split, &baseline, &extended);
            if gain > 0.0 {
                break;
            }
            let id = weakest.effect.about().id;
            refused.push(id);
            findings.pop();
            let position = extended.ids().iter().position(|other| *other == id);
            let Some(less) = position.and_then(|i| without(problem, &extended, i)) else {
                findings.clear();
                break;
            };
            extended = less;
        }
        if findings.is_empty() {
            (extended, gain) = (baseline.clone(), 0.0);
        }
        Self {
            problem,
            split,
            findings,
            baseline: Judged::new(problem, split, baseline),
            extended: Judged::new(problem, split, extended),
            likelihood_gain: gain,
            refused,
        }
    }

    /// `ceiling` is the best VAF that any model reaches, section by section.
    fn verdict(&self, ceiling: &BTreeMap<String, f64>) -> Verdict {
        if self.findings.is_empty() {
            let gap = self.gap_to(ceiling);
            return if gap > UNEXPLAINED_POINTS { Verdict::Unlisted } else { Verdict::NoMismatch };
        }
        let ruled_out = self.findings.iter().all(|f| f.rivals.is_empty());
        if ruled_out { Verdict::Named } else { Verdict::Ambiguous }
    }

    /// Points of VAF by which the sections that were fitted on stay below their ceilings, in the mean.
    fn gap_to(&self, ceiling: &BTreeMap<String, f64>) -> f64 {
        let training = self.split.training.iter().zip(&self.extended.vaf);
        let gaps: Vec<f64> = training.filter_map(|(p, vaf)| Some(ceiling.get(&p.label)? - vaf)).collect();
        gaps.iter().sum::<f64>() / gaps.len().max(1) as f64
    }

    fn vaf_gain(&self) -> f64 {
        self.extended.held_out_vaf(self.split) - self.baseline.held_out_vaf(self.split)
    }

    fn into_diagnosis(self, notes: Vec<String>) -> Diagnosis {
        let (problem, split) = (self.problem, self.split);
        let ceiling = ceilings(problem, split, &self.extended);
        let verdict = self.verdict(&ceiling);
        let fit = FitAnswer {
            baseline: self.baseline.answer(problem, split),
            extended: self.extended.answer(problem, split),
            held_out: labels(&split.held_out),
            ceiling_vaf_percent: ceiling,
        };
        let location = match verdict {
            Verdict::NoMismatch => None,
            _ => Some(self.location()),
        };
        let mut effects = self.effects(&fit);
        if let (Verdict::Unlisted, Some(location)) = (verdict, &location) {
            effects.push(unlisted(location));
        }
        let next_experiment = self.findings.iter().find_map(|f| {
            f.rival_fits.first().and_then(|rival| experiment::best(problem, &self.extended.fit, rival))
        });
        let answer = Answer {
            schema: "pitchid.diagnosis/1",
            verdict,
            summary: String::new(),
            effects,
            location,
            fit,
            next_experiment,
            notes,
        };
        let summary = words::summary(&answer, &self.refused);
        Diagnosis {
            answer: Answer { summary, ..answer },
            traces: traces(problem, split, &self.baseline, &self.extended),
            model: problem.unpack(&self.extended.fit.effects, &self.extended.simulation).to_model_file(),
        }
    }

    /// Where the parameters of the effect stand in the extended model's list, which has no noise model.
    fn own_parameters(&self, id: &str) -> core::ops::Range<usize> {
        let fit = &self.extended.fit;
        let Some(position) = fit.ids().iter().position(|other| *other == id) else { return 0..0 };
        let own = fit.own_range(self.problem, position);
        let noise = self.problem.noise_unknowns();
        own.start - noise..own.end - noise
    }

    fn effects(&self, fit: &FitAnswer) -> Vec<EffectAnswer> {
        let vaf_gain_points = self.vaf_gain();
        let mut effects = Vec::new();
        for finding in &self.findings {
            let about = finding.effect.about();
            let own = self.own_parameters(about.id);
            effects.push(EffectAnswer {
                id: about.id.into(),
                locus: about.locus,
                equation: about.equation.into(),
                parameters: fit.extended.parameters.get(own).unwrap_or_default().to_vec(),
                probability: finding.probability,
                alternatives: finding
                    .rivals
                    .iter()
                    .map(|(effect, probability)| Alternative {
                        id: effect.about().id.into(),
                        probability: *probability,
                    })
                    .collect(),
                evidence: Evidence {
                    delta_bic: finding.delta_bic,
                    p_value: finding.p_value,
                    vaf_gain_points,
                    held_out_log_likelihood_gain: self.likelihood_gain,
                },
            });
        }
        effects
    }

    fn location(&self) -> Location {
        let (problem, split) = (self.problem, self.split);
        let (before, after) = (&self.baseline.fit, &self.extended.fit);
        let dependence = dependences(problem, before);
        let nyquist = std::f64::consts::PI / problem.sizes.step;
        let strongest = dependence.first().filter(|d| d.share > 0.0).map(|d| d.variable.clone());
        let about = self.findings.first().map(|first| first.effect.about());
        let (locus, variable, condition) = match about {
            Some(about) => (about.locus, about.variable, about.condition),
            None => (Locus::PitchMoment, "none", "in no particular condition"),
        };
        Location {
            locus,
            time_s: time_windows(problem, before, after),
            band_rad_s: band(problem, before, after, &split.training).unwrap_or([0.0, nyquist]),
            variable: strongest.unwrap_or_else(|| variable.into()),
            condition: condition.into(),
            dependence,
        }
    }
}

/// What is told of a mismatch that no effect of the catalogue explains: on what the residual moment depends, and how
/// large it is there.
fn unlisted(location: &Location) -> EffectAnswer {
    let strongest = location.dependence.first().filter(|d| d.share > 0.0);
    let equation = match strongest {
        Some(d) => {
            let told = |[x, moment, _]: &[f64; 3]| format!("{} N m at {}", digits(*moment), digits(*x));
            let (low, high) = (d.classes.first().map(told), d.classes.last().map(told));
            format!(
                "a moment that follows {} ({:.0} % of its variance), from {} to {} {}",
                d.variable,
                100.0 * d.share,
                low.unwrap_or_default(),
                high.unwrap_or_default(),
                d.unit
            )
        }
        None => "a moment that depends on none of u, its rate, q, theta and t alone".into(),
    };
    EffectAnswer {
        id: "unlisted".into(),
        locus: location.locus,
        equation,
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

/// What any model reaches on each section: the better of an FIR model of two seconds' memory fitted to the section
/// itself, and the extended model with such a correction of what it leaves.
fn ceilings(problem: &Problem<'_>, split: &Split, extended: &Judged) -> BTreeMap<String, f64> {
    const MEMORY_S: f64 = 2.0;
    let all = split.all();
    let unpacked = problem.unpack(&extended.fit.effects, &extended.simulation);
    let simulated =
        starting_points(problem, &unpacked, &all).and_then(|p| simulate(problem, &unpacked, &all, &p));
    let mut table = BTreeMap::new();
    for (i, place) in all.iter().enumerate() {
        let run = &problem.data.runs[place.run];
        let (u, y) = (&run.u[place.rows.clone()], judged(problem, place));
        let taps = ((MEMORY_S / run.step) as usize).min(place.rows.len() / 6).clamp(1, 100);
        let alone = ceiling_vaf(u, y, taps).unwrap_or(0.0);
        let corrected = simulated.as_ref().map_or(0.0, |s| {
            let left: Vec<f64> = y.iter().zip(judged_channel(problem, &s[i])).map(|(y, s)| y - s).collect();
            let explained = ceiling_vaf(u, &left, taps).unwrap_or(0.0);
            100.0 * (1.0 - variance(&left) / variance(y) * (1.0 - explained / 100.0))
        });
        table.insert(place.label.clone(), alone.max(corrected).clamp(0.0, 100.0));
    }
    table
}

fn not_excited(problem: &Problem<'_>, split: &Split, reason: String, notes: Vec<String>) -> Diagnosis {
    let nothing = || super::answer::ModelAnswer {
        vaf_percent: Default::default(),
        parameters: Vec::new(),
        simulation_parameters: Default::default(),
    };
    let fit = FitAnswer {
        baseline: nothing(),
        extended: nothing(),
        held_out: labels(&split.held_out),
        ceiling_vaf_percent: Default::default(),
    };
    Diagnosis {
        answer: Answer {
            schema: "pitchid.diagnosis/1",
            verdict: Verdict::NotExcited,
            summary: reason,
            effects: Vec::new(),
            location: None,
            fit,
            next_experiment: None,
            notes,
        },
        traces: Vec::new(),
        model: problem.baseline.to_model_file(),
    }
}
