//! What is made of a selection: which model is the answer's, what it leaves, how it does on held-out data, the verdict.

use super::adequacy::{Test, failing, tests};
use super::another_value::{is_another_gain, is_another_size, turns_about};
use super::answer::{Predicted, Verdict};
use super::gust::{Gust, gust};
use super::input_hold::is_of_the_hold;
use super::input_line::input_has_line;
use super::levels::{
    ADEQUACY, BEYOND_DOUBT, CALM, HELD_OUT_ERRORS, LONGEST_HORIZON_S, MATERIAL, MENDS, WORTH_A_NAME,
};
use super::materiality::{closed, is_immaterial, says_the_same, telling_horizon, vaf_ahead};
use super::parts::Part;
use super::posterior::{Finding, Selection, is_in_other_words};
use super::predicted::{ahead, told_without};
use super::rotation::{Rotation, TermGain, rotate};
use super::verdict::Grounds;
use crate::likelihood::evidence::BLOCK_S;
use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::effect::{Effect, Locus};
use crate::progress::Progress;
use std::cell::LazyCell;

/// Everything that the answer is built from.
pub struct Judgement<'p, 'd> {
    /// The data and the baseline.
    pub problem: &'p Problem<'d>,
    /// The parts that were held out in turn.
    pub parts: &'p [Part],
    /// All models.
    pub selection: Selection,
    /// The model of the answer.
    pub place: usize,
    /// Its named terms, largest share first.
    pub named: Vec<Finding>,
    /// Named terms that are told as a remainder: further ones that no majority of the rotations chooses, small ones that not every
    /// rotation chooses, very small ones, those without which the motion is explained as well, facets of another, small ones beside
    /// a larger of their class, a moment at a line of the input, a lag within a row of which the input is not known, what comes once
    /// and is soon over, what turns its sign with the rest left out, and all where the model neither explains the data nor predicts
    /// the motion.
    pub small: Vec<Finding>,
    /// The model with its named terms alone, fitted again, where there are others too.
    pub names_alone: Option<Fit>,
    /// Its terms without a name.
    pub shapes: Vec<Finding>,
    /// A disturbance that is more than background.
    pub gust: Option<Gust>,
    /// Tests that it fails, least p-value first.
    pub failed: Vec<Test>,
    /// Each part held out once.
    pub rotation: Rotation,
    /// How far ahead the motion of parts held out is told.
    pub predicted: Predicted,
    /// What the verdict was made of.
    pub grounds: Grounds,
    /// The verdict.
    pub verdict: Verdict,
}

