//! What is made of a selection: effects that held-out data do not confirm are taken out again, what no effect of the
//! catalogue explains is told apart, and the verdict is given.

use super::answer::Verdict;
use super::consistency::inconsistency;
use super::evaluation::{Judged, held_out_gain};
use super::goodness::{Departure, Goodness, goodness};
use super::gust::{Gust, gust};
use super::remainder::{Leftover, leftover};
use super::selection::{DETECTION, Finding, RETENTION, Selection, odds, without};
use crate::held_out::Split;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::effect::{Effect, Locus};
use std::collections::BTreeMap;

/// Where nothing is found for certain, a mean distance of the sections that were fitted on to their ceilings beyond this, in
/// points of VAF, says that physics is missing all the same. The ceiling is fitted to each section itself and so lies a
/// few points too high under strong disturbance.
const UNEXPLAINED_POINTS: f64 = 12.0;
/// A term without a name that gains more than this share of what all terms gain stands for the physics that is missing;
/// below it, it mends what the named effect's idealised equation leaves.
const LARGE_LEFTOVER: f64 = 0.05;
/// A correction whose free run on the held-out sections is this much worse, in points of VAF, is not made.
const COST_POINTS: f64 = 0.5;

/// A free run that reaches less than this share of the ceiling explains little.
const LITTLE: f64 = 0.2;
/// A gain in BIC below this share of another finding's at the same place is put down to that one's equation.
const MENDING: f64 = 0.05;
/// Effects that are a curve over one variable. A straight line beside a curve is no second one.
const CURVES: [&str; 8] = [
    "coulomb_friction",
    "quadratic_drag",
    "cubic_stiffness",
    "end_stop",
    "servo_saturation",
    "servo_deadband",
    "thrust_curve",
    "gyro_saturation",
];

/// Everything the answer is made from.
pub struct Judgement<'p, 'd> {
    /// The data and the baseline.
    pub problem: &'p Problem<'d>,
    /// Which sections are held out.
    pub split: &'p Split,
    /// Effects of the catalogue, largest contribution first.
    pub findings: Vec<Finding>,
    /// A disturbance that is more than background.
    pub gust: Option<Gust>,
    /// A term without a name that the catalogue's effects do not make needless.
    pub unlisted: Option<Leftover>,
    /// What the extended model leaves that is no noise.
    pub departure: Option<Departure>,
    /// Whether it leaves more large errors than noise has: then no probability is near one.
    pub heavy_tails: bool,
    /// The baseline, its parameters estimated again.
    pub baseline: Judged,
    /// With all terms that were added.
    pub extended: Judged,
    /// 2 log likelihood of the one-step prediction that the terms gain on the held-out sections.
    pub likelihood_gain: f64,
    /// Effects that the training data asked for and the held-out data did not confirm.
    pub refused: Vec<&'static str>,
    /// Whether the free run of the held-out sections is better with the terms: else the simulation keeps the baseline.
    pub corrected: bool,
}

impl<'p, 'd> Judgement<'p, 'd> {
    /// Judges a selection.
    pub fn new(problem: &'p Problem<'d>, split: &'p Split, selection: Selection) -> Self {
        let mut refused = Vec::new();
        let mut selection = confirmed(problem, split, selection, &mut refused);
        leave_gusts(problem, &mut selection);
        let unlisted = unlisted(problem, split, &mut selection);
        let Selection { baseline, extended, mut findings } = selection;
        leave_mending(&mut findings);
        leave_stamping(problem, &extended, &mut findings);
        if unlisted.is_some() {
            let place = |f: &Finding| extended.position(f.effect.about().id);
            findings.retain(|f| place(f).is_some_and(|i| !extended.at_bound(problem, i)));
        }
        let likelihood_gain = held_out_gain(problem, split, &baseline, &extended);
        let goodness = goodness(problem, &extended);
        let departure = goodness
            .as_ref()
            .and_then(Goodness::departure)
            .or_else(|| one_curve(&findings))
            .or_else(|| another_elsewhere(problem, split, &baseline, &extended));
        let gust = gust(problem, &extended);
        let uneven = || gust.as_ref().and(goodness.as_ref()).and_then(Goodness::unevenness);
        let departure = departure.or_else(uneven);
        let gust = gust.filter(|_| departure.is_none());
        let baseline = Judged::new(problem, split, baseline);
        let extended = Judged::new(problem, split, extended);
        let corrected = extended.held_out_vaf(split) >= baseline.held_out_vaf(split) - COST_POINTS;
        Self {
            problem,
            split,
            findings,
            gust,
            unlisted,
            departure,
            heavy_tails: goodness.is_some_and(|g| g.heavy_tails()),
            baseline,
            extended,
            likelihood_gain,
            refused,
            corrected,
        }
    }

