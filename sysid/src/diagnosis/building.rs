//! A judgement as an answer.

use super::answer::{
    Alternative, Answer, EffectAnswer, Evidence, FitAnswer, HeldOutAnswer, KnownAnswer, Location,
    ModelAnswer, VafAnswer, Verdict, WithError,
};
use super::candidates::candidates;
use super::ceiling::ceilings;
use super::component::{Component, components};
use super::describe;
use super::diagnose::Diagnosis;
use super::estimates::{estimates, reach};
use super::experiment;
use super::gust::Gust;
use super::judgement::Judgement;
use super::left_over::left_over;
use super::locate::{band, dependences, time_windows};
use super::over_time::{OverTime, residual_moments};
use super::parts::Part;
use super::posterior::{Finding, Visited};
use super::rotation::{Scores, scores};
use super::shape_in_words::Formula;
use super::spectra::spectra;
use super::step_response::step_responses;
use super::traces::traces;
use crate::catalogue::find;
use crate::catalogue::gust_disturbance::GustDisturbance;
use crate::catalogue::scaled_shape::UNLISTED;
use crate::catalogue::shapes::SHAPES;
use crate::estimate::Estimate;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::effect::{About, Effect, Locus};
use crate::model::file::EffectEntry;
use std::collections::BTreeMap;

/// Keys of the horizons in the answer, in the order of [`super::levels::HORIZONS_S`].
const HORIZONS: [&str; 3] = ["0.1", "0.3", "1.0"];

/// What is not estimated where the input never changes.
const OF_THE_INPUT: [&str; 2] = ["dM_du", "delay"];

/// The answer, with what a report shows beside it.
pub fn build(judgement: &Judgement<'_, '_>, mut notes: Vec<String>) -> Diagnosis {
    notes.extend(judgement.facts());
    let Judgement { problem, parts, selection, rotation, .. } = judgement;
    let (baseline, extended) = (judgement.baseline(), judgement.extended());
    // Where no term is told the baseline's values stand for the answer, and what is told as left has its share of them.
    let tells_shapes = judgement.shapes.len() > judgement.shapes_left().len();
    let tells_none = judgement.named.is_empty() && !tells_shapes && judgement.gust.is_none();
    let fit = FitAnswer {
        baseline: model_answer(
            problem,
            parts,
            &selection.visited[selection.baseline],
            tells_none.then_some(extended),
        ),
        extended: model_answer(
            problem,
            parts,
            &selection.visited[judgement.place],
            judgement.names_alone.as_ref(),
        ),
        held_out: rotation.parts.iter().map(|part| (part.label.clone(), held_out(part))).collect(),
        predicted: Some(judgement.predicted),
        chosen_in: judgement.chosen_in(),
        ceiling_vaf_percent: ceilings(problem, parts),
    };
    let location = (judgement.verdict != Verdict::NoMismatch).then(|| judgement.location());
    let next_experiment = judgement.named.iter().find_map(|finding| {
        let (_, _, rival) = finding.rivals.first()?;
        experiment::best(problem, extended, &selection.visited[*rival].fit)
    });
    let told = if tells_none { baseline } else { extended };
    let mut model = problem.unpack(&told.effects, &told.minimum.values).to_model_file(problem);
    model.effects.extend(judgement.gust.as_ref().map(Gust::entry));
    let mut answer = Answer {
        schema: "pitchid.diagnosis/1",
        verdict: judgement.verdict,
        summary: String::new(),
        questions: Vec::new(),
        balance: None,
        effects: judgement.effects(&fit),
        in_model: judgement.in_model(&fit),
        remainder: judgement.remainder(&fit),
        location,
        fit,
        next_experiment,
        data_checks: Vec::new(),
        per_unit_inertia: false,
        notes,
    };
    if !problem.data.input_changes() {
        for model in [&mut answer.fit.baseline, &mut answer.fit.extended] {
            model.parameters.retain(|estimate| !OF_THE_INPUT.contains(&estimate.name.as_str()));
        }
    }
    answer.summary = describe::summary(&answer, judgement.grounds.objection());
    let traces = traces(problem, &baseline.effects, rotation);
    Diagnosis {
        answer,
        left_over: left_over(problem, baseline, extended),
        spectra: spectra(problem, extended, &traces),
        steps: step_responses(
            problem,
            &selection.visited[selection.baseline],
            &selection.visited[judgement.place],
        ),
        candidates: candidates(problem, selection, judgement.place),
        traces,
        over_time: OverTime {
            of_time: judgement.of_time(),
            runs: residual_moments(problem, baseline, extended),
        },
        components: judgement.components(),
        model,
    }
}

