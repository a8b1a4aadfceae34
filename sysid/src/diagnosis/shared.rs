//! What the axes of one vehicle share: an effect of the actuators, of the sensors or of the clocks is one effect of one size.
//!
//! On axis a the data say ẑ_a ± s_a of the effect's parameter (in the coordinate of the search, a logarithm), and gain g_a in
//! log likelihood over the model without it, calibrated by blocks; of two effects that an axis cannot tell apart, the gain of
//! the better. Sizes that axes share lie within τ of one z̄ (the loads are not quite the same). That the axes of a set S share it,
//! against that every axis has a size of its own or none, has the evidence
//!
//! ```text
//! ln E(S) = Σ_{a ∈ S} (g_a − (ẑ_a − z̄)²/2σ_a² + ln(s_a/σ_a) − r_a) + ½ ln(2π s̄²) − ln(range)
//! σ_a² = s_a² + τ²,   1/s̄² = Σ 1/σ_a²,   z̄ = s̄² Σ ẑ_a/σ_a²,   r_a = max(0, g_a + ½ ln(2π s_a²) − ln(range))
//! ```
//!
//! and on an axis whose data want it at no size, or at one further than σ_a from z̄, the likelihood itself says what is gained
//! or lost with it at z̄. Actuators may serve any two axes or more (rotors that tilt the craft do not turn it: yaw comes from
//! their reaction); a gyro's filter and a clock serve all.

use super::levels::{PLAUSIBLE, WIDEST_SHARED_INTERVAL};
use super::posterior::alike_ahead;
use super::search::fit_one_more;
use crate::catalogue::gyro_lag::GyroLag;
use crate::catalogue::servo_lag::ServoLag;
use crate::dataset::Dataset;
use crate::estimate::Estimate;
use crate::likelihood::evidence::{Information, width};
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
/// τ: sizes that differ by a tenth are alike.
const ALIKE: f64 = 0.1;

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

/// What one axis says of an effect at its own size.
struct Said {
    z: f64,
    deviation: f64,
    fits: Fits,
    divisor: f64,
    fit: Fit,
}

/// Criteria of an axis: with the effect, and the lowest without it that was found from there.
#[derive(Clone, Copy)]
struct Fits {
    with: f64,
    without: f64,
}

/// One axis with what its likelihood is made of.
struct Posed<'a> {
    problem: Problem<'a>,
    asked: &'a Asked<'a>,
}

impl Posed<'_> {
    /// The criterion without the effect, fitted from where a fit with it ended: a search that had not settled before makes every
    /// effect look good.
    fn without(&self, values: &[f64]) -> f64 {
        refit(&self.problem, &[], values).map_or(f64::INFINITY, |fit| fit.criterion())
    }

    /// The effect as this axis wants it; `None` where it wants none.
    fn wants(&self, effect: &'static dyn Effect) -> Option<Said> {
        let fits = fit_one_more(&self.problem, self.asked.fit, &[effect], &|_| {});
        let fit = fits.first()?;
        let information = Information::new(&self.problem, fit, &[])?;
        let own = fit.own_range(&self.problem, 0);
        let divisor = information.divisor(own.clone());
        let coordinate = &self.problem.coordinates(&fit.effects)[own.start];
        let value = fit.minimum.values[own.start];
        let deviation = information.deviations(&fit.minimum.values)[own.start] / coordinate.stretch(value);
        let fits = Fits { with: fit.criterion(), without: self.without(&fit.minimum.values[..own.start]) };
        let z = coordinate.inner(value);
        deviation.is_finite().then(|| Said { z, deviation, fits, divisor, fit: fit.clone() })
    }

    /// What this axis says of every effect. Its likelihoods are all calibrated alike; and where nothing but the noise model tells
    /// one effect from another, as without an angle, both have the gain of the better.
    fn says(&self) -> Vec<Option<Said>> {
        let mut said: Vec<Option<Said>> = CANDIDATES.iter().map(|&effect| self.wants(effect)).collect();
        let divisor = said.iter().flatten().map(|said| said.divisor).fold(1.0, f64::max);
        let alike = |one: &Said, other: &Said| {
            !self.problem.data.has_angle
                && alike_ahead(&self.problem, [&one.fit, &other.fit], Some(self.asked.fit)) >= PLAUSIBLE
        };
        let best = |one: &Said| {
            said.iter()
                .flatten()
                .filter(|other| alike(one, other))
                .map(|other| other.fits.with)
                .fold(one.fits.with, f64::min)
        };
        let with: Vec<Option<f64>> = said.iter().map(|said| said.as_ref().map(best)).collect();
        for (said, with) in said.iter_mut().zip(with).filter_map(|(said, with)| said.as_mut().zip(with)) {
            (said.divisor, said.fits.with) = (divisor, with);
        }
        said
    }

    /// With the effect at `value`, all else fitted.
    fn at(&self, effect: &'static dyn Effect, value: f64) -> Option<Fits> {
        let mut baseline = self.asked.baseline.clone();
        baseline.terms.push(Term { effect, values: vec![value] });
        baseline.held.push(effect.about().id);
        let held = Problem::new(self.asked.data, &baseline, &[]);
        let own = held.known_range().end - 1;
        let mut values = self.asked.fit.minimum.values.clone();
        values.insert(own, value);
        let fit = refit(&held, &[], &values)?;
        let mut values = fit.minimum.values.clone();
        values.remove(own);
        Some(Fits { with: fit.criterion(), without: self.without(&values) })
    }
}

