//! What the axes of one vehicle share: an effect of the actuators, of the sensors or of the clocks is one effect of one size.
//!
//! On axis a the data say ẑ_a ± s_a of the effect's parameter (in the coordinate of the search), and gain g_a in log likelihood
//! over the model without it, calibrated by blocks. That the axes of a set S have it alike, and the others none, has the
//! evidence
//!
//! ```text
//! ln E(S) = Σ_{a ∈ S} (g_a − (ẑ_a − z̄)²/2 s_a²) + ½ ln(2π s̄²) − ln(range),    1/s̄² = Σ 1/s_a²,   z̄ = s̄² Σ ẑ_a/s_a²
//! ```
//!
//! and on an axis whose data do not want it at any size, g_a is what is lost with it at z̄. Actuators may serve any set of
//! axes (rotors that tilt the craft do not turn it: yaw comes from their reaction); a gyro's filter and a clock serve all.

use super::levels::{PLAUSIBLE, WIDEST_SHARED_INTERVAL};
use super::search::fit_one_more;
use crate::catalogue::gyro_lag::GyroLag;
use crate::catalogue::servo_lag::ServoLag;
use crate::dataset::Dataset;
use crate::estimate::Estimate;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::{Fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::baseline::Baseline;
use crate::model::effect::{Effect, Locus};
use crate::model::pitch::Term;
use crate::optim::levenberg_marquardt::Coordinate;
use serde::Serialize;

/// Effects that axes may share, each with one parameter.
const CANDIDATES: [&dyn Effect; 2] = [&ServoLag, &GyroLag];
/// Prior probability that the axes share none of them.
const NONE: f64 = 0.5;

/// An effect that several axes have alike.
#[derive(Clone, Debug, Serialize)]
pub struct SharedTerm {
    /// Id of the catalogue.
    pub id: &'static str,
    /// What it is.
    pub sentence: &'static str,
    /// The axes that have it.
    pub axes: Vec<String>,
    /// The axes that do not.
    pub not_on: Vec<String>,
    /// Its parameter, of all these axes together.
    pub parameter: Estimate,
    /// The same of each axis alone that has it.
    pub by_axis: Vec<Estimate>,
    /// Posterior probability of this effect on these axes, among all effects and sets that were asked.
    pub probability: f64,
    /// Other effects and sets of at least one in twenty: id, axes, probability.
    pub rivals: Vec<(&'static str, Vec<String>, f64)>,
}

/// An axis: its name, data and model.
pub struct Asked<'a> {
    /// Name.
    pub name: &'a str,
    /// Its data.
    pub data: &'a Dataset,
    /// The model without what is asked for.
    pub baseline: &'a Baseline,
    /// Its fit.
    pub fit: &'a Fit,
}

/// What one axis says of an effect.
struct Said {
    z: f64,
    deviation: f64,
    gain: f64,
    divisor: f64,
}

/// One axis with what its likelihood is made of.
struct Posed<'a> {
    problem: Problem<'a>,
    asked: &'a Asked<'a>,
}

impl Posed<'_> {
    /// The effect as this axis wants it; `None` where it wants none.
    fn wants(&self, effect: &'static dyn Effect) -> Option<Said> {
        let fits = fit_one_more(&self.problem, self.asked.fit, &[effect]);
        let fit = fits.first()?;
        let information = Information::new(&self.problem, fit, &[])?;
        let own = fit.own_range(&self.problem, 0);
        let divisor = information.divisor(own.clone());
        let coordinate = &self.problem.coordinates(&fit.effects)[own.start];
        let value = fit.minimum.values[own.start];
        let deviation = information.deviations(&fit.minimum.values)[own.start] / coordinate.stretch(value);
        let gain = 0.5 * (self.asked.fit.criterion() - fit.criterion()) / divisor;
        deviation.is_finite().then(|| Said { z: coordinate.inner(value), deviation, gain, divisor })
    }

    /// Log likelihood gained with the effect at `value`; mostly lost.
    fn gain_at(&self, effect: &'static dyn Effect, value: f64) -> Option<f64> {
        let mut baseline = self.asked.baseline.clone();
        baseline.terms.push(Term { effect, values: vec![value] });
        baseline.held.push(effect.about().id);
        let held = Problem::new(self.asked.data, &baseline, &[]);
        let mut start = self.asked.fit.minimum.values.clone();
        start.insert(held.known_range().end - 1, value);
        let fit = refit(&held, &[], &start)?;
        Some(0.5 * (self.asked.fit.criterion() - fit.criterion()))
    }
}

/// An effect on a set of axes.
struct Hypothesis {
    effect: usize,
    axes: Vec<usize>,
    z: f64,
    deviation: f64,
    log_evidence: f64,
}