    /// `ceiling` is the best VAF that any model reaches, section by section.
    pub fn verdict(&self, ceiling: &BTreeMap<String, f64>) -> Verdict {
        // An unstable vehicle has no free run to speak of: where effects are found, a gap alone does not unmake them.
        let doubtful = self.findings.is_empty() || self.heavy_tails;
        let far = doubtful && self.gap_to(ceiling) > UNEXPLAINED_POINTS;
        if self.unlisted.is_some() || self.departure.is_some() || far || self.explains_little(ceiling) {
            return Verdict::Unlisted;
        }
        if self.findings.is_empty() && self.gust.is_none() {
            return if self.heavy_tails { Verdict::Unlisted } else { Verdict::NoMismatch };
        }
        let ruled_out = self.findings.iter().all(|f| f.rivals.is_empty());
        if ruled_out { Verdict::Named } else { Verdict::Ambiguous }
    }

    /// Whether effects were found and the free run of the sections that were fitted on stays far below the ceilings all the
    /// same, although the model is stable: they explain a prediction, not the motion.
    fn explains_little(&self, ceiling: &BTreeMap<String, f64>) -> bool {
        let training = self.split.training.iter().zip(&self.extended.vaf);
        let (reached, reachable) = training.fold((0.0, 0.0), |(reached, reachable), (place, vaf)| {
            (reached + vaf, reachable + ceiling.get(&place.label).copied().unwrap_or(0.0))
        });
        let unpacked = self.problem.unpack(&self.extended.fit.effects, &self.extended.fit.minimum.values);
        let model = self.problem.model(&unpacked, self.problem.sizes.step);
        !self.findings.is_empty() && reached < LITTLE * reachable && model.is_some_and(|m| m.is_stable())
    }

    /// Points of VAF by which the sections that were fitted on stay below their ceilings, in the mean.
    fn gap_to(&self, ceiling: &BTreeMap<String, f64>) -> f64 {
        let training = self.split.training.iter().zip(&self.extended.vaf);
        let gaps: Vec<f64> = training.filter_map(|(p, vaf)| Some(ceiling.get(&p.label)? - vaf)).collect();
        gaps.iter().sum::<f64>() / gaps.len().max(1) as f64
    }

    /// The model that simulates: with the terms, unless that costs on the held-out sections.
    pub fn simulated(&self) -> &Judged {
        if self.corrected { &self.extended } else { &self.baseline }
    }

    /// Points of VAF that the terms gain on the held-out sections.
    pub fn vaf_gain(&self) -> f64 {
        self.extended.held_out_vaf(self.split) - self.baseline.held_out_vaf(self.split)
    }
}

/// Takes out effects that follow a gust by chance: they are not needed once the noise model has it.
fn leave_gusts(problem: &Problem<'_>, selection: &mut Selection) {
    while !selection.findings.is_empty()
        && let Some(place) = gust(problem, &selection.extended).and_then(|g| g.makes_needless(problem))
        && let Some(less) = without(problem, &selection.extended, place)
    {
        let id = selection.extended.effects[place].about().id;
        selection.findings.retain(|finding| finding.effect.about().id != id);
        selection.extended = if selection.findings.is_empty() { selection.baseline.clone() } else { less };
    }
}

/// Takes out of the list, not of the model, what is small beside a finding at the same place in the loop: it mends that
/// one's idealised equation, and is no physics of its own.
fn leave_mending(findings: &mut Vec<Finding>) {
    let strong: Vec<(Locus, f64)> = findings.iter().map(|f| (f.effect.about().locus, f.delta_bic)).collect();
    let mends = |f: &Finding| {
        strong.iter().any(|(locus, bic)| *locus == f.effect.about().locus && f.delta_bic < MENDING * bic)
    };
    findings.retain(|f| !mends(f));
}

