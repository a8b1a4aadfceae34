//! Opens the truth and holds the answer against it.

use crate::failure::Failure;
use crate::{format, text};
use serde::Deserialize;
use std::path::Path;
use sysid::diagnosis::answer::{Answer, Verdict};
use sysid::estimate::Estimate;
use sysid::files;

/// What a truth file says, as far as it is compared.
#[derive(Deserialize)]
struct Truth {
    effects: Vec<TrueEffect>,
    plant: TruePlant,
}

#[derive(Deserialize)]
struct TrueEffect {
    id: String,
    parameters: Vec<TrueParameter>,
}

#[derive(Deserialize)]
struct TrueParameter {
    name: String,
    unit: String,
    value: f64,
}

#[derive(Deserialize)]
struct TruePlant {
    dm_dq: f64,
    dm_du: f64,
}

/// Reads the truth and says whether the answer was right, parameter by parameter.
pub fn reveal(path: &Path, answer: &Answer) -> Result<String, Failure> {
    let truth: Truth = serde_json::from_value(truth(path)?).map_err(|e| unreadable(path, &e))?;
    Ok(compare(&truth, answer))
}

/// What the truth file says.
pub fn truth(path: &Path) -> Result<serde_json::Value, Failure> {
    let json = files::read_text(path, AGAIN)?;
    serde_json::from_str(&json).map_err(|e| unreadable(path, &e))
}

const AGAIN: &str = "run the demonstration again";

fn unreadable(path: &Path, error: &serde_json::Error) -> Failure {
    Failure::new(format!("{}: cannot be read: {error}", path.display()), AGAIN)
}

fn compare(truth: &Truth, answer: &Answer) -> String {
    let concealed: Vec<String> = truth.effects.iter().map(in_words).collect();
    let mut told = String::from("\n");
    told.push_str(&text::paragraph(&format!(
        "The truth, opened only now: {}. {}",
        concealed.join(" and "),
        judged(truth, answer)
    )));
    let mut rows = Vec::new();
    for effect in &truth.effects {
        let found = answer.effects.iter().find(|e| e.id == effect.id).map_or(&[][..], |e| &e.parameters);
        rows.extend(effect.parameters.iter().filter_map(|p| row(found, &p.name, p.value)));
    }
    let plant = &answer.told().parameters;
    rows.extend(row(plant, "dM_dq", truth.plant.dm_dq));
    rows.extend(row(plant, "dM_du", truth.plant.dm_du));
    if !rows.is_empty() {
        told.push_str(&text::table(
            &["parameter", "unit", "truth", "found", "95 % interval", "truth is"],
            rows,
            2,
        ));
    }
    told
}

/// Right, wrong, or undecided: against the effects, not against the wording.
fn judged(truth: &Truth, answer: &Answer) -> String {
    let mut concealed: Vec<&str> = truth.effects.iter().map(|e| e.id.as_str()).collect();
    let mut named: Vec<&str> = answer.effects.iter().map(|e| e.id.as_str()).collect();
    let rivals = || answer.effects.iter().flat_map(|e| &e.alternatives).map(|a| a.id.as_str());
    concealed.sort_unstable();
    named.sort_unstable();
    let among = concealed.iter().all(|id| named.contains(id) || rivals().any(|r| r == *id));
    match answer.verdict {
        Verdict::Named if named == concealed => "The diagnosis was right.".into(),
        Verdict::Ambiguous if among => {
            "The diagnosis did not decide, and the truth is among its candidates.".into()
        }
        Verdict::Named if among => "The diagnosis found it, and added something that is not there.".into(),
        Verdict::NoMismatch | Verdict::NotExcited | Verdict::Unlisted => {
            "The diagnosis did not find it.".into()
        }
        _ => "The diagnosis was wrong.".into(),
    }
}

fn in_words(effect: &TrueEffect) -> String {
    let parameters: Vec<String> = effect
        .parameters
        .iter()
        .map(|p| {
            format!("{} = {} {}", p.name, format::plain(p.value), format::unit(&p.unit)).trim_end().to_owned()
        })
        .collect();
    format!("{} ({})", effect.id, parameters.join(", "))
}

/// The estimate of that name against its true value.
fn row(estimates: &[Estimate], name: &str, truth: f64) -> Option<Vec<String>> {
    let found = estimates.iter().find(|e| e.name == name)?;
    let shown = format::estimate(found);
    let [low, high] = found.ci95;
    let place = if (low..=high).contains(&truth) { "inside" } else { "outside" };
    let unit = format::unit(&found.unit).to_owned();
    Some(vec![name.to_owned(), unit, format::plain(truth), shown.value, shown.interval, place.into()])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: &str = r#"{"effects": [{"id": "coulomb_friction", "parameters": [{"name": "Mc", "unit": "N m",
        "value": 0.1}]}], "plant": {"dm_dq": -0.27, "dm_du": 23.0}, "seed": 1}"#;

    fn told(verdict: Verdict, effects: &[(&str, f64)], rivals: &[&str]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.json");
        std::fs::write(&path, TRUTH).unwrap();
        let text = reveal(&path, &crate::report::fixture::answer(verdict, effects, rivals)).unwrap();
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn right_is_right_and_the_value_is_held_against_its_interval() {
        let text = told(Verdict::Named, &[("coulomb_friction", 0.1)], &[]);
        assert!(text.contains("was right") && text.contains("inside"), "{text}");
        let text = told(Verdict::Named, &[("coulomb_friction", 0.2)], &[]);
        assert!(text.contains("was right") && text.contains("outside"), "{text}");
    }

    #[test]
    fn wrong_is_said_to_be_wrong() {
        assert!(told(Verdict::Named, &[("servo_lag", 0.1)], &[]).contains("was wrong"));
        assert!(told(Verdict::NoMismatch, &[], &[]).contains("did not find it"));
        let two = [("coulomb_friction", 0.1), ("servo_lag", 0.1)];
        assert!(told(Verdict::Named, &two, &[]).contains("added something"));
    }

    #[test]
    fn undecided_is_neither() {
        let text = told(Verdict::Ambiguous, &[("servo_deadband", 0.1)], &["coulomb_friction"]);
        assert!(text.contains("among its candidates"), "{text}");
        assert!(told(Verdict::Ambiguous, &[("servo_lag", 0.1)], &["gyro_lag"]).contains("was wrong"));
    }

    #[test]
    fn a_truth_that_cannot_be_read_is_said_to_be_so() {
        let answer = crate::report::fixture::answer(Verdict::Named, &[], &[]);
        assert!(
            reveal(Path::new("/nowhere/truth.json"), &answer).unwrap_err().to_string().contains("truth.json")
        );
    }
}
