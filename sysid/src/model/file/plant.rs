//! `[plant]` of a model file, and that of an axis.

use super::PlantSection;
use crate::error::{Error, ErrorKind};
use crate::legal::Legal;
use crate::toml_file::{Source, Table};

/// Keys with what is legal.
pub(super) const KEYS: [(&str, Legal); 7] = [
    ("inertia_kg_m2", Legal::positive("kg m²")),
    ("delay_s", Legal::new(0.0, 10.0, "s")),
    ("dM_dq_N_m_s", Legal::any("N m s/rad")),
    ("dM_du_N_m", Legal::any("N m per unit of the input")),
    ("mount_k_N_m", Legal::positive("N m/rad")),
    ("mount_c_N_m_s", Legal::positive("N m s/rad")),
    ("mount_J_kg_m2", Legal::positive("kg m²")),
];
/// Where those of the mount begin.
const MOUNT: usize = 4;

/// The plant of a section.
pub(super) fn read(source: &Source<'_>, table: &Table<'_>) -> Option<PlantSection> {
    table.only(&KEYS.map(|(key, _)| key));
    let [_, rest @ ..] = KEYS;
    let inertia = table.needed(KEYS[0].0, &KEYS[0].1);
    let [delay_s, dm_dq, dm_du, mount_k, mount_c, mount_j] =
        rest.map(|(key, legal)| table.number(key, &legal));
    let mount = KEYS[MOUNT..].iter().filter_map(|(key, _)| table.get(key));
    let given: Vec<_> = mount.map(|entry| (entry.line, entry.key)).collect();
    if let Some((line, key)) = given.first().filter(|_| given.len() < KEYS.len() - MOUNT) {
        let keys: Vec<&str> = given.iter().map(|(_, key)| *key).collect();
        let advice = "add what is missing, or delete these lines for an IMU that is rigidly fixed";
        let all = "mount_k_N_m, mount_c_N_m_s and mount_J_kg_m2, all three or none";
        source.expect(*line, key, format!("a mount with only {}", keys.join(", ")), all, advice);
    }
    Some(PlantSection { inertia_kg_m2: inertia?, delay_s, dm_dq, dm_du, mount_k, mount_c, mount_j })
}

/// Refuses a plant that could not be read back.
pub(super) fn check(plant: &PlantSection) -> Result<(), Error> {
    let PlantSection { inertia_kg_m2, delay_s, dm_dq, dm_du, mount_k, mount_c, mount_j } = *plant;
    let values = [Some(inertia_kg_m2), delay_s, dm_dq, dm_du, mount_k, mount_c, mount_j];
    let wrong = |((_, legal), value): &(&(&str, Legal), Option<f64>)| value.is_some_and(|v| !legal.holds(v));
    match KEYS.iter().zip(values).find(wrong) {
        Some(((key, legal), value)) => {
            let found = format!("found {}", value.unwrap_or(f64::NAN));
            let advice = "do not write a model that did not converge";
            Err(Error::new(ErrorKind::Model, found, advice).in_column(*key).expecting(legal.to_string()))
        }
        None => Ok(()),
    }
}
