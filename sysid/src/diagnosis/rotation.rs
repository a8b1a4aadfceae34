//! Every part of the data is held out once: its figures come from models that were selected and fitted without it.
//!
//! Among the models already visited, each fitted again without the part by one Gauss–Newton step, the most probable on the
//! rest is the one that is judged on the part (Stone, J. R. Stat. Soc. B 36, 1974). A term is as certain as the rotations
//! that choose it (Meinshausen and Bühlmann, J. R. Stat. Soc. B 72, 2010). When something set in is taken from the part in which
//! it did.

use super::levels::{HALVED, HORIZONS_S, LONGEST_HORIZON_S};
use super::parts::Part;
use super::past_alone::vaf_of_the_past_alone;
use super::posterior::{Finding, Selection};
use crate::catalogue::find;
use crate::dataset::Place;
use crate::likelihood::evidence::BLOCK_S;
use crate::likelihood::fit::{Fit, weights};
use crate::likelihood::free_run::vaf_over;
use crate::likelihood::horizon::{Vaf, horizon_vaf};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use crate::model::pitch::Output;
use crate::progress::{Counted, Progress};
use rayon::prelude::*;

/// Models whose log posterior lies further below the answer's are not chosen by any rotation.
const WITHIN: f64 = 25.0;

/// VAF of one model on one part, per cent.
#[derive(Clone, Debug, Default)]
pub struct Scores {
    /// Of the free run.
    pub free_run: f64,
    /// By horizon of [`HORIZONS_S`]; `None` where the part is too short for it.
    pub horizons: Vec<Option<Vaf>>,
}

/// One rotation.
#[derive(Default)]
pub struct HeldOut {
    /// Part that was held out.
    pub label: String,
    /// The baseline, fitted without it.
    pub baseline: Scores,
    /// The model that was selected and fitted without it.
    pub extended: Scores,
    /// VAF at the first of the horizons of a prediction from the outputs' past alone, fitted without it, per cent.
    pub past_alone: f64,
    /// The same at the longest horizon.
    pub past_alone_far: f64,
    /// Its share of the motion of all parts (squares about the mean): what it weighs in a mean over them.
    pub share_of_motion: f64,
    /// Ids of the terms that were chosen without it.
    pub chosen: Vec<&'static str>,
    /// Where it is.
    pub places: Vec<Place>,
    /// Values of the baseline's unknowns without it.
    pub baseline_values: Vec<f64>,
    /// Effects and values of the model that was selected and fitted without it.
    pub model: (Vec<&'static dyn Effect>, Vec<f64>),
}

/// What a term gains on held-out data: the model with it against the model without it.
#[derive(Clone, Copy, Debug, Default)]
pub struct TermGain {
    /// 2 ln likelihood of the one-step prediction, and its standard error over blocks.
    pub log_likelihood: (f64, f64),
    /// By how many standard errors the blocks gain more often, and more, than they lose ([`signed_rank`]): one wild second in a
    /// block, which would drown all others in a mean, counts as one block here.
    pub signed_rank: f64,
    /// Free-run VAF, points, mean over the parts, and its standard error over them.
    pub vaf_points: (f64, f64),
    /// Whether it leaves half of the free run's error in all parts together, or less.
    pub halves: bool,
    /// Rotations that chose it.
    pub chosen: usize,
    /// Rotations that chose it or one of its rivals: that something of the kind is there.
    pub chosen_in_kind: usize,
}

/// All rotations.
pub struct Rotation {
    /// Part by part.
    pub parts: Vec<HeldOut>,
    /// For each finding, by its id.
    gains: Vec<(&'static str, TermGain)>,
}

impl Rotation {
    /// These parts, without findings.
    #[cfg(test)]
    pub fn of(parts: Vec<HeldOut>) -> Self {
        Self { parts, gains: Vec::new() }
    }

    /// Mean of `figure` over the parts that have one, each by its share of the motion: a part in which nothing moves has nothing to
    /// explain, and says little of how well that is done. 0 where none has.
    pub fn mean(&self, figure: impl Fn(&HeldOut) -> Option<f64>) -> f64 {
        mean_by_motion(self.parts.iter().map(|part| (part.share_of_motion, figure(part))))
    }