impl<'p, 'd> Judgement<'p, 'd> {
    /// Judges a selection; `fed_back` where the loop was closed though the data do not say so.
    pub fn new(
        problem: &'p Problem<'d>,
        parts: &'p [Part],
        selection: Selection,
        fed_back: bool,
        progress: &Progress<'_>,
    ) -> Self {
        let gain = |place: usize| selection.gain(problem, place);
        let gained_by_names = gain(selection.named);
        let gained_by_all = gain(selection.fullest).max(gain(selection.extended));
        let sections: Vec<_> = parts.iter().flat_map(|part| part.places.clone()).collect();
        let fit_at = |place: usize| &selection.visited[place].fit;
        let ahead_by = |fit: &Fit, horizon: f64| vaf_ahead(problem, fit, &sections, horizon);
        let baseline = LazyCell::new(|| ahead_by(fit_at(selection.baseline), LONGEST_HORIZON_S));
        let closed_by_fit = |fit: &Fit| closed(*baseline, ahead_by(fit, LONGEST_HORIZON_S));
        let closed_by = |place: usize| match place == selection.baseline {
            true => 0.0,
            false => closed_by_fit(fit_at(place)),
        };
        // what one name adds to others is asked where they tell anything; that is no measure of how much all of them explain
        let horizon = telling_horizon(problem, fit_at(selection.extended), &sections);
        let near = LazyCell::new(|| ahead_by(fit_at(selection.baseline), horizon));
        let closed_near = |place: usize| match place == selection.baseline {
            true => 0.0,
            false => closed(*near, ahead_by(fit_at(place), horizon)),
        };
        let closed = closed_by(selection.named);
        // Names that close little give way to what closes more; names that leave next to nothing do not give way to shapes that
        // hold them as their special case.
        let has_all = |place: usize| {
            let names = selection.visited[selection.named].fit.ids();
            names.iter().all(|id| selection.visited[place].fit.position(id).is_some())
        };
        let mut place = if closed >= MATERIAL && !has_all(selection.extended) {
            selection.named
        } else if gained_by_names < MATERIAL * gained_by_all && closed < MATERIAL {
            selection.fullest
        } else {
            selection.extended
        };
        let mut been = Vec::new();
        let Told { place, named, immaterial, shapes, rotation } = loop {
            been.push(place);
            let told = told(problem, &selection, place, parts, &closed_near, progress);
            match told.unfounded(problem, &selection).or_else(|| told.likelier()) {
                Some(other) if !been.contains(&other) => place = other,
                _ => break told,
            }
        };
        let fit = &selection.visited[place].fit;
        let all = tests(problem, fit, &sections, ADEQUACY);
        let failed: Vec<Test> = failing(&all, ADEQUACY).into_iter().cloned().collect();
        let closes = failed.iter().filter(|test| test.of_physics).map(|test| test.closes);
        let untold = 0.5 * closes.fold(0.0, f64::max);
        let gust = if ahead(&rotation) < CALM { gust(problem, fit) } else { None };
        let chosen = |finding: &Finding| {
            rotation.gain(finding.effect.about().id).map_or(0, |gain| gain.chosen_in_kind)
        };
        let held_out = |finding: &Finding| rotation.gain(finding.effect.about().id).unwrap_or_default();
        let clear = |finding: &Finding| is_clear(finding.effect, &held_out(finding));
        let in_every = |finding: &Finding| chosen(finding) == rotation.parts.len();
        let minor: Vec<bool> = (named.iter().enumerate())
            .map(|(i, finding)| {
                let chosen = [chosen(finding), rotation.parts.len()];
                let (gain, error) = held_out(finding).log_likelihood;
                let clear = [clear(finding), gain > BEYOND_DOUBT * error];
                i > 0 && (is_minor(finding.share, chosen, clear) || immaterial[i])
            })
            .collect();
        // What a name means beside the others is asked where those that are no names are out.
        let (left, kept): (Vec<_>, Vec<_>) = named.iter().cloned().enumerate().partition(|(i, _)| minor[*i]);
        let without_minor = with_names_alone(problem, fit, &kept, left.iter().map(|(_, f)| f));
        let meant = without_minor.as_ref().unwrap_or(fit);
        let values = |finding: &Finding| {
            let id = finding.effect.about().id;
            [meant, fit].into_iter().find_map(|fit| fit.minimum.values.get(fit.range_of(problem, id)?))
        };
        let accounted = |finding: &Finding| {
            values(finding).is_some_and(|p| {
                kept.iter().any(|(_, f)| f.effect.accounts_for(finding.effect, p, &problem.sizes))
            })
        };
        let of_the_input = |finding: &Finding| {
            let f_hz = values(finding).and_then(|p| finding.effect.acts_at_frequency(p));
            f_hz.is_some_and(|f_hz| input_has_line(problem, f_hz))
        };
        let delay = meant.delay(problem);
        let of_the_hold = |finding: &Finding| {
            values(finding).is_some_and(|p| is_of_the_hold(problem, finding.effect, p, delay))
        };
        let barred = |i: usize, finding: &Finding| {
            let before = kept.iter().take_while(|(k, _)| *k < i);
            mends(finding, &before.map(|(_, f)| f.effect).collect::<Vec<_>>())
                || accounted(finding)
                || of_the_input(finding)
                || of_the_hold(finding)
                || values(finding).is_some_and(|p| is_event(finding.effect, p))
        };
        let is_small = |(i, finding): &(usize, Finding)| minor[*i] || barred(*i, finding);
        let (mut small, mut named): (Vec<_>, Vec<_>) = named.into_iter().enumerate().partition(is_small);
        let alone = |named: &[(usize, Finding)], small: &[(usize, Finding)]| {
            with_names_alone(problem, fit, named, small.iter().map(|(_, f)| f).chain(&shapes))
        };
        let same = shapes.is_empty() && named.len() == kept.len();
        let mut names_alone = if same { without_minor.clone() } else { alone(&named, &small) };
        // One without which the names give another gain, which a controller is designed by, is material, however little of the
        // prediction it moves, and so is one without which the first of them has another size.
        let first = named.first().map(|(_, finding)| finding.effect);
        let information = &selection.visited[place].information;
        let gain = |alone: &Fit| is_another_gain(problem, fit, alone);
        let gain_or_size = |alone: &Fit| {
            gain(alone) || first.is_some_and(|e| is_another_size(problem, (fit, information), alone, e))
        };
        let says_another: [&dyn Fn(&Fit) -> bool; 2] = [&gain, &gain_or_size];
        for is_another in says_another {
            if !names_alone.as_ref().is_some_and(is_another) {
                continue;
            }
            let stands =
                |(i, finding): &(usize, Finding)| !barred(*i, finding) && in_every(finding) && clear(finding);
            let promoted = (0..small.len()).filter(|&k| stands(&small[k])).find_map(|k| {
                let (mut rest, mut with) = (small.clone(), named.clone());
                with.push(rest.remove(k));
                let fitted = alone(&with, &rest);
                let kept = fitted.as_ref().is_none_or(|fitted| !is_another(fitted));
                kept.then_some((with, rest, fitted))
            });
            if let Some(promoted) = promoted {
                (named, small, names_alone) = promoted;
            }
        }
        if let Some(of_names) = &names_alone {
            let turned =
                |(_, finding): &mut (usize, Finding)| turns_about(problem, fit, of_names, finding.effect);
            let turned: Vec<(usize, Finding)> = named.extract_if(.., turned).collect();
            if !turned.is_empty() {
                small.extend(turned);
                names_alone = alone(&named, &small);
            }
        }
        let [small, named] =
            [small, named].map(|some| some.into_iter().map(|(_, f)| f).collect::<Vec<Finding>>());
        let named = told_once(&selection, named);
        let predicted = Predicted::new(&rotation);
        let little_seen = predicted == Predicted::Little;
        // of a motion told to its last hundredths what has neither name nor form is significant, and not material
        let slight = named.is_empty() && shapes.is_empty() && ahead(&rotation) >= CALM;
        // the names that are told answer for themselves, without what is told as left
        let (closed, gained_by_names) = match &names_alone {
            Some(alone) => {
                let [before, all] =
                    [selection.baseline, selection.named].map(|place| fit_at(place).criterion());
                let share = (before - alone.criterion()) / (before - all).max(f64::MIN_POSITIVE);
                (closed_by_fit(alone), gained_by_names * share.clamp(0.0, 1.0))
            }
            None => (closed, gained_by_names),
        };
        let grounds = Grounds {
            data_first: false,
            not_excited: false,
            named: named.len() + usize::from(gust.is_some()),
            shapes: shapes.len(),
            rivals: named.iter().any(|finding| !finding.rivals.is_empty()),
            unstable: named.iter().any(|f| 2 * chosen(f) < rotation.parts.len() || !clear(f)),
            closed,
            unseen: little_seen && (fed_back || named.iter().any(|f| is_of_the_input(f.effect))),
            gained_by_names,
            gained_by_all,
            untold,
            slight,
        };
        let verdict = grounds.verdict();
        // A name that neither explains the data nor predicts the motion is no finding.
        let claimed = verdict != Verdict::Unlisted || !little_seen;
        let (named, small, names_alone) =
            if claimed { (named, small, names_alone) } else { (Vec::new(), [named, small].concat(), None) };
        Self {
            problem,
            parts,
            selection,
            place,
            named,
            small,
            names_alone,
            shapes,
            gust,
            failed,
            rotation,
            predicted,
            grounds,
            verdict,
        }
    }

