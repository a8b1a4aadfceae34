//! Every sentence of the answer that a person reads.

use super::answer::{Answer, EffectAnswer, HeldOutAnswer, Predicted, VafAnswer, Verdict};
use super::levels::SEEN;
use super::posterior::is_in_other_words;
use super::rotation::mean_by_motion;
use super::verdict::Objection;
use crate::catalogue::{CATALOGUE, find};
use crate::estimate::{Estimate, digits};

/// One to three sentences with numbers and units, and what speaks against names that are not the answer.
pub fn summary(answer: &Answer, objection: Option<Objection>) -> String {
    let mut text = match answer.verdict {
        Verdict::NoMismatch => no_mismatch(answer),
        Verdict::Unlisted => {
            let found: Vec<String> = answer.effects.iter().map(in_a_phrase).collect();
            let seen = match (found.is_empty(), &answer.remainder) {
                (false, None) => format!("What was found: {}.", found.join("; and ")),
                (false, Some(r)) => {
                    format!("What was found: {}. What is left: {}.", found.join("; and "), r.words)
                }
                (true, Some(r)) => format!("What the model leaves: {}.", r.words),
                (true, None) => String::new(),
            };
            let humble = if predicts(answer) {
                ""
            } else {
                " Even with that, more than half of the motion is not predicted: design nothing on these values."
            };
            let figures = figures(answer, !answer.effects.is_empty());
            format!("Physics is missing, and {}: {figures}. {seen}{humble}", in_reason(objection))
        }
        Verdict::Named if answer.disturbance_alone() => {
            let found: Vec<String> = answer.effects.iter().map(in_a_phrase).collect();
            format!(
                "What answers to the input is all in the model, its parameters estimated again ({}); beside it {}.",
                figures(answer, false),
                found.join("; and ")
            )
        }
        Verdict::Named | Verdict::Ambiguous => {
            let found: Vec<String> = answer.effects.iter().map(in_a_phrase).collect();
            let missing =
                if found.len() == 1 { "Missing from the model" } else { "Missing from the model, together" };
            format!("{missing}: {}. {}.", found.join("; and "), capital(&figures(answer, true)))
        }
        Verdict::NotExcited | Verdict::CheckData => String::new(),
    };
    text.extend(in_other_words(&answer.effects));
    if answer.verdict == Verdict::Ambiguous {
        for effect in answer.effects.iter().filter(|e| !e.alternatives.is_empty()) {
            let rivals: Vec<String> = effect
                .alternatives
                .iter()
                .map(|a| format!("{} ({})", a.id, percent(a.probability)))
                .collect();
            text.push_str(&format!(
                " The data cannot rule out {} instead of {} ({}).",
                rivals.join(" or "),
                effect.id,
                percent(effect.probability)
            ));
        }
    }
    if matches!(answer.verdict, Verdict::Named | Verdict::Ambiguous)
        && let Some(remainder) = &answer.remainder
    {
        text.push_str(&format!(" Left beside it ({}): {}.", percent(remainder.share), remainder.words));
    }
    text.push_str(&off_in_model(answer));
    text
}

/// Effects of the user's model whose values the data contradict.
fn off_in_model(answer: &Answer) -> String {
    let mut text = String::new();
    for known in &answer.in_model {
        for (estimate, given) in known.parameters.iter().zip(&known.given) {
            let [low, high] = estimate.ci95;
            let same_in_print = digits(estimate.value) == digits(*given);
            if low <= *given && *given <= high || low == high || same_in_print {
                continue;
            }
            let unit = if estimate.unit == "1" { String::new() } else { format!(" {}", estimate.unit) };
            text.push_str(&format!(
                " The {} that the model has is off: {}, not {}{unit}.",
                known.id,
                estimate,
                digits(*given)
            ));
        }
    }
    text
}

/// What is said where nothing is missing, and how much that says.
fn no_mismatch(answer: &Answer) -> String {
    let figures = figures(answer, false);
    if answer.remainder.is_some() {
        format!(
            "No mismatch that matters: the model, its parameters estimated again, leaves next to nothing of the motion ({figures})."
        )
    } else if let Some(past) = told_by_the_past(answer) {
        let past = in_percent(past);
        format!(
            "No mismatch that these data would show; but of the next second the past of the motion alone tells {past}, as much as the model \
             ({figures}): what the input adds to it is not seen. Design nothing on the gain before steps or a sweep have shown it."
        )
    } else if predicts(answer) && free_run(answer) < SEEN {
        let free_run = in_percent(free_run(answer));
        format!(
            "No mismatch that these data would show; but run freely over whole sections the model tells {free_run} of the motion ({figures}): \
             something beside the input moves the axis, another input, a load or the air, or small errors grow in it. The values stand where \
             that goes its own way; before you design on them, see them again in a test of which the free run tells most."
        )
    } else if answer.fit.predicted.is_none() || predicts(answer) {
        format!(
            "No mismatch: the model, its parameters estimated again, explains the data down to the noise ({figures})."
        )
    } else {
        format!(
            "No mismatch that these data would show, and more than half of the motion does not follow from the input ({figures}): \
             a larger input or a longer test would show more."
        )
    }
}