    /// What the term called `id` gains.
    pub fn gain(&self, id: &str) -> Option<TermGain> {
        self.gains.iter().find(|(known, _)| *known == id).map(|(_, gain)| *gain)
    }
}

/// A model fitted without one part.
struct Turned {
    values: Vec<f64>,
    /// Innovations of all rows, run by run.
    innovations: Vec<Vec<Output>>,
    log_posterior: f64,
}

/// Mean of the values that there are, each by its share of the motion; 0 where there are none.
pub fn mean_by_motion(parts: impl Iterator<Item = (f64, Option<f64>)>) -> f64 {
    let add = |[sum, all]: [f64; 2], (share, value): (f64, f64)| [sum + share * value, all + share];
    let [sum, all] = parts.filter_map(|(share, value)| Some((share, value?))).fold([0.0; 2], add);
    if all > 0.0 { sum / all } else { 0.0 }
}

/// Holds each of `parts` out once; `findings` are the terms of the model `place`.
pub fn rotate(
    problem: &Problem<'_>,
    selection: &Selection,
    place: usize,
    findings: &[Finding],
    parts: &[Part],
    progress: &Progress<'_>,
) -> Rotation {
    let divisor = selection.visited[place].divisor(problem);
    let value = |i: usize| selection.visited[i].log_posterior(problem, divisor);
    let near = |i: &usize| {
        let asked = *i == place || *i == selection.baseline || findings.iter().any(|f| f.without == Some(*i));
        asked || value(*i) > value(place) - WITHIN
    };
    let models: Vec<usize> = (0..selection.visited.len()).filter(near).collect();
    let at = |i: usize| models.iter().position(|&m| m == i);
    let mut rotations: Vec<HeldOut> = Vec::new();
    let mut gains: Vec<Vec<Turn>> = (0..findings.len()).map(|_| Vec::new()).collect();
    let counted = Counted::new(progress, "holding out each section", models.len() * parts.len());
    for (index, part) in parts.iter().enumerate() {
        let turned = |&m: &usize| {
            let turned = turn(problem, selection, m, index, &part.places, divisor);
            counted.one();
            turned
        };
        let turned: Vec<Option<Turned>> = models.par_iter().map(turned).collect();
        let Some(Some(baseline)) = at(selection.baseline).map(|i| turned[i].as_ref()) else { continue };
        let probable = |i: &usize| turned[*i].as_ref().map_or(f64::NEG_INFINITY, |t| t.log_posterior);
        let Some(best) = (0..models.len()).max_by(|a, b| probable(a).total_cmp(&probable(b))) else {
            continue;
        };
        let Some(chosen) = turned[best].as_ref() else { continue };
        let effects = |m: usize| &selection.visited[m].fit.effects[..];
        let scores = |m: usize, t: &Turned| scores(problem, effects(m), &t.values, &part.places);
        let ids = |m: usize| -> Vec<&'static str> {
            effects(m).iter().filter(|e| !e.is_background()).map(|e| e.about().id).collect()
        };
        // Whether a term is chosen is asked beside the shapes that the answer has: one that holds it as a special case says
        // nothing against it.
        let shapes = |m: usize| selection.visited[m].shapes();
        let alike = (0..models.len()).filter(|&i| shapes(models[i]) == shapes(place));
        let best_alike = alike.max_by(|a, b| probable(a).total_cmp(&probable(b)));
        let terms = best_alike.map_or_else(Vec::new, |i| ids(models[i]));
        for (finding, gains) in findings.iter().zip(&mut gains) {
            let pair = at(place).zip(finding.without.and_then(at));
            let Some((Some(with), Some(less))) = pair.map(|(a, b)| (turned[a].as_ref(), turned[b].as_ref()))
            else {
                continue;
            };
            let blocks = gains_by_block(problem, &part.places, &less.innovations, &with.innovations);
            let free = |m: usize, t: &Turned| {
                vaf_over(problem, &problem.unpack(effects(m), &t.values), &part.places)
            };
            let vaf = [free(finding.without.unwrap_or(place), less), free(place, with)];
            let motion = problem.data.motion(&part.places);
            let chosen = terms.contains(&finding.effect.about().id);
            let of_kind = |id: &&'static str| {
                finding.rivals.iter().any(|(rival, ..)| rival.about().id == *id)
                    || find(id).is_some_and(|other| all_but_the_same(other, finding.effect))
            };
            let in_kind = chosen || terms.iter().any(of_kind);
            gains.push(Turn { blocks, vaf, motion, chosen, in_kind });
        }
        let others: Vec<Place> = parts
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != index)
            .flat_map(|(_, part)| part.places.clone())
            .collect();
        let past_alone = |horizon| vaf_of_the_past_alone(problem, &others, &part.places, horizon);
        rotations.push(HeldOut {
            label: part.label.clone(),
            baseline: scores(selection.baseline, baseline),
            extended: scores(models[best], chosen),
            past_alone: past_alone(HORIZONS_S[0]),
            past_alone_far: past_alone(LONGEST_HORIZON_S),
            share_of_motion: problem.data.motion(&part.places),
            chosen: ids(models[best]),
            places: part.places.clone(),
            baseline_values: baseline.values.clone(),
            model: (effects(models[best]).to_vec(), chosen.values.clone()),
        });
    }
    let all: f64 = rotations.iter().map(|part| part.share_of_motion).sum();
    rotations.iter_mut().for_each(|part| part.share_of_motion /= all.max(f64::MIN_POSITIVE));
    let ids = findings.iter().map(|finding| finding.effect.about().id);
    Rotation { parts: rotations, gains: ids.zip(gains.iter().map(|turns| term_gain(turns))).collect() }
}