    /// The baseline's fit.
    pub fn baseline(&self) -> &Fit {
        &self.selection.visited[self.selection.baseline].fit
    }

    /// The answer's fit.
    pub fn extended(&self) -> &Fit {
        &self.selection.visited[self.place].fit
    }
}

/// What the model at `place` tells.
struct Told {
    place: usize,
    /// Largest share first.
    named: Vec<Finding>,
    /// Which of these are not material.
    immaterial: Vec<bool>,
    shapes: Vec<Finding>,
    rotation: Rotation,
}

/// The terms of the model at `place`, with the share of the motion that each closes (`closed_by`), each part held out in turn.
fn told(
    problem: &Problem<'_>,
    selection: &Selection,
    place: usize,
    parts: &[Part],
    closed_by: &impl Fn(usize) -> f64,
    progress: &Progress<'_>,
) -> Told {
    let (named, shapes): (Vec<Finding>, Vec<Finding>) =
        selection.findings(problem, place).into_iter().partition(|finding| finding.named);
    // A sensor with little noise has nearly all of the evidence, beside what moves the vehicle more.
    let all_closed = closed_by(place);
    let with_rest = |finding: Finding| {
        let by_rest = finding.without.map(closed_by);
        let share = finding.share.max(by_rest.map_or(0.0, |rest| all_closed - rest));
        let immaterial = by_rest.is_some_and(|rest| is_immaterial(finding.effect, all_closed, rest));
        // A rival that holds the name as its special case and closes no more says the same.
        let (same, rivals): (Vec<_>, Vec<_>) = finding.rivals.into_iter().partition(|(rival, _, at)| {
            rival.generalises(finding.effect) && says_the_same(*rival, closed_by(*at), all_closed)
        });
        let probability =
            finding.probability + same.iter().map(|(_, probability, _)| probability).sum::<f64>();
        (Finding { share, rivals, probability: probability.min(1.0), ..finding }, immaterial)
    };
    let mut named: Vec<(Finding, bool)> = named.into_iter().map(with_rest).collect();
    named.sort_by(|(a, _), (b, _)| b.share.total_cmp(&a.share));
    let (named, immaterial): (Vec<Finding>, Vec<bool>) = named.into_iter().unzip();
    let findings = [&named[..], &shapes].concat();
    let rotation = rotate(problem, selection, place, &findings, parts, progress);
    Told { place, named, immaterial, shapes, rotation }
}

