//! Model files of several axes.

use super::{AXES, ModelFile};
use crate::error::Error;

/// What an interval's `key` says of `axis`: the key without the axis' name; `None` of another axis.
pub(super) fn key_of<'k>(key: &'k str, axis: &str) -> Option<&'k str> {
    match key.split_once('.') {
        Some((of, own)) if AXES.contains(&of) => (of == axis).then_some(own),
        _ => Some(key),
    }
}

/// One file for the models of several axes, each under one of the names of [`AXES`].
///
/// # Errors
/// As [`ModelFile::to_toml`].
pub fn to_toml(models: &[(&str, &ModelFile)]) -> Result<String, Error> {
    let mut whole = String::new();
    for (axis, model) in models {
        for line in model.to_toml()?.lines() {
            let interval = line.strip_prefix("[interval.").and_then(|rest| rest.strip_suffix(']'));
            let line = match (line, interval) {
                ("[plant]", _) => format!("[{axis}]"),
                ("[[effect]]", _) => format!("[[effect]]\naxis = \"{axis}\""),
                (_, Some(key)) => format!("[interval.\"{axis}.{}\"]", key.trim_matches('"')),
                (line, None) => line.to_owned(),
            };
            whole.push_str(&line);
            whole.push('\n');
        }
        whole.push('\n');
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::super::{KnownEffect, parse};
    use super::*;
    use crate::legal::Legal;

    const TWO: &str = "[plant]\ninertia_kg_m2 = 0.01\n[roll]\ninertia_kg_m2 = 0.02\ndM_du_N_m = 3\n\
        [[effect]]\nid = \"servo_lag\"\nT = 0.05\n[[effect]]\naxis = \"roll\"\nid = \"trim_offset\"\nM0 = 0.1\n\
        [interval.\"roll.trim_offset.M0\"]\nci95 = [0.05, 0.15]\n";

    fn table() -> [KnownEffect; 2] {
        [("servo_lag", "T"), ("trim_offset", "M0")].map(|(id, parameter)| KnownEffect {
            id,
            shape: None,
            parameters: vec![(parameter, Legal::any(""))],
        })
    }

    fn of(text: &str, axis: Option<&str>) -> Result<ModelFile, Error> {
        parse("m.toml", text, axis, &table())
    }

    #[test]
    fn an_axis_has_its_own_plant_and_effects_or_those_of_all() {
        let roll = of(TWO, Some("roll")).unwrap();
        assert_eq!((roll.plant.inertia_kg_m2, roll.effects.len()), (0.02, 2));
        assert_eq!(roll.intervals["trim_offset.M0"].ci95, [0.05, 0.15]);
        for axis in [None, Some("yaw"), Some("pitch")] {
            let other = of(TWO, axis).unwrap();
            assert_eq!((other.plant.inertia_kg_m2, other.effects.len()), (0.01, 1));
            assert!(other.intervals.is_empty());
        }
    }

    #[test]
    fn what_is_written_of_several_reads_back() {
        let [roll, yaw] = ["roll", "yaw"].map(|axis| of(TWO, Some(axis)).unwrap());
        let text = to_toml(&[("roll", &roll), ("yaw", &yaw)]).unwrap();
        assert_eq!(of(&text, Some("roll")).unwrap(), roll, "{text}");
        assert_eq!(of(&text, Some("yaw")).unwrap(), yaw, "{text}");
        let refused = of(&text, Some("pitch")).unwrap_err().to_string();
        assert!(refused.contains("no plant of pitch, only [roll], [yaw]"), "{refused}");
    }

    #[test]
    fn an_axis_that_is_none_is_refused_with_its_line() {
        let refused = of(&TWO.replace("axis = \"roll\"", "axis = \"rol\""), None).unwrap_err();
        assert_eq!(refused.line, Some(10), "{refused}");
        assert!(refused.to_string().contains("roll, pitch, yaw"), "{refused}");
    }

    #[test]
    fn an_effect_of_all_axes_and_of_one_of_them_are_the_same_twice() {
        let twice =
            TWO.replace("\"trim_offset\"\nM0", "\"servo_lag\"\nT").replace("trim_offset.M0", "servo_lag.T");
        let refused = of(&twice, Some("yaw")).unwrap_err();
        assert_eq!(refused.line, Some(11), "{refused}");
        assert!(refused.to_string().contains("servo_lag a second time; the first is on line 6"), "{refused}");
        let apart =
            twice.replace("[[effect]]\nid = \"servo_lag\"", "[[effect]]\naxis = \"yaw\"\nid = \"servo_lag\"");
        assert_eq!(of(&apart, Some("yaw")).unwrap().effects.len(), 1);
    }
}