/// Whether one of the two says all but the same as the other, as a straight spring and gravity do over small angles.
pub fn all_but_the_same(one: &dyn Effect, other: &dyn Effect) -> bool {
    one.restates() == [other.about().id] || other.restates() == [one.about().id]
}

/// What one rotation says of a term.
struct Turn {
    /// Gain in 2 ln likelihood, block by block.
    blocks: Vec<f64>,
    /// VAF of the free run without it and with it, per cent.
    vaf: [f64; 2],
    /// Square of the motion in the part.
    motion: f64,
    /// Whether it chose the term.
    chosen: bool,
    /// Whether it chose the term or one of its rivals.
    in_kind: bool,
}

fn term_gain(turns: &[Turn]) -> TermGain {
    let error = |values: &[f64]| {
        let n = values.len().max(2) as f64;
        let mean = values.iter().sum::<f64>() / n;
        (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0)).sqrt()
    };
    let blocks: Vec<f64> = turns.iter().flat_map(|t| t.blocks.iter().copied()).collect();
    let points: Vec<f64> = turns.iter().map(|t| t.vaf[1] - t.vaf[0]).collect();
    let error_of = |which: usize| turns.iter().map(|t| t.motion * (100.0 - t.vaf[which])).sum::<f64>();
    let errors = [0, 1].map(error_of);
    let n = points.len().max(1) as f64;
    TermGain {
        log_likelihood: (blocks.iter().sum(), error(&blocks) * (blocks.len() as f64).sqrt()),
        signed_rank: signed_rank(&blocks),
        vaf_points: (points.iter().sum::<f64>() / n, error(&points) / n.sqrt()),
        halves: errors[1] <= HALVED * errors[0] && errors[0] > 0.0,
        chosen: turns.iter().filter(|t| t.chosen).count(),
        chosen_in_kind: turns.iter().filter(|t| t.in_kind).count(),
    }
}

/// Σ rank(|g|) sign(g) over its deviation √(n (n + 1) (2n + 1) / 6) where signs are even (Wilcoxon, Biometrics Bulletin 1, 1945);
/// 0 without values.
fn signed_rank(values: &[f64]) -> f64 {
    let mut by_size: Vec<f64> = values.iter().copied().filter(|value| *value != 0.0).collect();
    by_size.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = by_size.len() as f64;
    let sum: f64 = by_size.iter().zip(1..).map(|(value, rank)| f64::from(rank) * value.signum()).sum();
    if n == 0.0 { 0.0 } else { sum / (n * (n + 1.0) * (2.0 * n + 1.0) / 6.0).sqrt() }
}

