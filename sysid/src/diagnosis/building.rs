//! A judgement as an answer.

use super::answer::{
    Alternative, Answer, EffectAnswer, Evidence, FitAnswer, Location, PlaceboAnswer, Verdict,
};
use super::describe;
use super::diagnose::Diagnosis;
use super::evaluation::{Judged, held_out_gain, traces};
use super::experiment;
use super::gust::Gust;
use super::locate::{band, dependences, time_windows};
use super::over_time::{OverTime, residual_moments};
use super::placebo::placebo;
use super::remainder::Leftover;
use super::verdict::Judgement;
use crate::catalogue::shapes::Shape;
use crate::estimate::digits;
use crate::held_out::{Split, labels};
use crate::identify::fir::ceiling_vaf;
use crate::likelihood::free_run::{judged, judged_channel, simulate, starting_points};
use crate::likelihood::problem::Problem;
use crate::model::effect::{Effect, Locus};
use crate::validate::vaf::variance;
use std::collections::BTreeMap;

/// The answer, with what a report shows beside it.
pub fn account(judgement: &Judgement<'_, '_>, notes: Vec<String>) -> Diagnosis {
    let Judgement { problem, split, baseline, extended, .. } = judgement;
    let ceiling = ceilings(problem, split, judgement.simulated());
    let verdict = judgement.verdict(&ceiling);
    let simulated = judgement.simulated();
    let fit = FitAnswer {
        baseline: baseline.answer(problem, split),
        extended: extended.answer(problem, split).simulated_by(simulated.vaf_by_section(split)),
        held_out: labels(&split.held_out),
        ceiling_vaf_percent: ceiling,
        placebo: judgement.placebo(),
    };
    let location = match verdict {
        Verdict::NoMismatch => None,
        _ => Some(judgement.location()),
    };
    let mut effects = judgement.effects(&fit);
    if let (Verdict::Unlisted, None, Some(location)) = (verdict, &judgement.unlisted, &location) {
        let words = judgement.departure.as_ref().map(|departure| departure.words.clone());
        effects.insert(0, undescribed(location, words, judgement.heavy_tails));
    }
    let next_experiment = judgement
        .findings
        .iter()
        .find_map(|f| f.rival_fits.first().and_then(|rival| experiment::best(problem, &extended.fit, rival)));
    let answer = Answer {
        schema: "pitchid.diagnosis/1",
        verdict,
        summary: String::new(),
        effects,
        location,
        fit,
        next_experiment,
        dull_causes: Vec::new(),
        notes,
    };
    let summary = describe::summary(&answer, &judgement.refused, judgement.corrected);
    let unpacked = problem.unpack(&simulated.fit.effects, &simulated.simulation);
    let mut model = unpacked.to_model_file(&problem.sizes);
    if let Some(gust) = &judgement.gust {
        model.effects.push(gust.entry());
    }
    Diagnosis {
        answer: Answer { summary, ..answer },
        traces: traces(problem, split, baseline, simulated),
        over_time: OverTime {
            of_time: judgement.of_time(),
            runs: residual_moments(problem, &baseline.fit, &extended.fit),
        },
        model,
    }
}

impl Judgement<'_, '_> {
    fn placebo(&self) -> Option<PlaceboAnswer> {
        let (problem, split) = (self.problem, self.split);
        let (before, after) = (&self.baseline.fit, &self.extended.fit);
        let judged = Judged::new(problem, split, placebo(problem, before, after)?);
        Some(PlaceboAnswer {
            parameters: judged.fit.minimum.values.len() - before.minimum.values.len(),
            delta_bic: before.bic(problem) - judged.fit.bic(problem),
            vaf_percent: judged.vaf_by_section(split),
            vaf_gain_points: judged.held_out_vaf(split) - self.baseline.held_out_vaf(split),
            held_out_log_likelihood_gain: held_out_gain(problem, split, before, &judged.fit),
        })
    }

    /// Values of the parameters of the effect called `id` in the extended model.
    fn values_of(&self, id: &str) -> &[f64] {
        let fit = &self.extended.fit;
        let own = fit.range_of(self.problem, id);
        own.and_then(|own| fit.minimum.values.get(own)).unwrap_or_default()
    }

    /// Whether what was found depends on the time.
    fn of_time(&self) -> bool {
        let local = self.unlisted.as_ref().is_some_and(|found| found.term.local_in_time);
        local || self.gust.is_some() || self.findings.iter().any(|f| f.effect.about().variable == "t")
    }

    fn effects(&self, fit: &FitAnswer) -> Vec<EffectAnswer> {
        // The extended model's list has no noise model.
        let noise = self.problem.noise_unknowns();
        let own = |id: &str| {
            let range = self.extended.fit.range_of(self.problem, id);
            let range = range.map(|own| own.start - noise..own.end - noise);
            range.and_then(|own| fit.extended.parameters.get(own)).unwrap_or_default().to_vec()
        };
        let mut effects = Vec::new();
        if let Some(found) = &self.unlisted {
            effects.push(EffectAnswer { parameters: own(found.term.about().id), ..self.described(found) });
        }
        for finding in &self.findings {
            let about = finding.effect.about();
            let alternative = |(effect, probability): &(&'static dyn Effect, f64)| Alternative {
                id: effect.about().id.into(),
                probability: *probability,
            };
            effects.push(EffectAnswer {
                id: about.id.into(),
                locus: about.locus,
                equation: about.equation.into(),
                parameters: own(about.id),
                probability: finding.probability.min(self.surest()),
                alternatives: finding.rivals.iter().map(alternative).collect(),
                evidence: self.evidence(finding.delta_bic, finding.p_value),
            });
        }
        effects.extend(self.gust.as_ref().map(|gust| self.told(gust)));
        effects
    }

