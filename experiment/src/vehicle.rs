//! The simulator's vehicle with the values of a model file.

use crate::Error;
use host_sim::{Mount, Plant, Setting};
use sysid::model::file::{EffectEntry, ModelFile};

/// The plant of `model`; `name` stands for its file in messages.
///
/// # Errors
/// A value that flying needs and the model does not have, a command that turns the craft the other way.
pub fn plant(model: &ModelFile, name: &str) -> Result<Plant, Error> {
    let given = &model.plant;
    let needed = |value: Option<f64>, key: &str| {
        value.ok_or_else(|| Error::Craft {
            message: format!("{name}: the plant has no {key}; it cannot be flown without"),
            help: format!("add a line {key} = NUMBER under [plant]"),
        })
    };
    let (dm_dq, dm_du) = (needed(given.dm_dq, "dM_dq_N_m_s")?, needed(given.dm_du, "dM_du_N_m")?);
    if dm_du < 0.0 {
        return Err(Error::Craft {
            message: format!("{name}: dM_du_N_m = {dm_du} is negative: the command turns the craft the other way than the board takes it to"),
            help: "turn the command round on the craft, read its recording with --column 'u_rad=-COLUMN' (COLUMN as the file names it) and \
                   identify again; for a plan alone write dM_du_N_m without the minus"
                .into(),
        });
    }
    let mount = match (given.mount_k, given.mount_c, given.mount_j) {
        (Some(k), Some(c), Some(j)) => Some(Mount { k, c, j }),
        _ => None,
    };
    Ok(Plant {
        inertia_kg_m2: given.inertia_kg_m2,
        dm_dq,
        dm_du,
        delay_s: needed(given.delay_s, "delay_s")?,
        mount,
    })
}

/// The effects of `model`. Terms without a name come first: there they see the command before any effect has changed it.
///
/// # Errors
/// An effect that the simulator does not know, or not with these values.
pub fn settings(model: &ModelFile) -> Result<Vec<Setting>, Error> {
    let (nameless, named): (Vec<_>, Vec<_>) = model.effects.iter().partition(|entry| entry.shape.is_some());
    let setting = |entry: &EffectEntry| {
        let values: Vec<(&str, f64)> = entry.parameters.iter().map(|(name, v)| (name.as_str(), *v)).collect();
        match &entry.shape {
            Some(shape) => Setting::unlisted(shape, &values),
            None => Setting::new(&entry.id, &values),
        }
    };
    nameless.into_iter().chain(named).map(|entry| Ok(setting(entry)?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_without_what_flying_needs_is_refused() {
        let text = "[plant]\ninertia_kg_m2 = 0.2\ndM_du_N_m = 20.0\ndelay_s = 0.05\n";
        let model = sysid::model::file::parse("m.toml", text, None, &[]).unwrap();
        assert!(plant(&model, "m.toml").unwrap_err().to_string().contains("dM_dq_N_m_s"));
        let model =
            sysid::model::file::parse("m.toml", &format!("{text}dM_dq_N_m_s = -0.3\n"), None, &[]).unwrap();
        let plant = plant(&model, "m.toml").unwrap();
        assert_eq!((plant.dm_dq, plant.dm_du, plant.delay_s, plant.mount), (-0.3, 20.0, 0.05, None));
    }

    #[test]
    fn a_command_that_turns_the_other_way_is_told() {
        let text = "[plant]\ninertia_kg_m2 = 0.2\ndM_du_N_m = -20.0\ndM_dq_N_m_s = -0.3\ndelay_s = 0.05\n";
        let model = sysid::model::file::parse("m.toml", text, None, &[]).unwrap();
        assert!(plant(&model, "m.toml").unwrap_err().to_string().contains("the other way"));
    }
}