/// A model's part of the answer; the intervals reach to what `alone`, a fit with fewer terms, says too.
fn model_answer(problem: &Problem<'_>, parts: &[Part], model: &Visited, alone: Option<&Fit>) -> ModelAnswer {
    let (effects, values) = (&model.fit.effects, &model.fit.minimum.values);
    let of_parts: Vec<(String, Scores)> = parts
        .iter()
        .map(|part| (part.label.clone(), scores(problem, effects, values, &part.places)))
        .collect();
    let mut all = estimates(problem, &model.fit, Some(&model.information));
    if let Some(alone) = alone {
        reach(problem, &mut all, &model.fit, alone);
    }
    let background: Vec<usize> = (0..effects.len())
        .filter(|&i| effects[i].is_background())
        .flat_map(|i| model.fit.own_range(problem, i))
        .chain(problem.noise_range())
        .collect();
    let physics = all.into_iter().enumerate().filter(|(i, _)| !background.contains(i));
    ModelAnswer {
        vaf_percent: of_parts.iter().map(|(label, s)| (label.clone(), s.free_run)).collect(),
        horizon_vaf_percent: of_parts.iter().map(|(label, s)| (label.clone(), by_horizon(s))).collect(),
        parameters: physics.map(|(_, estimate)| estimate).collect(),
    }
}

fn by_horizon(scores: &Scores) -> BTreeMap<&'static str, WithError> {
    let judged = HORIZONS.into_iter().zip(&scores.horizons);
    judged.filter_map(|(key, vaf)| Some((key, (*vaf)?.into()))).collect()
}

fn held_out(part: &super::rotation::HeldOut) -> HeldOutAnswer {
    let vaf = |scores: &Scores| VafAnswer { free_run: scores.free_run, horizons: by_horizon(scores) };
    HeldOutAnswer {
        baseline: vaf(&part.baseline),
        extended: vaf(&part.extended),
        past_alone: part.past_alone,
        past_alone_far: part.past_alone_far,
        share_of_motion: part.share_of_motion,
        terms: part.chosen.iter().map(|id| (*id).to_owned()).collect(),
    }
}

impl Judgement<'_, '_> {
    /// What the data say of each term, in the order of the answer.
    fn components(&self) -> Vec<Component> {
        let mut all = components(self.problem, self.extended());
        let findings = || self.named.iter().chain(&self.shapes).chain(&self.small);
        let place = |c: &Component| findings().position(|f| f.effect.about().id == c.about.id);
        all.retain(|component| place(component).is_some());
        all.sort_by_key(place);
        for component in &mut all {
            let mut left = self.small.iter().chain(self.shapes_left());
            component.left = left.any(|f| f.effect.about().id == component.about.id);
        }
        all
    }

    fn chosen_in(&self) -> BTreeMap<String, [usize; 2]> {
        let ids = self.named.iter().chain(&self.small).chain(&self.shapes).map(|f| f.effect.about().id);
        let chosen = |id: &str| self.rotation.gain(id).map_or(0, |gain| gain.chosen);
        ids.map(|id| (id.to_owned(), [chosen(id), self.rotation.parts.len()])).collect()
    }

    /// Estimates of the parameters of the effect called `id`.
    pub(super) fn own(&self, fit: &FitAnswer, id: &str) -> Vec<Estimate> {
        let extended = self.extended();
        let Some(range) = extended.range_of(self.problem, id) else { return Vec::new() };
        // The answer's list has no noise model.
        let background = |i: &usize| extended.effects[*i].is_background();
        let hidden =
            (0..extended.effects.len()).filter(background).map(|i| extended.own_range(self.problem, i));
        let before: usize = hidden.filter(|own| own.start < range.start).map(|own| own.len()).sum();
        let shift = self.problem.noise_unknowns() + before;
        fit.extended.parameters.get(range.start - shift..range.end - shift).unwrap_or_default().to_vec()
    }