/// Takes out of the list, not of the model, a command that is logged up to a sample late beside clocks that drift: the log
/// holds the latest command, and its stamps wander against those of the motion.
fn leave_stamping(problem: &Problem<'_>, extended: &Fit, findings: &mut Vec<Finding>) {
    let drifts = findings.iter().any(|f| f.effect.about().id == "clock_skew");
    let Some(place) = extended.range_of(problem, "extra_delay").filter(|_| drifts) else { return };
    if (-problem.sizes.step..0.0).contains(&extended.minimum.values[place.start]) {
        findings.retain(|f| f.effect.about().id != "extra_delay");
    }
}

/// Two effects of one variable at one place stand for a single curve that neither of them is.
fn one_curve(findings: &[Finding]) -> Option<Departure> {
    let place = |finding: &Finding| (finding.effect.about().locus, finding.effect.about().variable);
    let curves: Vec<&Finding> = findings.iter().filter(|f| CURVES.contains(&f.effect.about().id)).collect();
    let again = |i: &usize| curves[..*i].iter().any(|other| place(other) == place(curves[*i]));
    let of_one = place(curves[(0..curves.len()).find(again)?]);
    let variable = of_one.1;
    let ids: Vec<&str> = curves.iter().filter(|f| place(f) == of_one).map(|f| f.effect.about().id).collect();
    Some(Departure {
        words: format!("a curve of {variable} that takes {} together to follow", ids.join(" and ")),
        windows: Vec::new(),
    })
}

/// A parameter that is another one elsewhere, as a departure.
fn another_elsewhere(
    problem: &Problem<'_>,
    split: &Split,
    baseline: &Fit,
    extended: &Fit,
) -> Option<Departure> {
    let worst = inconsistency(problem, split, baseline, extended)?;
    Some(Departure { words: worst.words(), windows: Vec::new() })
}

/// Takes the weakest effect out again, one after the other, until the held-out data are predicted better than by the
/// baseline.
fn confirmed(
    problem: &Problem<'_>,
    split: &Split,
    selection: Selection,
    refused: &mut Vec<&'static str>,
) -> Selection {
    let Selection { baseline, mut extended, mut findings } = selection;
    while let Some(weakest) = findings.last() {
        if held_out_gain(problem, split, &baseline, &extended) > 0.0 {
            break;
        }
        let id = weakest.effect.about().id;
        refused.push(id);
        findings.pop();
        match extended.position(id).and_then(|i| without(problem, &extended, i)) {
            Some(less) => extended = less,
            None => findings.clear(),
        }
    }
    if findings.is_empty() {
        extended = baseline.clone();
    }
    Selection { baseline, extended, findings }
}

/// The term without a name that is needed besides or instead of the named effects; the selection is changed to match.
fn unlisted(problem: &Problem<'_>, split: &Split, selection: &mut Selection) -> Option<Leftover> {
    let mut found = leftover(problem, selection)?;
    if let Some((term, fit)) = found.instead.take()
        && fit.bic(problem) < selection.extended.bic(problem) - DETECTION
        && held_out_gain(problem, split, &selection.extended, &fit) > 0.0
    {
        found.delta_bic = selection.baseline.bic(problem) - fit.bic(problem);
        let gain = selection.baseline.criterion() - fit.criterion();
        found.p_value = odds(gain, term.parameters(&problem.sizes).len());
        found.term = term;
        selection.findings.clear();
        selection.extended = fit;
        return Some(found);
    }
    if found.delta_bic < DETECTION || found.share < LARGE_LEFTOVER {
        return None;
    }
    if held_out_gain(problem, split, &selection.extended, &found.with) < 0.0 && !found.term.local_in_time {
        return None;
    }
    // What the term has taken over is not needed beside it.
    let mut with = found.with.clone();
    selection.findings.retain(|finding| {
        let place = with.position(finding.effect.about().id);
        match place.and_then(|i| without(problem, &with, i)) {
            Some(less) if less.bic(problem) - with.bic(problem) < RETENTION => {
                with = less;
                false
            }
            _ => true,
        }
    });
    selection.extended = with;
    Some(found)
}