/// That what several names say together is one effect of the catalogue in other words.
fn in_other_words(effects: &[EffectAnswer]) -> impl Iterator<Item = String> + '_ {
    let told = |id: &str| effects.iter().any(|effect| effect.id == id);
    let same = CATALOGUE.iter().filter(move |effect| is_in_other_words(**effect, told));
    same.map(|effect| {
        let (parts, whole) = (effect.restates().join(" and "), effect.about().id);
        format!(" Of {parts} no motion tells {whole}: the two say the same.")
    })
}

/// Why no name is the answer.
fn in_reason(objection: Option<Objection>) -> String {
    match objection {
        None => "nothing in the catalogue explains it".into(),
        Some(Objection::Unseen) => {
            "too little of the motion follows from the input for a name to be sure".into()
        }
        Some(Objection::Unstable) => {
            "the first name for it does not stand on data that it was not fitted to".into()
        }
        Some(Objection::Partly(share)) => {
            format!("the names found explain {} of what can be closed, no more", percent(share))
        }
    }
}

/// Whether the answer's model tells at least half of the motion of parts held out, or of what its past does not tell.
pub fn predicts(answer: &Answer) -> bool {
    answer.fit.predicted.is_some_and(|predicted| predicted != Predicted::Little)
}

/// VAF of the baseline's free run, held out, per cent.
fn free_run(answer: &Answer) -> f64 {
    mean_vaf(answer, &|part| &part.baseline, None)
}

/// VAF of the past of the motion alone 1 s ahead, per cent, where a model that tells half of that second does no better.
fn told_by_the_past(answer: &Answer) -> Option<f64> {
    let far = answer.fit.predicted == Some(Predicted::Far);
    far.then(|| no_less_than_the_model(answer.fit.held_out.values())).flatten()
}

/// VAF of the past alone 1 s ahead over the parts in which that horizon is judged, per cent, where it is no less than the model's.
fn no_less_than_the_model<'a>(parts: impl Iterator<Item = &'a HeldOutAnswer>) -> Option<f64> {
    let of = |part: &HeldOutAnswer| Some([part.past_alone_far, part.extended.horizons.get("1.0")?.value]);
    let judged: Vec<(f64, Option<[f64; 2]>)> = parts.map(|part| (part.share_of_motion, of(part))).collect();
    let [past, model] =
        [0, 1].map(|i| mean_by_motion(judged.iter().map(|(share, both)| (*share, both.map(|both| both[i])))));
    (past > 0.0 && past >= model).then_some(past)
}

/// Mean of `figure` over the parts held out that have one, by their share of the motion.
fn mean(answer: &Answer, figure: impl Fn(&HeldOutAnswer) -> Option<f64>) -> f64 {
    mean_by_motion(answer.fit.held_out.values().map(|part| (part.share_of_motion, figure(part))))
}

/// Mean VAF over the parts held out, `horizon` s ahead or of the free run, per cent.
fn mean_vaf(answer: &Answer, of: &dyn Fn(&HeldOutAnswer) -> &VafAnswer, horizon: Option<&str>) -> f64 {
    mean(answer, |part| match horizon {
        Some(key) => of(part).horizons.get(key).map(|vaf| vaf.value),
        None => Some(of(part).free_run),
    })
}

