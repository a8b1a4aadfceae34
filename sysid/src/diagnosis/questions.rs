//! The questions of a careful person, in their order, with the answers of these data.

use super::answer::{Answer, EffectAnswer, Verdict, WithError};
use super::data_checks::State;
use super::describe::{in_a_phrase, percent};
use crate::catalogue::trim_offset::TrimOffset;
use crate::estimate::digits;
use crate::model::effect::Effect;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A question and its answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Question {
    /// The question.
    pub question: &'static str,
    /// Its answer, with numbers and units.
    pub answer: String,
}

/// Probability by chance below which a term is not the same in all parts of the data.
const UNEVEN: f64 = 0.01;
/// Most parts whose values are told one by one.
const PARTS_TOLD: usize = 6;

/// Is the loop closed, where is the delay, are the gains right; then every term, strongest first, with how constant it is and
/// what else it could be; and what is left. Where the data are to be put right first, that alone.
pub fn questions(answer: &Answer) -> Vec<Question> {
    if answer.verdict == Verdict::CheckData {
        let found = answer.data_checks.iter().filter(|check| check.state == State::Found);
        let words: Vec<&str> = found.map(|check| check.words.as_str()).collect();
        let question = "Can the data be used as they are?";
        return vec![Question { question, answer: format!("no: {}", words.join("; ")) }];
    }
    let mut all = vec![
        Question { question: "Is the loop closed?", answer: checked(answer, &["feedback"]) },
        Question { question: "Where is the delay?", answer: checked(answer, &["delay", "input_hold"]) },
        Question { question: "Are the gains right?", answer: checked(answer, &["input_sign", "rate_unit"]) },
    ];
    if let Some(balance) = &answer.balance {
        let answer =
            format!("{}{}", if balance.out_of_trim { "not in the model's: " } else { "" }, balance.words);
        all.push(Question { question: "Is it in trim?", answer });
    }
    if answer.fit.held_out.is_empty() {
        return all;
    }
    let of_motion = |effect: &&EffectAnswer| {
        !(effect.id == TrimOffset.about().id && answer.balance.as_ref().is_some_and(|b| b.out_of_trim))
    };
    let terms: Vec<&EffectAnswer> = answer.effects.iter().filter(of_motion).collect();
    if terms.is_empty() {
        let answer = match answer.remainder {
            Some(_) => "nothing that has a name or a shape here; see what is left",
            None => "nothing that these data would show",
        };
        let answer = answer.into();
        all.push(Question { question: "What is missing?", answer });
    }
    for (i, effect) in terms.into_iter().enumerate() {
        let question = if i == 0 { "What is the strongest term that is missing?" } else { "And the next?" };
        all.push(Question { question, answer: term(answer, effect) });
    }
    let left = answer
        .remainder
        .as_ref()
        .map(|left| format!("{} of what can be closed: {}", percent(left.share), left.words));
    let left = left.unwrap_or_else(|| "nothing that the tests see".into());
    all.push(Question { question: "What is left?", answer: left });
    all
}

/// What the checks of these causes say.
fn checked(answer: &Answer, causes: &[&str]) -> String {
    let told = causes.iter().filter_map(|cause| {
        let check = answer.data_checks.iter().find(|check| check.cause == *cause)?;
        Some(match check.state {
            State::CannotTell => format!("cannot be told: {}", check.words),
            _ => check.words.clone(),
        })
    });
    let mut told: Vec<String> = told.collect();
    told.dedup();
    told.join("; ")
}

fn term(answer: &Answer, effect: &EffectAnswer) -> String {
    let mut parts = vec![format!("{}; {} of what can be closed", in_a_phrase(effect), percent(effect.share))];
    // Rotations that choose a rival choose the same in another name.
    if let Some([chosen, of]) =
        answer.fit.chosen_in.get(&effect.id).filter(|_| effect.alternatives.is_empty())
    {
        parts.push(format!("found in {chosen} of {of} fits that each leave a part of the data out"));
    }
    parts.extend(constancy(effect));
    let rivals: Vec<String> = effect
        .alternatives
        .iter()
        .map(|rival| format!("{} ({})", rival.id, percent(rival.probability)))
        .collect();
    parts.push(match rivals.as_slice() {
        [] => "no other name comes near".into(),
        _ => format!("or it is {}", rivals.join(" or ")),
    });
    parts.join("; ")
}

/// Its first parameter in each part of the data, and whether these differ by more than chance.
fn constancy(effect: &EffectAnswer) -> Option<String> {
    let first = effect.parameters.first()?;
    let of_parts: Vec<(&String, WithError)> =
        effect.by_part.iter().filter_map(|(label, values)| Some((label, *values.first()?))).collect();
    if of_parts.len() < 2 {
        return None;
    }
    let unit = if first.unit == "1" { String::new() } else { format!(" {}", first.unit) };
    let values: Vec<WithError> = of_parts.iter().map(|(_, value)| *value).collect();
    let p_value = same(&values)?;
    let told = if p_value < UNEVEN {
        format!("not the same everywhere (p = {p_value:.0e})")
    } else {
        format!("the same everywhere within its error (p = {})", digits(p_value))
    };
    let listed: Vec<String> = of_parts
        .iter()
        .take(PARTS_TOLD)
        .enumerate()
        .map(|(i, (label, v))| {
            let unit = if i == 0 { unit.as_str() } else { "" };
            format!("{} ± {}{unit} in {label}", digits(v.value), digits(v.standard_error))
        })
        .collect();
    let more = if of_parts.len() > PARTS_TOLD { ", ..." } else { "" };
    Some(format!("{} is {told}: {}{more}", first.name, listed.join(", ")))
}

/// Probability that values with these errors differ as much by chance.
fn same(values: &[WithError]) -> Option<f64> {
    let weight = |v: &WithError| 1.0 / (v.standard_error * v.standard_error);
    let total: f64 = values.iter().map(weight).sum();
    let mean = values.iter().map(|v| weight(v) * v.value).sum::<f64>() / total;
    let statistic: f64 = values.iter().map(|v| weight(v) * (v.value - mean).powi(2)).sum();
    Some(ChiSquared::new(values.len() as f64 - 1.0).ok()?.sf(statistic)).filter(|p| p.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(value: f64) -> WithError {
        WithError { value, standard_error: 0.1 }
    }

    #[test]
    fn values_within_their_errors_are_the_same_and_others_are_not() {
        assert!(same(&[0.9, 1.0, 1.1, 1.0].map(value)).unwrap() > 0.5);
        assert!(same(&[0.6, 1.0, 1.4, 1.0].map(value)).unwrap() < 1e-4);
    }
}