    /// The effects that the user's model has, with the values of the answer's model.
    fn in_model(&self, fit: &FitAnswer) -> Vec<KnownAnswer> {
        let mut next = self.problem.known_range().start;
        let mut known = Vec::new();
        for term in &self.problem.baseline.terms {
            let own = next..next + term.values.len();
            next = own.end;
            // A term without a name is as the user has it.
            if find(term.effect.about().id).is_none() {
                continue;
            }
            let again = fit.extended.parameters.get(own).unwrap_or_default().iter();
            let names = term.effect.parameters(&self.problem.sizes);
            known.push(KnownAnswer {
                id: term.effect.about().id.into(),
                given: term.values.clone(),
                parameters: names
                    .iter()
                    .zip(again)
                    .map(|(p, estimate)| Estimate { name: p.name.into(), ..estimate.clone() })
                    .collect(),
            });
        }
        known
    }

    /// Values of the parameters of the effect called `id`.
    fn values_of(&self, id: &str) -> &[f64] {
        let fit = self.extended();
        let own = fit.range_of(self.problem, id);
        own.and_then(|own| fit.minimum.values.get(own)).unwrap_or_default()
    }

    /// Whether what was found depends on the time.
    fn of_time(&self) -> bool {
        let findings = self.named.iter().chain(&self.small).chain(&self.shapes);
        self.gust.is_some() || findings.map(|f| f.effect.about().variable).any(|variable| variable == "t")
    }

    fn effects(&self, fit: &FitAnswer) -> Vec<EffectAnswer> {
        let named = self.named.iter().map(|f| self.effect(f, fit));
        let shapes = self.shapes.iter().map(|f| EffectAnswer {
            id: UNLISTED.into(),
            equation: self.formula(f),
            ..self.effect(f, fit)
        });
        let mut effects: Vec<EffectAnswer> = match self.verdict {
            Verdict::Unlisted => shapes.chain(named).collect(),
            _ => named.collect(),
        };
        effects.extend(self.gust.as_ref().map(Gust::answer));
        effects
    }

    fn effect(&self, finding: &Finding, fit: &FitAnswer) -> EffectAnswer {
        let about = finding.effect.about();
        let gain = self.rotation.gain(about.id).unwrap_or_default();
        // odds of rivals that nothing tells apart are no shares of one whole
        let rivals = finding.rivals.iter().map(|(_, probability, _)| probability).sum::<f64>();
        let whole = (finding.probability + rivals).max(1.0);
        let alternative = |(effect, probability, _): &(&'static dyn Effect, f64, usize)| Alternative {
            id: effect.about().id.into(),
            probability: probability / whole,
        };
        EffectAnswer {
            id: about.id.into(),
            locus: about.locus,
            equation: about.equation.into(),
            parameters: self.own(fit, about.id),
            by_part: self.by_part(about.id),
            probability: finding.probability / whole,
            share: finding.share,
            alternatives: finding.rivals.iter().map(alternative).collect(),
            evidence: Evidence {
                log_evidence: finding.log_evidence,
                p_value: finding.p_value,
                vaf_gain_points: gain.vaf_points.into(),
                held_out_log_likelihood: gain.log_likelihood.into(),
            },
        }
    }

    /// A term without a name in a sentence.
    pub(super) fn formula(&self, finding: &Finding) -> String {
        let Visited { fit, information, .. } = &self.selection.visited[self.place];
        let id = finding.effect.about().id;
        let known = SHAPES.iter().find(|shape| shape.about().id == id).zip(fit.range_of(self.problem, id));
        let Some((shape, own)) = known else { return String::new() };
        let values = &fit.minimum.values;
        let deviation = |g: &[f64]| {
            let mut gradient = vec![0.0; values.len()];
            gradient[own.clone()].copy_from_slice(g);
            information.deviation_along(values, &gradient)
        };
        let input_unit = self.problem.data.input_unit.symbol();
        let sizes = &self.problem.sizes;
        Formula { shape, p: &values[own.clone()], deviation: &deviation, sizes, input_unit }.in_words()
    }

