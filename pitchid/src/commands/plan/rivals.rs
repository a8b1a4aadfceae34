//! The rivals that an experiment is to tell apart, named by the user or by the answer of a diagnosis.

use super::Arguments;
use crate::failure::Failure;
use experiment::search::SECTION_S;
use experiment::{Craft, Rivals, Test, Wishes};
use host_sim::Setting;
use serde::Deserialize;
use std::path::Path;
use sysid::files::read_text;

/// A usual test, in which the second rival learns to imitate the first: the paper's dwell, half of its amplitude.
const USUAL: Test = Test {
    dwell_s: [0.2, 0.8],
    amplitude_rad: 0.0075,
    section_s: SECTION_S,
    closed_loop_s: SECTION_S,
    trip_theta_rad: 0.4,
};

/// The rivals, and the craft without them.
pub fn asked(
    arguments: &Arguments,
    craft: Craft,
    wishes: &Wishes,
) -> Result<(Craft, Option<Rivals>), Failure> {
    let (first, other) = match (&arguments.rivals, &arguments.diagnosis) {
        (Some(specs), _) => match specs.as_slice() {
            [first, other] => (first.setting()?, other.id.clone()),
            _ => unreachable!("clap asks for two"),
        },
        (None, Some(path)) => of_answer(path)?,
        (None, None) => return Ok((craft, None)),
    };
    if first.entry().id == other {
        return Err(Failure::new(format!("{other} against itself"), "name two effects"));
    }
    let craft = craft.without(&[first.entry().id, &other]);
    let rivals = Rivals::new(first, &other, &craft, &USUAL, wishes.weather)?;
    Ok((craft, Some(rivals)))
}

/// What an answer has to hold.
#[derive(Deserialize)]
struct Answer {
    effects: Vec<Found>,
}

#[derive(Deserialize)]
struct Found {
    id: String,
    parameters: Vec<Value>,
    alternatives: Vec<Other>,
}

#[derive(Deserialize)]
struct Value {
    name: String,
    value: f64,
}

#[derive(Deserialize)]
struct Other {
    id: String,
}

/// The first effect of an answer that has a rival, and that rival.
fn of_answer(path: &Path) -> Result<(Setting, String), Failure> {
    let name = path.display();
    let text = read_text(path, "name what pitchid diagnose --json wrote")?;
    let answer: Answer = serde_json::from_str(&text).map_err(|error| {
        Failure::new(
            format!("{name}: not the answer of a diagnosis: {error}"),
            "name what pitchid diagnose --json wrote",
        )
    })?;
    let found = answer.effects.iter().find_map(|effect| Some((effect, effect.alternatives.first()?)));
    let (effect, other) = found.ok_or_else(|| {
        Failure::new(
            format!("{name}: no effect in it has a rival that the data could not rule out"),
            "leave out --diagnosis, or name two effects with --rivals",
        )
    })?;
    let values: Vec<(&str, f64)> =
        effect.parameters.iter().map(|value| (value.name.as_str(), value.value)).collect();
    Ok((Setting::new(&effect.id, &values)?, other.id.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rivals_of_an_answer_are_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let answer = r#"{"verdict": "ambiguous", "effects": [
            {"id": "gravity_stiffness", "parameters": [{"name": "G", "value": 0.4}], "alternatives": []},
            {"id": "servo_lag", "parameters": [{"name": "T", "value": 0.05}],
             "alternatives": [{"id": "gyro_lag", "probability": 0.4}]}]}"#;
        std::fs::write(file.path(), answer).unwrap();
        let (first, other) = of_answer(file.path()).unwrap();
        assert_eq!((first.entry().id, other.as_str()), ("servo_lag", "gyro_lag"));
        assert_eq!(first.parameters().map(|(_, value)| value).collect::<Vec<_>>(), [0.05]);
        std::fs::write(file.path(), r#"{"effects": []}"#).unwrap();
        assert!(of_answer(file.path()).unwrap_err().to_string().contains("no effect in it has a rival"));
        std::fs::write(file.path(), "t_s,u_rad\n").unwrap();
        assert!(of_answer(file.path()).unwrap_err().to_string().contains("not the answer of a diagnosis"));
    }
}
