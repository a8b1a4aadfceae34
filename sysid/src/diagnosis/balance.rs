//! The balance of the means, which needs no excitation: the command that holds the vehicle against that of the model.
//!
//! Over a span of length T, with Δq the change of the rate over it,
//!
//! ```text
//! Iyy Δq/T = ∂M/∂u ū + ∂M/∂q q̄ + M0      command  u₀ = −M0/(∂M/∂u) = ū + (∂M/∂q q̄ − Iyy Δq/T)/(∂M/∂u)
//! ```
//!
//! Where a controller holds the vehicle, a slow background hides a constant moment from every prediction, and the mean of what
//! the controller gives does not. Its variance is that of the mean of G spans that may hang together,
//!
//! ```text
//! s² = (γ₀ + 2 max(0, γ₁) (1 − 1/G))/G,   γ_j the autocovariance of u₀ over the spans      (Bartlett, J. R. Stat. Soc. Suppl. 8, 1946)
//! ```

use super::answer::{Answer, BalanceAnswer, EffectAnswer, Evidence, Verdict, WithError};
use super::describe::{in_a_phrase, predicts};
use crate::catalogue::find;
use crate::catalogue::trim_offset::TrimOffset;
use crate::compare::statistics::{self, Measured, judge};
use crate::dataset::{Dataset, Run, pieces};
use crate::estimate::{Estimate, digits};
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::baseline::Baseline;
use crate::model::effect::{Class, Effect};
use crate::model::file::{EffectEntry, ModelFile};
use crate::recording::InputUnit;
use std::collections::BTreeMap;

/// Length of a span, s, of a vehicle that is held and of one that follows the input, and the least and most of them.
const SPAN_S: f64 = 2.0;
const FOLLOWING_SPAN_S: f64 = 1.0;
const SPANS: [usize; 2] = [4, 24];
/// Least share of the command's size at which what is lost of it in an open loop is told.
const LEAST_LOST: f64 = 0.02;
/// Share of the rows in which the motion goes back, from which on it goes both ways.
const BACK_AND_FORTH: f64 = 0.05;
/// What may take a part of the command in an open loop.
const ONE_WAY: &str = "a constant moment, dry friction or a dead band, which are one and the same while the motion goes one way";
const BOTH_WAYS: &str = "a constant moment acts, or the command's zero is another";
/// Size of a usual change of trim, as a share of full command.
const USUAL: f64 = 0.05;
/// Mean angle from which on the command may balance what restores the vehicle and is not in the model, rad.
const LEVEL: f64 = 0.1;

/// The command that holds the vehicle, and the model's.
pub struct Balance {
    /// u₀ of the data.
    command: Measured,
    unit: InputUnit,
    /// The user's model.
    model: Option<OfModel>,
    /// What may take it from the command in an open loop.
    lost_by: Option<&'static str>,
}

/// Whether a term leaves the balance of the means to gains and input, also where the command goes one way: lags and delays do.
fn keeps_the_mean(effect: &dyn Effect) -> bool {
    effect.is_background() || effect.class() == Some(Class::Phase) && !effect.moves_the_mean()
}

struct OfModel {
    /// u₀ of the model.
    command: f64,
    /// Its ∂M/∂u, where it has one: without it the moment is not known.
    dm_du: Option<f64>,
    has_trim: bool,
    difference: statistics::Difference,
    /// ln of the odds of a difference.
    log_odds: f64,
}

impl Balance {
    /// Of the data against the user's model; `None` where the balance cannot be drawn up: fewer than four spans, a mean angle that
    /// is not level, or a model with a moment that depends on the angle.
    pub fn new(data: &Dataset, baseline: &Baseline, model: Option<&ModelFile>) -> Option<Self> {
        let restored = baseline.terms.iter().any(|term| term.effect.about().variable == "theta");
        if restored || !is_level(data) {
            return None;
        }
        let plant = &baseline.plant;
        let known = model.and_then(|model| model.plant.dm_du);
        // Without the user's gain, what the rate has in the balance is not known; it is little.
        let [damping, inertia] = known.map_or([0.0; 2], |dm_du| [plant.dm_dq / dm_du, plant.inertia / dm_du]);
        let command = mean_with_error(&commands(data, damping, inertia, SPAN_S))?;
        if known.is_none() && turns(data) {
            return None;
        }
        let of_model = |_: &ModelFile| {
            let trim = baseline.terms.iter().find(|term| term.effect.about().id == TrimOffset.about().id);
            let given = known.zip(trim).map_or(0.0, |(dm_du, trim)| -trim.values[0] / dm_du);
            let usual = match data.input_unit {
                InputUnit::Normalised => USUAL,
                InputUnit::Percent => 100.0 * USUAL,
                _ => data.amplitudes(plant.inertia, plant.dm_du).u,
            };
            let exact = Measured { value: given, deviation: 0.0, freedom: f64::INFINITY };
            let difference = judge(&[([exact, command], usual)]).swap_remove(0);
            let log_odds = statistics::log_odds(difference.z, command.deviation, usual);
            OfModel { command: given, dm_du: known, has_trim: trim.is_some(), difference, log_odds }
        };
        Some(Self { command, unit: data.input_unit, model: model.map(of_model), lost_by: None })
    }