    /// Parameters of the effect called `id` as each part of the data has them, where all of them move.
    fn by_part(&self, id: &str) -> BTreeMap<String, Vec<WithError>> {
        let Visited { fit, information, .. } = &self.selection.visited[self.place];
        let Some(own) = fit.range_of(self.problem, id) else { return BTreeMap::new() };
        let alone = |(i, part): (usize, &Part)| {
            let values = information.alone(i, own.clone(), &fit.minimum.values)?;
            Some((part.label.clone(), values.into_iter().map(WithError::from).collect()))
        };
        self.parts.iter().enumerate().filter_map(alone).collect()
    }

    /// What the tests say of the background: facts about the day.
    fn facts(&self) -> impl Iterator<Item = String> + '_ {
        let facts = self.failed.iter().filter(|test| !test.of_physics);
        facts.map(|test| {
            let words = &test.words;
            format!(
                "the background is not the even one that the noise model takes it for: {words} (p = {:.0e})",
                test.p_value
            )
        })
    }

    fn location(&self) -> Location {
        let problem = self.problem;
        let (before, after) = (self.baseline(), self.extended());
        let dependence = dependences(problem, before);
        let nyquist = std::f64::consts::PI / problem.sizes.step;
        let strongest = dependence.first().filter(|d| d.share > 0.0).map(|d| d.variable.clone());
        let first = match self.verdict {
            Verdict::Unlisted => self.shapes.first().or(self.named.first()),
            _ => self.named.first(),
        };
        let about: Option<About> =
            first.map(|f| f.effect.about()).or_else(|| self.gust.as_ref().map(|_| GustDisturbance.about()));
        let (locus, variable, condition) = match about {
            Some(about) => (about.locus, about.variable, about.condition),
            None => (Locus::PitchMoment, "none", "in no particular condition"),
        };
        let places: Vec<_> = self.parts.iter().flat_map(|part| part.places.clone()).collect();
        Location {
            locus,
            time_s: self.when().unwrap_or_else(|| time_windows(problem, before, after)),
            band_rad_s: band(problem, before, after, &places).unwrap_or([0.0, nyquist]),
            variable: strongest.unwrap_or_else(|| variable.into()),
            condition: condition.into(),
            dependence,
        }
    }

    /// The windows of a test that fails, or from the moment on that an effect begins at.
    fn when(&self) -> Option<Vec<[f64; 2]>> {
        let physics = self.failed.iter().filter(|test| test.of_physics);
        physics.map(|test| test.windows.clone()).find(|windows| !windows.is_empty()).or_else(|| self.since())
    }

    /// From the moment on that an effect begins at to the one it ends at, or the end of the data, where an effect has such a moment.
    fn since(&self) -> Option<Vec<[f64; 2]>> {
        let origin = self.problem.data.origin();
        let [begin, end] = self.named.iter().find_map(|finding| {
            let values = self.values_of(finding.effect.about().id);
            let moment = |i: Option<usize>| values.get(i?).map(|moment| moment + origin);
            Some([
                moment(finding.effect.begins_at())?,
                moment(finding.effect.ends_at()).unwrap_or(f64::INFINITY),
            ])
        })?;
        let ends = self.problem.data.runs.iter().map(|run| run.time(run.len().saturating_sub(1)));
        Some(vec![[begin, ends.fold(begin, f64::max).min(end)]])
    }
}

impl Gust {
    fn entry(&self) -> EffectEntry {
        EffectEntry {
            id: GustDisturbance.about().id.into(),
            shape: None,
            remark: None,
            parameters: self.parameters.iter().map(|p| (p.name.clone(), p.value)).collect(),
        }
    }

    fn answer(&self) -> EffectAnswer {
        let about = GustDisturbance.about();
        EffectAnswer {
            id: about.id.into(),
            locus: about.locus,
            equation: about.equation.into(),
            parameters: self.parameters.clone(),
            by_part: BTreeMap::new(),
            probability: 1.0 / (1.0 + (-self.log_evidence).exp()),
            // A simulation cannot repeat it.
            share: 0.0,
            alternatives: Vec::new(),
            evidence: Evidence {
                log_evidence: self.log_evidence,
                p_value: self.p_value,
                vaf_gain_points: Default::default(),
                held_out_log_likelihood: Default::default(),
            },
        }
    }
}

#[cfg(test)]
mod tests;