impl Told {
    /// The model without the least shape that held-out data do not show, or that stands beside a baseline which tells the motion to its
    /// last hundredths; or without the least of the further names that no rotation chooses, nor a rival of it, and that all the same gives the input another gain: without any one of the parts it is not seen,
    /// and what it says of the others is chance.
    fn unfounded(&self, problem: &Problem<'_>, selection: &Selection) -> Option<usize> {
        let fit = |place: usize| &selection.visited[place].fit;
        let gain = |finding: &Finding| self.rotation.gain(finding.effect.about().id).unwrap_or_default();
        let slight = told_without(&self.rotation) >= CALM;
        let unfounded = |finding: &&Finding| slight || !is_clear(finding.effect, &gain(finding));
        if let Some(without) = self.shapes.iter().rev().filter(unfounded).find_map(|shape| shape.without) {
            return Some(without);
        }
        let never = |finding: &&Finding| {
            let gain = self.rotation.gain(finding.effect.about().id);
            gain.is_some_and(|gain| gain.chosen_in_kind == 0)
                && finding.without.is_some_and(|rest| is_another_gain(problem, fit(self.place), fit(rest)))
        };
        self.named.iter().skip(1).rev().find(never)?.without
    }

    /// The model of a rival that is likelier than a name which it holds as its special case.
    fn likelier(&self) -> Option<usize> {
        let likelier = |finding: &Finding| {
            let general = |(rival, probability, _): &&(&'static dyn Effect, f64, usize)| {
                rival.generalises(finding.effect) && *probability > finding.probability
            };
            finding.rivals.iter().find(general).map(|(.., place)| *place)
        };
        self.named.iter().find_map(likelier)
    }
}