/// The model `m` fitted without part `index`, which lies at `places`.
fn turn(
    problem: &Problem<'_>,
    selection: &Selection,
    m: usize,
    index: usize,
    places: &[Place],
    divisor: f64,
) -> Option<Turned> {
    let visited = &selection.visited[m];
    let held = |run: usize, k: usize| places.iter().any(|p| p.run == run && p.rows.contains(&k));
    let at = |values: Vec<f64>| -> Option<(f64, Vec<f64>, Vec<Vec<Output>>)> {
        let mut innovations = vec![Vec::new(); problem.data.runs.len()];
        let unpacked = problem.unpack(&visited.fit.effects, &values);
        let pack =
            |run: usize, e: Vec<Output>| innovations[run] = e.iter().map(|e| problem.pack(*e)).collect();
        problem.predict(&unpacked, pack)?;
        let rows = problem.counted_rows().filter(|&(run, k)| !held(run, k));
        let rest: Vec<Output> = rows.map(|(run, k)| innovations[run][k]).collect();
        let deviance = rest.len() as f64 * weights(&rest).1;
        deviance.is_finite().then_some((deviance, values, innovations))
    };
    // A step that does not lower the criterion of the rest has left the quadratic's reach: what the noise model makes of it
    // is far from one, the physics by itself is near one.
    let own = visited.fit.minimum.values.clone();
    let step = |held: &dyn Fn(usize) -> bool| visited.information.without(index, &own, held);
    let (noise, moments) = (problem.noise_range(), moments(problem, &visited.fit));
    let moment = |i: usize| moments.contains(&i);
    let tried = [step(&moment), step(&|i| noise.contains(&i) || moment(i)), own.clone()];
    let tried = tried.into_iter().filter_map(at);
    let (deviance, values, innovations) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let log_posterior = visited.log_posterior_with(problem, deviance, divisor);
    Some(Turned { values, innovations, log_posterior })
}

/// Places of the unknowns that are moments in time. No part but its own tells when something set in, and a step along what is not
/// told leads anywhere: they stay where they are.
fn moments(problem: &Problem<'_>, fit: &Fit) -> Vec<usize> {
    let of_effect = |(i, effect): (usize, &&'static dyn Effect)| {
        let first = fit.own_range(problem, i).start;
        effect.moments().map(move |place| first + place)
    };
    fit.effects.iter().enumerate().flat_map(of_effect).collect()
}

/// 2 ln likelihood that the second innovations gain over the first in the counted rows of `places`, block by block. Their
/// covariance is each one's own there: how strong the disturbance is differs from section to section.
fn gains_by_block(
    problem: &Problem<'_>,
    places: &[Place],
    before: &[Vec<Output>],
    after: &[Vec<Output>],
) -> Vec<f64> {
    // While the predictor settles its errors are the start's, and no model's.
    let of_place = |place: &Place| -> (usize, Vec<usize>) {
        (place.run, place.rows.clone().filter(|&k| problem.counted[place.run][k]).collect())
    };
    let counted: Vec<(usize, Vec<usize>)> = places.iter().map(of_place).collect();
    let all = |of: &[Vec<Output>]| -> Vec<Output> {
        counted.iter().flat_map(|(run, rows)| rows.iter().map(|&k| of[*run][k])).collect()
    };
    let (a, b) = (weights(&all(before)), weights(&all(after)));
    let square = |w: &nalgebra::Matrix2<f64>, e: &Output| {
        w[(0, 0)] * e[0] * e[0] + 2.0 * w[(0, 1)] * e[0] * e[1] + w[(1, 1)] * e[1] * e[1]
    };
    let mut blocks = Vec::new();
    for &(run, ref counted) in &counted {
        let run_of = &problem.data.runs[run];
        let rows = ((BLOCK_S / (run_of.step * run_of.measured_every() as f64)) as usize).max(1);
        let gain = |&k: &usize| a.1 - b.1 + square(&a.0, &before[run][k]) - square(&b.0, &after[run][k]);
        blocks.extend(counted.chunks(rows).map(|block| block.iter().map(gain).sum::<f64>()));
    }
    blocks
}

/// VAF of a model on a part.
pub fn scores(
    problem: &Problem<'_>,
    effects: &[&'static dyn Effect],
    values: &[f64],
    places: &[Place],
) -> Scores {
    let unpacked = problem.unpack(effects, values);
    Scores {
        free_run: vaf_over(problem, &unpacked, places),
        horizons: horizon_vaf(problem, &unpacked, places, &HORIZONS_S)
            .unwrap_or_else(|| vec![Some((0.0, 0.0)); HORIZONS_S.len()]),
    }
}

#[cfg(test)]
mod tests;