/// An effect on a set of axes.
struct Hypothesis {
    effect: usize,
    axes: Vec<usize>,
    z: f64,
    deviation: f64,
    /// ½ ln(2π s̄²) − ln(range), less what sizes beside z̄ cost.
    cost: f64,
    /// Of each of the axes, with the divisor of its gain.
    fits: Vec<(Fits, f64)>,
}

impl Hypothesis {
    /// ln E(S), given of every axis the lowest criterion without any effect, and r_a.
    fn log_evidence(&self, without: &[f64], alone: &[f64]) -> f64 {
        let of = |(&a, (fits, divisor)): (&usize, &(Fits, f64))| {
            0.5 * (without[a] - fits.with) / divisor - alone[a]
        };
        self.cost + self.axes.iter().zip(&self.fits).map(of).sum::<f64>()
    }
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
    let said: Vec<Vec<Option<Said>>> = posed.iter().map(Posed::says).collect();
    let of = |effect: usize| -> Vec<Option<&Said>> { said.iter().map(|of| of[effect].as_ref()).collect() };
    let mut all = Vec::new();
    for (effect, &candidate) in CANDIDATES.iter().enumerate() {
        for set in sets(axes.len(), candidate.about().locus == Locus::Actuator) {
            all.extend(hypothesis(effect, candidate, &coordinates[effect], &posed, &of(effect), set));
        }
    }
    let mut without: Vec<f64> = axes.iter().map(|asked| asked.fit.criterion()).collect();
    for (&a, (fits, _)) in all.iter().flat_map(|h: &Hypothesis| h.axes.iter().zip(&h.fits)) {
        without[a] = without[a].min(fits.without);
    }
    for (of_axis, without) in said.iter().zip(&mut without) {
        *without = of_axis.iter().flatten().fold(*without, |least, said| least.min(said.fits.without));
    }
    let alone = said.iter().zip(&without).map(|(of_axis, without)| {
        let worth = |(said, coordinate): (&Option<Said>, &Coordinate)| {
            let said = said.as_ref()?;
            Some(0.5 * (without - said.fits.with) / said.divisor + occam(said.deviation, coordinate))
        };
        of_axis.iter().zip(&coordinates).filter_map(worth).fold(0.0, f64::max)
    });
    let alone: Vec<f64> = alone.collect();
    let prior = ((1.0 - NONE) / all.len().max(1) as f64 / NONE).ln();
    let log = |h: &Hypothesis| h.log_evidence(&without, &alone) + prior;
    let best = all.iter().max_by(|a, b| log(a).total_cmp(&log(b)))?;
    let largest = log(best).max(0.0);
    let weight = |log: f64| (log - largest).exp();
    let total = weight(0.0) + all.iter().map(|h| weight(log(h))).sum::<f64>();
    let probability = |h: &Hypothesis| weight(log(h)) / total;
    if probability(best) <= weight(0.0) / total {
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
        .filter_map(|&a| said[a][best.effect].as_ref())
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

/// All sets of at least two of `count` axes, or the set of all.
fn sets(count: usize, any: bool) -> Vec<Vec<usize>> {
    let all = (1_usize << count) - 1;
    let members = |bits: usize| (0..count).filter(|a| bits >> a & 1 == 1).collect::<Vec<_>>();
    (1..=all).filter(|&bits| bits == all || any).map(members).filter(|set| set.len() > 1).collect()
}

/// ½ ln(2π s²) − ln(range).
fn occam(deviation: f64, coordinate: &Coordinate) -> f64 {
    (std::f64::consts::TAU.sqrt() * deviation / width(coordinate)).ln()
}

fn hypothesis(
    effect: usize,
    candidate: &'static dyn Effect,
    coordinate: &Coordinate,
    posed: &[Posed<'_>],
    said: &[Option<&Said>],
    axes: Vec<usize>,
) -> Option<Hypothesis> {
    let wanting: Vec<&Said> = axes.iter().filter_map(|&a| said[a]).collect();
    let weight = |said: &&Said| 1.0 / (said.deviation * said.deviation + ALIKE * ALIKE);
    let total: f64 = wanting.iter().map(weight).sum();
    if wanting.is_empty() {
        return None;
    }
    let z = wanting.iter().map(|s| weight(s) * s.z).sum::<f64>() / total;
    // the errors of a size hold near it alone: what another axis' size costs is asked of the likelihood
    let near = |said: &&Said| (said.z - z).powi(2) * weight(said) <= 1.0;
    let divisor = wanting.iter().map(|s| s.divisor).fold(1.0, f64::max);
    let mut beside = 0.0;
    let mut fits = Vec::with_capacity(axes.len());
    for &a in &axes {
        fits.push(match said[a].filter(near) {
            Some(said) => {
                let share = weight(&said).sqrt() * said.deviation;
                beside += 0.5 * weight(&said) * (said.z - z).powi(2) - share.ln();
                (said.fits, said.divisor)
            }
            None => {
                (posed[a].at(candidate, coordinate.outer(z))?, said[a].map_or(divisor, |said| said.divisor))
            }
        });
    }
    let deviation = total.sqrt().recip();
    let cost = occam(deviation, coordinate) - beside;
    Some(Hypothesis { effect, axes, z, deviation, cost, fits })
}