    /// What the vehicle of `fit` loses of the command in an open loop, by its own gains:
    ///
    /// ```text
    /// s² = s²(spans) + (q̄ s(∂M/∂q/∂M/∂u))²
    /// ```
    ///
    /// A slow background hides that from every prediction. `None` where a term may have a part in the mean, and where nothing sure and
    /// worth telling is lost.
    pub fn of_fit(problem: &Problem<'_>, fit: &Fit, information: &Information) -> Option<Self> {
        let data = problem.data;
        let of_model = problem.baseline.terms.iter().map(|term| term.effect);
        let known = information.moves(0) && information.moves(1);
        if !known || !is_level(data) || !fit.effects.iter().copied().chain(of_model).all(keeps_the_mean) {
            return None;
        }
        let plant = problem.unpack(&fit.effects, &fit.minimum.values).plant;
        let rates: Vec<Vec<f64>> = data.runs.iter().map(Run::rate_or_slope).collect();
        let mean_rate = rates.iter().flatten().sum::<f64>() / data.samples() as f64;
        let damping = plant.dm_dq / plant.dm_du;
        let of_spans =
            mean_with_error(&commands(data, damping, plant.inertia / plant.dm_du, FOLLOWING_SPAN_S))?;
        let mut gradient = vec![0.0; fit.minimum.values.len()];
        gradient[0] = mean_rate / plant.dm_du;
        gradient[1] = -mean_rate * damping / plant.dm_du;
        let by_gains = information.deviation_along(&fit.minimum.values, &gradient);
        let command = Measured { deviation: of_spans.deviation.hypot(by_gains), ..of_spans };
        let [low, high] = command.estimate("u0", "").ci95;
        let size = data.runs.iter().flat_map(|run| &run.u).fold(0.0_f64, |size, u| size.max(u.abs()));
        let is_worth_telling = (low > 0.0 || high < 0.0) && command.value.abs() > LEAST_LOST * size;
        let back = rates.iter().flatten().filter(|rate| **rate * mean_rate < 0.0).count();
        let goes_one_way = (back as f64) < BACK_AND_FORTH * data.samples() as f64;
        let lost_by = Some(if goes_one_way { ONE_WAY } else { BOTH_WAYS });
        is_worth_telling.then_some(Self { command, unit: data.input_unit, model: None, lost_by })
    }