    /// Probabilities are those among the candidates if the noise is what it is taken for; where it is not, none is sure.
    fn surest(&self) -> f64 {
        const NOT_SURE: f64 = 0.85;
        if self.heavy_tails || self.departure.is_some() { NOT_SURE } else { 1.0 }
    }

    fn evidence(&self, delta_bic: f64, p_value: f64) -> Evidence {
        Evidence {
            delta_bic,
            p_value,
            vaf_gain_points: self.vaf_gain(),
            held_out_log_likelihood_gain: self.likelihood_gain,
        }
    }

    fn described(&self, found: &Leftover) -> EffectAnswer {
        let term: &Shape = found.term;
        let values = self.values_of(term.about().id);
        EffectAnswer {
            id: "unlisted".into(),
            locus: term.about().locus,
            equation: term.told(values, &self.problem.sizes),
            parameters: Vec::new(),
            probability: 1.0,
            alternatives: Vec::new(),
            evidence: self.evidence(found.delta_bic, found.p_value),
        }
    }

    fn told(&self, gust: &Gust) -> EffectAnswer {
        let about = gust.about();
        EffectAnswer {
            id: about.id.into(),
            locus: about.locus,
            equation: about.equation.into(),
            parameters: gust.parameters.clone(),
            probability: 1.0 - gust.p_value,
            alternatives: Vec::new(),
            evidence: Evidence {
                delta_bic: gust.delta_bic,
                p_value: gust.p_value,
                vaf_gain_points: 0.0,
                held_out_log_likelihood_gain: 0.0,
            },
        }
    }

    fn location(&self) -> Location {
        let (problem, split) = (self.problem, self.split);
        let (before, after) = (&self.baseline.fit, &self.extended.fit);
        let dependence = dependences(problem, before);
        let nyquist = std::f64::consts::PI / problem.sizes.step;
        let strongest = dependence.first().filter(|d| d.share > 0.0).map(|d| d.variable.clone());
        let about = self
            .unlisted
            .as_ref()
            .map(|found| found.term.about())
            .or_else(|| self.findings.first().map(|first| first.effect.about()))
            .or_else(|| self.gust.as_ref().map(Gust::about));
        let (locus, variable, condition) = match about {
            Some(about) => (about.locus, about.variable, about.condition),
            None => (Locus::PitchMoment, "none", "in no particular condition"),
        };
        Location {
            locus,
            time_s: self.when().unwrap_or_else(|| time_windows(problem, before, after)),
            band_rad_s: band(problem, before, after, &split.training).unwrap_or([0.0, nyquist]),
            variable: strongest.unwrap_or_else(|| variable.into()),
            condition: condition.into(),
            dependence,
        }
    }

    /// The windows of a departure, or from the moment on that an effect begins at.
    fn when(&self) -> Option<Vec<[f64; 2]>> {
        let windows = self.departure.as_ref().map(|departure| departure.windows.clone());
        windows.filter(|w| !w.is_empty()).or_else(|| self.since())
    }

    /// From the moment on that an effect begins at to the end of the data, where an effect has such a moment.
    fn since(&self) -> Option<Vec<[f64; 2]>> {
        let begin = self.findings.iter().find_map(|finding| {
            let names = finding.effect.parameters(&self.problem.sizes);
            let i = names.iter().position(|p| p.name == "t_star")?;
            self.values_of(finding.effect.about().id).get(i).copied()
        })?;
        let ends = self.problem.data.runs.iter().map(|run| run.time(run.len().saturating_sub(1)));
        Some(vec![[begin, ends.fold(begin, f64::max)]])
    }
}

impl Gust {
    fn about(&self) -> crate::model::effect::About {
        crate::catalogue::gust_disturbance::GustDisturbance.about()
    }

    fn entry(&self) -> crate::model::file::EffectEntry {
        crate::model::file::EffectEntry {
            id: self.about().id.into(),
            shape: None,
            remark: None,
            parameters: self.parameters.iter().map(|p| (p.name.clone(), p.value)).collect(),
        }
    }
}

/// What is told of a mismatch that nothing explains, with or without a name: on what the residual moment depends, and
/// how large it is there.
fn undescribed(location: &Location, departure: Option<String>, heavy_tails: bool) -> EffectAnswer {
    let strongest = location.dependence.first().filter(|d| d.share > 0.0);
    let equation = match (departure, strongest) {
        (Some(words), _) => words,
        (None, _) if heavy_tails => {
            "errors that come and go: far larger at times than noise is, following no variable".into()
        }
        (None, Some(d)) => {
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
        (None, None) => "a moment that depends on none of u, its rate, q, theta and t alone".into(),
    };
    EffectAnswer::undescribed(location.locus, equation)
}

/// What any model reaches on each section: the better of an FIR model of two seconds' memory fitted to the section
/// itself, and the extended model with such a correction of what it leaves.
pub fn ceilings(problem: &Problem<'_>, split: &Split, extended: &Judged) -> BTreeMap<String, f64> {
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