/// The named terms of `fit` alone, fitted again; `None` without any, or without a `rest`.
fn with_names_alone<'f>(
    problem: &Problem<'_>,
    fit: &Fit,
    named: &[(usize, Finding)],
    rest: impl Iterator<Item = &'f Finding>,
) -> Option<Fit> {
    let rest: Vec<usize> = rest.filter_map(|f| fit.position(f.effect.about().id)).collect();
    if rest.is_empty() || named.is_empty() {
        return None;
    }
    let kept: Vec<usize> = (0..fit.effects.len()).filter(|i| !rest.contains(i)).collect();
    let own = kept.iter().flat_map(|&i| fit.own_range(problem, i));
    let values: Vec<f64> = (0..problem.noise_range().end).chain(own).map(|i| fit.minimum.values[i]).collect();
    let effects: Vec<&'static dyn Effect> = kept.iter().map(|&i| fit.effects[i]).collect();
    refit(problem, &effects, &values)
}

/// The names without the rivals that say the same in other words, as friction that differs each way beside friction and a constant
/// moment that are both named, or these instead of it. Their probabilities are the name's own.
fn told_once(selection: &Selection, named: Vec<Finding>) -> Vec<Finding> {
    let names: Vec<&str> = named.iter().map(|finding| finding.effect.about().id).collect();
    let merged = |finding: Finding| {
        let with_rival = |place: usize| &selection.visited[place].fit;
        let (same, rivals): (Vec<_>, Vec<_>) = finding.rivals.into_iter().partition(|(rival, _, place)| {
            is_in_other_words(*rival, |id| names.contains(&id))
                || is_in_other_words(finding.effect, |id| with_rival(*place).position(id).is_some())
        });
        let probability = same.iter().fold(finding.probability, |all, (_, p, _)| (all + p).min(1.0));
        Finding { rivals, probability, ..finding }
    };
    named.into_iter().map(merged).collect()
}

/// Whether a term gains more on held-out data than chance gives.
fn is_clear(effect: &dyn Effect, held_out: &TermGain) -> bool {
    let (gain, error) = held_out.log_likelihood;
    // What acts between two moments shows in few blocks: their spread says nothing of it. Nor does it say much of a swing that dies
    // out; there the free run tells.
    let by_blocks = gain > HELD_OUT_ERRORS * error || held_out.signed_rank > HELD_OUT_ERRORS;
    effect.ends_at().is_some() || by_blocks || gain > error && held_out.halves
}

/// Whether a name beside a larger one is told as a remainder, `chosen` in so many of so many rotations: one that no majority chooses
/// (stability selection: Meinshausen and Bühlmann, J. R. Stat. Soc. B 72, 2010), a small one that not every rotation chooses and that
/// is not clear beyond doubt, a very small one, and one that is not `clear`.
fn is_minor(share: f64, [chosen, of]: [usize; 2], [clear, beyond_doubt]: [bool; 2]) -> bool {
    let unsteady = share < 1.0 - MATERIAL && chosen < of && !beyond_doubt;
    2 * chosen <= of || unsteady || share < WORTH_A_NAME || !clear
}

/// Whether a name mends the form of one of those `before` it: what the data hardly tell from the first of its class, and what closes
/// little beside it.
fn mends(finding: &Finding, before: &[&'static dyn Effect]) -> bool {
    let class = finding.effect.class();
    class.is_some() && before.iter().any(|e| e.class() == class) && finding.share < MENDS
}

/// Whether a term is known by how the vehicle follows the input: what acts at its own time, and what a sensor adds, is seen without.
fn is_of_the_input(effect: &dyn Effect) -> bool {
    let about = effect.about();
    about.variable != "t" && !matches!(about.locus, Locus::Sensor | Locus::Environment)
}

/// Whether what comes once is over within a block: an event, as a push or the one gust of the day, and nothing that a model lacks.
fn is_event(effect: &dyn Effect, values: &[f64]) -> bool {
    let at = |place: Option<usize>| values.get(place?).copied();
    at(effect.ends_at()).zip(at(effect.begins_at())).is_some_and(|(end, begin)| end - begin < BLOCK_S)
}

#[cfg(test)]
mod tests;