/// VAF on held-out data, before and `after` or one of them: 1 s ahead, where a part is long enough, and of the free run; 0.1 s
/// ahead where gusts leave nothing beyond that.
pub fn figures(answer: &Answer, after: bool) -> String {
    let vaf =
        |horizon| [mean_vaf(answer, &|h| &h.baseline, horizon), mean_vaf(answer, &|h| &h.extended, horizon)];
    let vaf = |horizon| vaf(horizon).map(in_percent);
    let ([near, near_after], [before, later]) = (vaf(Some("1.0")), vaf(None));
    let is_judged = answer.fit.held_out.values().any(|part| part.extended.horizons.contains_key("1.0"));
    let gusts = answer.fit.predicted == Some(Predicted::Near);
    let sections =
        if answer.fit.held_out.len() == 1 { "the section held out" } else { "sections held out in turn" };
    if gusts {
        let [short, short_after] = vaf(Some("0.1"));
        let figures = if after { format!("{short} before and {short_after} after") } else { short };
        let past = in_percent(mean(answer, |part| Some(part.past_alone)));
        let far = if after { near_after } else { near };
        let far = if is_judged { format!("; 1 s ahead {far}") } else { String::new() };
        format!("VAF on {sections}: 0.1 s ahead {figures}, of the past of the motion alone {past}{far}")
    } else {
        let ahead = match (is_judged, after) {
            (true, true) => {
                format!("1 s ahead {near} before and {near_after} after, free run {before} and {later}")
            }
            (true, false) => format!("1 s ahead {near}, free run {before}"),
            (false, true) => format!("free run {before} before and {later} after"),
            (false, false) => format!("free run {before}"),
        };
        format!("VAF on {sections}: {ahead}")
    }
}

/// A VAF with as many digits as what it leaves of a hundred takes: a smooth motion is told to its last thousandths by anything.
fn in_percent(vaf: f64) -> String {
    const MOST: f64 = 6.0;
    let decimals = (-(100.0 - vaf).log10()).ceil().clamp(1.0, MOST);
    format!("{vaf:.*} %", if vaf < 100.0 { decimals as usize } else { 1 })
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// "99 %"; never 0 or 100, which no data give.
pub fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p < 1.0 => "under 1 %".into(),
        p if p > 99.0 => "over 99 %".into(),
        p => format!("{p:.0} %"),
    }
}

/// A term with its parameters.
pub fn in_a_phrase(effect: &EffectAnswer) -> String {
    let Some(known) = find(&effect.id) else { return effect.equation.clone() };
    let parameters: Vec<String> = effect.parameters.iter().map(Estimate::to_string).collect();
    format!("{} ({}: {})", known.about().sentence, effect.id, parameters.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::answer::WithError;
    use crate::diagnosis::data_checks::fixture::{flight, normal};
    use crate::diagnosis::diagnose;
    use crate::diagnosis::fixture::flight_with;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn what_the_past_tells_as_well_is_not_the_inputs_doing() {
        let part = |share_of_motion, past_alone_far, ahead: Option<f64>| {
            let told = ahead.map(|value| ("1.0", WithError { value, standard_error: 1.0 }));
            let extended = VafAnswer { free_run: 0.0, horizons: told.into_iter().collect() };
            let (baseline, terms) = (VafAnswer::default(), Vec::new());
            HeldOutAnswer { baseline, extended, past_alone: 99.0, past_alone_far, share_of_motion, terms }
        };
        let told = |parts: &[HeldOutAnswer]| no_less_than_the_model(parts.iter());
        let both = told(&[part(0.7, 87.0, Some(84.0)), part(0.3, 60.0, Some(66.0))]).unwrap();
        assert!((both - 78.9).abs() < 1e-9, "{both}, and 78.6 by the model");
        assert_eq!(told(&[part(1.0, 83.0, Some(84.0))]), None);
        assert_eq!(told(&[part(0.5, 95.0, None), part(0.5, 20.0, Some(80.0))]), None);
        let alone = told(&[part(0.5, 95.0, None), part(0.5, 90.0, Some(80.0))]);
        assert_eq!(alone, Some(90.0), "the part that is not judged has no say");
        assert_eq!(told(&[]), None);
    }

    #[test]
    fn what_moves_by_something_beside_the_input_is_not_told_to_the_noise() {
        let said = |size: f64| {
            let mut random = Pcg64::seed_from_u64(7);
            let mut moment = 0.0;
            let mut wander = |_| {
                moment += size * normal(&mut random);
                moment
            };
            let walk: Vec<f64> = (0..flight(1, 0.0).u.len()).map(&mut wander).collect();
            let flown = flight_with(1, |k, _, _| walk[k]);
            diagnose(&[flown.recording()], None, &|_| {}).unwrap().answer
        };
        let [still, blown] = [0.0, 0.05].map(said);
        assert_eq!([still.verdict, blown.verdict], [Verdict::NoMismatch; 2]);
        assert!(still.summary.contains("down to the noise"), "{}", still.summary);
        assert!(blown.summary.contains("something beside the input moves the axis"), "{}", blown.summary);
    }

    #[test]
    fn a_figure_near_a_hundred_keeps_what_it_leaves() {
        let told = [0.0, 82.44, 99.8, 99.95, 99.998_71, 100.0, 99.999_999_99].map(in_percent);
        assert_eq!(told, ["0.0 %", "82.4 %", "99.8 %", "99.95 %", "99.999 %", "100.0 %", "100.000000 %"]);
    }
}