    /// Writes it into an answer and its model. A vehicle that is out of the model's trim has a constant moment where no other name
    /// accounts for the mean, as one-sided friction would: that is an answer where nothing else could be asked. It is told before
    /// names that have less evidence, and before those that may be others.
    pub fn write(&self, answer: &mut Answer, model: &mut ModelFile) {
        if answer.verdict == Verdict::CheckData {
            return;
        }
        let id = TrimOffset.about().id;
        let told = answer.effects.iter().any(|effect| effect.id == id)
            || matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous)
                && predicts(answer)
                && answer.effects.iter().any(|effect| find(&effect.id).is_none_or(Effect::moves_the_mean));
        let out =
            self.model.as_ref().filter(|m| m.difference.verdict == statistics::Verdict::Changed && !told);
        answer.balance = Some(BalanceAnswer {
            words: self.words(),
            command: self.command.estimate("u0", self.unit.symbol()),
            out_of_trim: out.is_some(),
        });
        if self.model.is_none() {
            self.carry(model);
        }
        let Some(of_model) = out else { return };
        let held = format!("Out of the model's trim: {}.", self.words());
        let Some(dm_du) = of_model.dm_du.filter(|_| !of_model.has_trim) else {
            answer.summary = format!("{held} {}", answer.summary);
            return;
        };
        let effect = self.effect(of_model, dm_du, answer.effects.is_empty());
        model.effects.push(entry(effect.parameters[0].value));
        let told = format!("{held} Missing from the model: {}.", in_a_phrase(&effect));
        let place = place_among(&answer.effects, &effect);
        answer.summary = match place {
            0 => format!("{told} {}", answer.summary),
            _ => format!("{} {told}", answer.summary),
        };
        if matches!(answer.verdict, Verdict::NotExcited | Verdict::NoMismatch) {
            answer.verdict = Verdict::Named;
        }
        answer.effects.insert(place, effect);
    }

    /// Gives a model that was found here its trim, where the command is not zero.
    fn carry(&self, model: &mut ModelFile) {
        let [low, high] = self.command.estimate("u0", "").ci95;
        let has_trim = model.effects.iter().any(|effect| effect.id == TrimOffset.about().id);
        if let Some(dm_du) = model.plant.dm_du
            && (low > 0.0 || high < 0.0)
            && !has_trim
        {
            model.effects.push(entry(-dm_du * self.command.value));
        }
    }

    fn words(&self) -> String {
        let estimate = self.command.estimate("u0", self.unit.symbol());
        let unit = match self.unit {
            InputUnit::Normalised => "of full command".to_owned(),
            unit => unit.symbol().to_owned(),
        };
        let [low, high] = estimate.ci95.map(digits);
        let held = format!(
            "to hold it takes {} {unit} on average (95 %: {low} to {high}, by its spread over time)",
            digits(estimate.value)
        );
        if let Some(by) = self.lost_by {
            return format!(
                "{} {unit} of the command move nothing (95 %: {low} to {high}): {by}",
                digits(estimate.value)
            );
        }
        let Some(of_model) = &self.model else { return held };
        let against = format!("{held}, where the model takes {}", digits(of_model.command));
        match of_model.difference.verdict {
            statistics::Verdict::Changed => against,
            statistics::Verdict::Same => format!("{against}: the same within its error"),
            statistics::Verdict::CannotTell => format!("{against}: whether that differs cannot be told"),
        }
    }

    fn effect(&self, of_model: &OfModel, dm_du: f64, alone: bool) -> EffectAnswer {
        let about = TrimOffset.about();
        let moment = |u: f64| -dm_du * (u - of_model.command);
        let command = self.command.estimate("u0", "");
        let [a, b] = command.ci95.map(moment);
        let (value, ci95) = (moment(command.value), [a.min(b), a.max(b)]);
        EffectAnswer {
            id: about.id.into(),
            locus: about.locus,
            equation: about.equation.into(),
            parameters: vec![Estimate { name: "M0".into(), unit: "N m".into(), value, ci95 }],
            by_part: BTreeMap::new(),
            probability: of_model.difference.probability,
            share: if alone { 1.0 } else { 0.0 },
            alternatives: Vec::new(),
            // A mean has no part in a VAF.
            evidence: Evidence {
                log_evidence: of_model.log_odds,
                p_value: of_model.difference.p_value,
                vaf_gain_points: WithError::default(),
                held_out_log_likelihood: WithError::default(),
            },
        }
    }
}

/// Where the trim is told: after what has more evidence and is as sure, which nothing is that has rivals.
fn place_among(others: &[EffectAnswer], own: &EffectAnswer) -> usize {
    let is_before = |other: &&EffectAnswer| {
        other.alternatives.is_empty() && other.evidence.log_evidence > own.evidence.log_evidence
    };
    others.iter().take_while(is_before).count()
}

fn entry(moment: f64) -> EffectEntry {
    let parameters = BTreeMap::from([("M0".to_owned(), moment)]);
    EffectEntry { id: TrimOffset.about().id.into(), shape: None, parameters, remark: None }
}

/// Whether the mean of the angle, where it was measured, is level.
fn is_level(data: &Dataset) -> bool {
    data.mean_angle().is_none_or(|angle| angle.abs() < LEVEL)
}

/// Whether the vehicle turns, as at a set-point of its rate: over spans the rate has a mean that is much of its size.
fn turns(data: &Dataset) -> bool {
    let rates: Vec<Vec<f64>> = data.runs.iter().map(Run::rate_or_slope).collect();
    let of_spans = |(run, rates): (&Run, &Vec<f64>)| -> f64 {
        let spans = rates.chunks(((SPAN_S / run.step) as usize).max(1));
        spans.map(|span| span.iter().sum::<f64>().powi(2) / span.len() as f64).sum()
    };
    let slow: f64 = data.runs.iter().zip(&rates).map(of_spans).sum();
    slow > 0.5 * rates.iter().flatten().map(|rate| rate * rate).sum::<f64>()
}

