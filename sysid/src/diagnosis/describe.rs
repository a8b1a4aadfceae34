//! The answer in plain sentences.

use super::answer::{Answer, EffectAnswer, Verdict};
use crate::catalogue::find;
use crate::estimate::{Estimate, digits};

/// One to three sentences with numbers and units. `refused` are effects that the training data asked for and the
/// held-out data did not confirm; `corrected` says whether the extended model simulates the held-out data no worse.
pub fn summary(answer: &Answer, refused: &[&str], corrected: bool) -> String {
    let before = mean(answer, |fit| &fit.baseline.vaf_percent);
    let after = mean(answer, |fit| &fit.extended.vaf_percent);
    let ceiling = mean(answer, |fit| &fit.ceiling_vaf_percent);
    let held = answer.fit.held_out.join(", ");
    let mut text = match answer.verdict {
        Verdict::NoMismatch => format!(
            "No mismatch: the model, its parameters estimated again, explains the data down to the noise \
             (free-run VAF {before:.1} % on held-out {held}; the rest is not caused by the input)."
        ),
        Verdict::Unlisted => format!(
            "Physics is missing, and nothing in the catalogue explains it: free-run VAF {before:.1} % on held-out {held}, \
             where an unstructured model reaches {ceiling:.1} %.{}",
            answer.effects.first().map_or(String::new(), |e| {
                let modelled = if corrected && after > before {
                    format!(" With what was fitted to it: {after:.1} %.")
                } else {
                    String::new()
                };
                format!(" What the model leaves: {}.{modelled}", e.equation)
            })
        ),
        _ => {
            let found: Vec<String> = answer.effects.iter().map(told).collect();
            let missing =
                if found.len() == 1 { "Missing from the model" } else { "Missing from the model, together" };
            format!(
                "{missing}: {}. Free-run VAF on held-out {held}: {before:.1} % before, {after:.1} % after.",
                found.join("; and ")
            )
        }
    };
    if answer.verdict == Verdict::Ambiguous {
        for effect in answer.effects.iter().filter(|e| !e.alternatives.is_empty()) {
            let rivals: Vec<String> = effect
                .alternatives
                .iter()
                .map(|a| format!("{} ({:.0} %)", a.id, 100.0 * a.probability))
                .collect();
            text.push_str(&format!(
                " The data cannot rule out {} instead of {} ({:.0} %).",
                rivals.join(" or "),
                effect.id,
                100.0 * effect.probability
            ));
        }
    }
    if !refused.is_empty() {
        text.push_str(&format!(
            " The fitted sections asked for {}, but that did not predict the held-out data better, so it was not added.",
            refused.join(" and ")
        ));
    }
    if !corrected {
        text.push_str(
            " The free run of the held-out data is worse with it although the prediction is better (under feedback and \
             disturbance a biased model can simulate better by chance): the extended model keeps the baseline's values.",
        );
    }
    text
}

fn told(effect: &EffectAnswer) -> String {
    let sentence = find(&effect.id).map_or("", |e| e.about().sentence);
    let parameters: Vec<String> = effect.parameters.iter().map(in_words).collect();
    format!("{sentence} ({}: {})", effect.id, parameters.join(", "))
}

/// "Mc = 0.113 N m (95 %: 0.107 to 0.119)".
pub fn in_words(estimate: &Estimate) -> String {
    let unit = if estimate.unit == "1" { String::new() } else { format!(" {}", estimate.unit) };
    let [low, high] = estimate.ci95;
    format!(
        "{} = {}{unit} (95 %: {} to {})",
        estimate.name,
        digits(estimate.value),
        digits(low),
        digits(high)
    )
}

fn mean(
    answer: &Answer,
    of: impl Fn(&super::answer::FitAnswer) -> &std::collections::BTreeMap<String, f64>,
) -> f64 {
    let table = of(&answer.fit);
    let held: Vec<f64> = answer.fit.held_out.iter().filter_map(|label| table.get(label)).copied().collect();
    held.iter().sum::<f64>() / held.len().max(1) as f64
}