/// The effect that most probably is shared, where sharing one is more probable than sharing none.
pub fn shared(axes: &[Asked<'_>]) -> Option<SharedTerm> {
    let posed: Vec<Posed<'_>> = axes
        .iter()
        .map(|asked| Posed { problem: Problem::new(asked.data, asked.baseline, &[]), asked })
        .collect();
    let sizes = posed.first()?.problem.sizes;
    let coordinates: Vec<Coordinate> = CANDIDATES
        .iter()
        .map(|effect| crate::likelihood::problem::coordinate_of(&effect.parameters(&sizes)[0]))
        .collect();
    let said: Vec<Vec<Option<Said>>> =
        CANDIDATES.iter().map(|&effect| posed.iter().map(|axis| axis.wants(effect)).collect()).collect();
    let mut all = Vec::new();
    for (effect, &candidate) in CANDIDATES.iter().enumerate() {
        for set in sets(axes.len(), candidate.about().locus == Locus::Actuator) {
            all.extend(hypothesis(effect, candidate, &coordinates[effect], &posed, &said[effect], set));
        }
    }
    let prior = ((1.0 - NONE) / all.len().max(1) as f64 / NONE).ln();
    let best = all.iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))?;
    let largest = (best.log_evidence + prior).max(0.0);
    let weight = |log: f64| (log - largest).exp();
    let total = weight(0.0) + all.iter().map(|h| weight(h.log_evidence + prior)).sum::<f64>();
    let probability = |h: &Hypothesis| weight(h.log_evidence + prior) / total;
    if probability(best) <= weight(0.0) / total || best.axes.len() < 2 {
        return None;
    }
    let names = |set: &[usize]| -> Vec<String> { set.iter().map(|&a| axes[a].name.to_owned()).collect() };
    let coordinate = &coordinates[best.effect];
    let estimate = |z: f64, deviation: f64| {
        let value = coordinate.outer(z);
        let deviation = deviation * coordinate.stretch(value);
        Estimate::new(&coordinate.name, &coordinate.unit, value, deviation, coordinate.bounds)
    };
    let parameter = estimate(best.z, best.deviation);
    if 0.5 * (parameter.ci95[1] - parameter.ci95[0]) > WIDEST_SHARED_INTERVAL * parameter.value {
        return None;
    }
    let candidate = CANDIDATES[best.effect];
    let alone = best
        .axes
        .iter()
        .filter_map(|&a| said[best.effect][a].as_ref())
        .map(|said| estimate(said.z, said.deviation));
    let others = (0..axes.len()).filter(|a| !best.axes.contains(a)).collect::<Vec<_>>();
    let rivals = all.iter().filter(|h| !std::ptr::eq(*h, best) && probability(h) >= PLAUSIBLE);
    Some(SharedTerm {
        id: candidate.about().id,
        sentence: candidate.about().sentence,
        axes: names(&best.axes),
        not_on: names(&others),
        parameter,
        by_axis: alone.collect(),
        probability: probability(best),
        rivals: rivals.map(|h| (CANDIDATES[h.effect].about().id, names(&h.axes), probability(h))).collect(),
    })
}

/// All sets of at least one of `count` axes, or the set of all.
fn sets(count: usize, any: bool) -> Vec<Vec<usize>> {
    let first = if any { 1 } else { (1 << count) - 1 };
    (first..1_usize << count).map(|bits| (0..count).filter(|a| bits >> a & 1 == 1).collect()).collect()
}

fn hypothesis(
    effect: usize,
    candidate: &'static dyn Effect,
    coordinate: &Coordinate,
    posed: &[Posed<'_>],
    said: &[Option<Said>],
    axes: Vec<usize>,
) -> Option<Hypothesis> {
    let wanting: Vec<&Said> = axes.iter().filter_map(|&a| said[a].as_ref()).collect();
    let weight = |said: &&Said| 1.0 / (said.deviation * said.deviation);
    let total: f64 = wanting.iter().map(weight).sum();
    if wanting.is_empty() {
        return None;
    }
    let z = wanting.iter().map(|s| weight(s) * s.z).sum::<f64>() / total;
    let mut log_evidence: f64 = wanting.iter().map(|s| s.gain - 0.5 * weight(s) * (s.z - z).powi(2)).sum();
    let divisor = wanting.iter().map(|s| s.divisor).fold(1.0, f64::max);
    for &a in axes.iter().filter(|&&a| said[a].is_none()) {
        log_evidence += posed[a].gain_at(candidate, coordinate.outer(z))? / divisor;
    }
    let deviation = total.sqrt().recip();
    let range = coordinate.inner(coordinate.bounds[1]) - coordinate.inner(coordinate.bounds[0]);
    log_evidence += 0.5 * (std::f64::consts::TAU * deviation * deviation).ln() - range.ln();
    Some(Hypothesis { effect, axes, z, deviation, log_evidence })
}