/// u₀ of every span; `damping` is ∂M/∂q and `inertia` Iyy, per ∂M/∂u.
fn commands(data: &Dataset, damping: f64, inertia: f64, span: f64) -> Vec<f64> {
    let seconds: f64 = data.runs.iter().map(|run| run.len() as f64 * run.step).sum();
    let count = ((seconds / span) as usize).min(SPANS[1]);
    let rates: Vec<Vec<f64>> = data.runs.iter().map(Run::rate_or_slope).collect();
    let all = data.samples();
    let of_span = |k: usize| {
        let (mut time, mut balance) = (0.0, 0.0);
        for (run, rows) in pieces(data.runs.iter().map(Run::len), k * all / count..(k + 1) * all / count) {
            let (step, rate) = (data.runs[run].step, &rates[run]);
            let held =
                rows.clone().map(|row| data.runs[run].u[row] + damping * rate[row]).sum::<f64>() * step;
            let turned = rate[rows.end - 1] - rate[rows.start];
            time += rows.len() as f64 * step;
            balance += held - inertia * turned;
        }
        balance / time
    };
    (0..count).map(of_span).collect()
}

/// The mean of spans that may hang together; `None` of too few.
fn mean_with_error(spans: &[f64]) -> Option<Measured> {
    let count = spans.len() as f64;
    let value = spans.iter().sum::<f64>() / count;
    let variance = spans.iter().map(|x| (x - value).powi(2)).sum::<f64>() / (count - 1.0);
    let next = spans.windows(2).map(|x| (x[0] - value) * (x[1] - value)).sum::<f64>() / (count - 1.0);
    let deviation = ((variance + 2.0 * next.max(0.0) * (1.0 - 1.0 / count)) / count).sqrt();
    (spans.len() >= SPANS[0]).then_some(Measured { value, deviation, freedom: count - 1.0 })
}

#[cfg(test)]
mod tests {
    use super::super::answer::Alternative;
    use super::super::data_checks::fixture::{GAIN, fitted, flight, model};
    use super::*;
    use crate::model::effect::Locus;

    #[test]
    fn what_an_open_loop_loses_of_the_command_is_told() {
        let of_fit = |zero: f64| {
            let mut flown = flight(3, 0.0);
            flown.u.iter_mut().for_each(|u| *u += zero);
            fitted(&flown.recording(), &model(GAIN, 0.06), |_, problem, fit| {
                let information = Information::new(problem, fit, &[problem.data.places()]).unwrap();
                Balance::of_fit(problem, fit, &information)
            })
        };
        let lost = of_fit(0.004).unwrap();
        let [low, high] = lost.command.estimate("u0", "rad").ci95;
        assert!(low < 0.004 && 0.004 < high && high - low < 0.004, "{low} {high}");
        assert!(lost.words().contains("rad of the command move nothing"), "{}", lost.words());
        assert!(of_fit(0.0).is_none());
    }

    fn effect_of(id: &str, log_evidence: f64) -> EffectAnswer {
        EffectAnswer {
            id: id.into(),
            locus: Locus::Actuator,
            equation: String::new(),
            parameters: Vec::new(),
            by_part: BTreeMap::new(),
            probability: 0.99,
            share: 0.3,
            alternatives: Vec::new(),
            evidence: Evidence { log_evidence, ..Evidence::default() },
        }
    }

    #[test]
    fn a_trim_is_told_after_what_has_more_evidence() {
        let effect = |log_evidence: f64| effect_of("coulomb_friction", log_evidence);
        let place = |own: f64| place_among(&[50.0, 20.0, 30.0].map(effect), &effect(own));
        assert_eq!([60.0, 40.0, 20.0, 10.0].map(place), [0, 1, 1, 3]);
    }

    #[test]
    fn a_trim_is_told_before_what_may_be_something_else() {
        let sure = effect_of("quadratic_drag", 50.0);
        let mut doubtful = effect_of("extra_delay", 40.0);
        doubtful.alternatives.push(Alternative { id: "servo_lag".into(), probability: 0.3 });
        let own = effect_of("trim_offset", 10.0);
        assert_eq!(place_among(&[sure.clone(), doubtful.clone()], &own), 1);
        assert_eq!(place_among(&[doubtful, sure], &own), 0);
    }

    #[test]
    fn spans_that_hang_together_are_fewer() {
        let alternating = mean_with_error(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0]).unwrap();
        let hanging = mean_with_error(&[1.0, 1.0, 1.0, -1.0, -1.0, -1.0]).unwrap();
        assert!((alternating.deviation - (1.2_f64 / 6.0).sqrt()).abs() < 1e-12);
        assert!(hanging.deviation > 1.3 * alternating.deviation);
        assert!(mean_with_error(&[1.0, 2.0, 3.0]).is_none());
    }
}
