//! Parameters of the plant, each with its source.

use rand::RngExt;
use serde::Serialize;
use std::f64::consts::TAU;

use crate::error::Error;
use crate::seeds::{Stream, generator};

/// Grey-box pitch plant (Riccardi, Panizza, Lovera, ERF 2014, eq. 9).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plant {
    /// Iyy, kg m²; 0.1705 was measured.
    pub inertia_kg_m2: f64,
    /// ∂M/∂q, N m s/rad; about −0.27 from blade-element theory for a 5 kg machine.
    pub dm_dq: f64,
    /// ∂M/∂u, N m/rad; about 23 from the same.
    pub dm_du: f64,
    /// Transport delay τ, s, any real number from 0; the paper adopts 0.06.
    pub delay_s: f64,
    /// Soft mount of the IMU; without it the IMU is fixed to the airframe.
    pub mount: Option<Mount>,
}

/// Vibration-damping mount of the IMU.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mount {
    /// k, N m/rad.
    pub k: f64,
    /// c, N m s/rad.
    pub c: f64,
    /// J, kg m².
    pub j: f64,
}

impl Mount {
    /// Mount of inertia `j` (kg m²) whose mode against a fixed airframe has `mode_hz` and damping ratio `zeta`:
    /// k = J ω², c = 2 ζ ω J.
    #[must_use]
    pub fn of_mode(mode_hz: f64, zeta: f64, j: f64) -> Self {
        let omega = TAU * mode_hz;
        Self { k: j * omega * omega, c: 2.0 * zeta * omega * j, j }
    }
}

impl Plant {
    /// The nominal plant: mount mode 14 Hz, damping ratio 0.3.
    #[must_use]
    pub const fn nominal() -> Self {
        Self {
            inertia_kg_m2: 0.1705,
            dm_dq: -0.27,
            dm_du: 23.0,
            delay_s: 0.06,
            mount: Some(Mount { k: 3.8689, c: 0.026_39, j: 5e-4 }),
        }
    }

    /// The same plant with the IMU fixed to the airframe.
    #[must_use]
    pub const fn rigid(self) -> Self {
        Self { mount: None, ..self }
    }

    /// A true plant around the nominal one, drawn by `seed`: ∂M/∂q and ∂M/∂u uniform within ±30 %, mount mode
    /// uniform in 8..25 Hz, damping ratio uniform in 0.1..0.7. Inertia, delay and J stay nominal.
    #[must_use]
    pub fn drawn(seed: u64) -> Self {
        let mut generator = generator(seed, Stream::Plant);
        let nominal = Self::nominal();
        Self {
            dm_dq: nominal.dm_dq * generator.random_range(0.7..1.3),
            dm_du: nominal.dm_du * generator.random_range(0.7..1.3),
            mount: Some(Mount::of_mode(
                generator.random_range(8.0..25.0),
                generator.random_range(0.1..0.7),
                5e-4,
            )),
            ..nominal
        }
    }

    /// Checks that the plant can exist.
    ///
    /// # Errors
    /// The first parameter that is no number or has an impossible sign or size.
    pub fn check(&self) -> Result<(), Error> {
        let positive = |name, found| check(name, found, found > 0.0, "a positive number");
        positive("inertia_kg_m2", self.inertia_kg_m2)?;
        let slow_enough = self.dm_dq.abs() < 1000.0 * self.inertia_kg_m2;
        check(
            "dM_dq_N_m_s",
            self.dm_dq,
            slow_enough,
            "below 1000/s times the inertia, for the integrator's step",
        )?;
        check("dM_du_N_m", self.dm_du, true, "a finite number")?;
        check("delay_s", self.delay_s, (0.0..=1.0).contains(&self.delay_s), "within 0 to 1 s")?;
        if let Some(Mount { k, c, j }) = self.mount {
            positive("mount_k_N_m", k)?;
            check("mount_c_N_m_s", c, c >= 0.0, "0 or positive")?;
            positive("mount_J_kg_m2", j)?;
            let fastest = (k / j).sqrt().max(c / j);
            check(
                "mount k/J",
                k / j,
                fastest < 1000.0,
                "a mode below 160 Hz, for the integrator's step of 1 ms",
            )?;
        }
        Ok(())
    }
}

fn check(name: &'static str, found: f64, legal: bool, expected: &'static str) -> Result<(), Error> {
    if found.is_finite() && legal { Ok(()) } else { Err(Error::Plant { name, found, expected }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nominal_mount_has_its_mode_at_14_hz_with_damping_0_3() {
        let expected = Mount::of_mode(14.0, 0.3, 5e-4);
        let found = Plant::nominal().mount.unwrap();
        assert!((found.k / expected.k - 1.0).abs() < 1e-3);
        assert!((found.c / expected.c - 1.0).abs() < 1e-3);
    }

    #[test]
    fn drawn_plants_stay_in_range_and_hang_on_the_seed() {
        for seed in 0..200 {
            let plant = Plant::drawn(seed);
            plant.check().unwrap();
            assert!((0.7..1.3).contains(&(plant.dm_dq / -0.27)));
            assert!((0.7..1.3).contains(&(plant.dm_du / 23.0)));
        }
        assert_eq!(Plant::drawn(3), Plant::drawn(3));
        assert_ne!(Plant::drawn(3), Plant::drawn(4));
    }

    #[test]
    fn an_impossible_plant_is_named() {
        let error = Plant { inertia_kg_m2: 0.0, ..Plant::nominal() }.check().unwrap_err();
        assert_eq!(error.to_string(), "plant: inertia_kg_m2 is 0; it must be a positive number");
        assert!(Plant { dm_dq: f64::NAN, ..Plant::nominal() }.check().is_err());
    }
}
