//! The diagnoses of several axes as they stand on a terminal.

use super::{heading, indented, paragraph, questions};
use crate::format;
use crate::report::content::{headline, probability, verdict_of};
use sysid::diagnosis::axes::AxesDiagnosis;
use sysid::diagnosis::axis_words::of_axis;
use sysid::diagnosis::shared::SharedTerm;

/// What the axes share, and each by itself.
pub fn diagnoses(found: &AxesDiagnosis) -> String {
    let shared = found.shared.as_ref().map_or_else(|| "nothing that these data would show".into(), shared);
    let mut text = paragraph(&format!("SHARED BY THE AXES: {shared}"));
    for (axis, diagnosis) in &found.axes {
        let answer = &diagnosis.answer;
        let title =
            format!("{}: {}: {}", axis.to_uppercase(), verdict_of(answer), of_axis(&headline(answer), axis));
        text.push_str(&heading(&title));
        text.push_str(&indented(&answer.summary, "  ", "  "));
        text.push_str(&questions(&answer.questions));
    }
    text
}

fn shared(term: &SharedTerm) -> String {
    let shown = format::estimate(&term.parameter);
    let alone = term.axes.iter().zip(&term.by_axis);
    let alone: Vec<String> =
        alone.map(|(axis, own)| format!("{axis} by itself {}", format::estimate(own).value)).collect();
    let rest = match term.not_on.as_slice() {
        [] => String::new(),
        none => format!("; none on {}", none.join(" and ")),
    };
    let rivals: Vec<String> = term
        .rivals
        .iter()
        .map(|(id, axes, p)| format!("{id} on {} ({:.0} %)", axes.join(" and "), 100.0 * p))
        .collect();
    let rivals =
        if rivals.is_empty() { String::new() } else { format!("; or instead {}", rivals.join(", or ")) };
    format!(
        "{} ({}) on {} alike: {} = {} {} (95 %: {}; {}){rest}; probability {}{rivals}",
        term.sentence,
        term.id,
        term.axes.join(" and "),
        term.parameter.name,
        shown.value,
        format::unit(&term.parameter.unit),
        shown.interval,
        alone.join(", "),
        probability(term.probability),
    )
}
