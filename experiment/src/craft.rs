//! What is known of a craft before the experiment: a model with what it leaves open, or nothing but size and mass.
//!
//! From size and mass, by blade-element and momentum theory in hover (Leishman, *Principles of Helicopter Aerodynamics*, 2nd
//! ed., ch. 2 and 3) and the derivatives of Riccardi, Panizza, Lovera (ERF 2014), m the mass, d the arm, g gravity:
//!
//! ```text
//! Iyy    = c₁ m d²               c₁ in 0.14..0.28     (0.198 on the paper's machine)
//! ∂M/∂u  = s m g d / 4           s in 3..9 per rad    (relative change of a rotor's thrust with its blade pitch; 4.5)
//! ∂M/∂q  = −c₂ m g d²            c₂ in 0.013..0.075 s/m  (Clα / (16 (CT/σ) ΩR): CT/σ 0.06..0.14, ΩR 80..200 m/s; 0.032)
//! τ                              0.05..0.1 s
//! ```
//!
//! each drawn evenly on a scale of factors (τ on one of differences), independent of the others. From a model, every value that
//! has an interval is drawn from the normal distribution with that 95 % interval; the others are what they are.

use crate::vehicle::{plant, settings};
use crate::{Error, Rng};
use host_sim::{Plant, Setting};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use sysid::model::file::{Interval, ModelFile, PlantSection};

const GRAVITY: f64 = 9.81;
/// Ranges of the factors above.
const INERTIA: [f64; 2] = [0.14, 0.28];
const THRUST_SLOPE: [f64; 2] = [3.0, 9.0];
const DAMPING: [f64; 2] = [0.013, 0.075];
const DELAY_S: [f64; 2] = [0.05, 0.1];
/// Half a 95 % interval in standard deviations.
const NORMAL_95: f64 = 1.96;
/// Least share of its middle value that a drawn value has: no gain changes its sign.
const LEAST_SHARE: f64 = 0.1;

/// What is known of a craft.
#[derive(Clone, Debug)]
pub struct Craft {
    /// The model in the middle of what is known.
    pub model: ModelFile,
    known: Known,
    middle: Plant,
    effects: Vec<Setting>,
}

#[derive(Clone, Copy, Debug)]
enum Known {
    Model,
    SizeAndMass { mass_kg: f64, arm_m: f64 },
}

impl Craft {
    /// From a model; `name` stands for its file in messages.
    ///
    /// # Errors
    /// A model that lacks what flying needs.
    pub fn of_model(model: ModelFile, name: &str) -> Result<Self, Error> {
        let (middle, effects) = (plant(&model, name)?, settings(&model)?);
        middle.check()?;
        Ok(Self { model, known: Known::Model, middle, effects })
    }

    /// From the mass in kg and the distance of the rotors' hubs from the pitch axis in m.
    ///
    /// # Errors
    /// A mass or an arm that no craft of this kind has.
    pub fn of_size_and_mass(mass_kg: f64, arm_m: f64) -> Result<Self, Error> {
        for (name, value, unit, [low, high]) in
            [("mass", mass_kg, "kg", [0.05, 100.0]), ("arm", arm_m, "m", [0.03, 3.0])]
        {
            if !(low..=high).contains(&value) {
                let message =
                    format!("{name}: {value} {unit}; a craft of this kind has {low} to {high} {unit}");
                let help = format!("give the {name} in {unit}");
                return Err(Error::Craft { message, help });
            }
        }
        let middle = Share { inertia: 0.5, slope: 0.5, damping: 0.5, delay: 0.5 }.plant(mass_kg, arm_m);
        let section = PlantSection {
            inertia_kg_m2: middle.inertia_kg_m2,
            delay_s: Some(middle.delay_s),
            dm_dq: Some(middle.dm_dq),
            dm_du: Some(middle.dm_du),
            mount_k: None,
            mount_c: None,
            mount_j: None,
        };
        let model = ModelFile { plant: section, effects: Vec::new(), intervals: Default::default() };
        Ok(Self { model, known: Known::SizeAndMass { mass_kg, arm_m }, middle, effects: Vec::new() })
    }

    /// A craft as it may be, drawn by `seed`.
    #[must_use]
    pub fn drawn(&self, seed: u64) -> Plant {
        let mut random = Rng::seed_from_u64(seed);
        match self.known {
            Known::SizeAndMass { mass_kg, arm_m } => {
                let mut share = || random.random_range(0.0..1.0);
                let share = Share { inertia: share(), slope: share(), damping: share(), delay: share() };
                share.plant(mass_kg, arm_m)
            }
            Known::Model => {
                let middle = self.middle;
                let mut of = |key: &str, middle: f64| {
                    let Some(Interval { ci95: [low, high] }) = self.model.intervals.get(key) else {
                        return middle;
                    };
                    let drawn = Normal::new(middle, (high - low) / (2.0 * NORMAL_95));
                    let drawn = drawn.map_or(middle, |normal| normal.sample(&mut random));
                    // measured from zero outwards, on the side of the middle
                    (drawn * middle.signum()).max(LEAST_SHARE * middle.abs()).copysign(middle)
                };
                Plant {
                    dm_dq: of("dM_dq_N_m_s", middle.dm_dq),
                    dm_du: of("dM_du_N_m", middle.dm_du),
                    delay_s: of("delay_s", middle.delay_s),
                    ..middle
                }
            }
        }
    }

    /// The plant in the middle.
    #[must_use]
    pub const fn middle(&self) -> Plant {
        self.middle
    }

    /// The effects that its model has.
    #[must_use]
    pub fn effects(&self) -> &[Setting] {
        &self.effects
    }

    /// The same craft without the effects of these names, for which others stand in.
    #[must_use]
    pub fn without(mut self, ids: &[&str]) -> Self {
        self.effects.retain(|effect| !ids.contains(&effect.entry().id));
        self.model.effects.retain(|effect| !ids.contains(&effect.id.as_str()));
        self
    }
}

/// Where in its range each factor lies, 0 to 1.
struct Share {
    inertia: f64,
    slope: f64,
    damping: f64,
    delay: f64,
}

impl Share {
    fn plant(&self, mass_kg: f64, arm_m: f64) -> Plant {
        let between = |[low, high]: [f64; 2], share: f64| low * (high / low).powf(share);
        let weight = mass_kg * GRAVITY;
        Plant {
            inertia_kg_m2: between(INERTIA, self.inertia) * mass_kg * arm_m * arm_m,
            dm_dq: -between(DAMPING, self.damping) * weight * arm_m * arm_m,
            dm_du: between(THRUST_SLOPE, self.slope) * weight * arm_m / 4.0,
            delay_s: DELAY_S[0] + self.delay * (DELAY_S[1] - DELAY_S[0]),
            mount: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's machine: 5 kg, d = 0.415 m.
    #[test]
    fn the_papers_machine_lies_within_what_its_size_and_mass_say() {
        let craft = Craft::of_size_and_mass(5.0, 0.415).unwrap();
        let all: Vec<Plant> = (0..500).map(|seed| craft.drawn(seed)).collect();
        let paper = Plant::nominal();
        for value in [
            |p: &Plant| p.inertia_kg_m2,
            |p: &Plant| p.dm_dq.abs(),
            |p: &Plant| p.dm_du,
            |p: &Plant| p.delay_s,
        ] {
            let below = all.iter().filter(|plant| value(plant) < value(&paper)).count();
            assert!((25..475).contains(&below), "{below} of 500 lie below {}", value(&paper));
        }
    }

    #[test]
    fn a_model_is_drawn_within_its_intervals_and_keeps_its_signs() {
        let text = "[plant]\ninertia_kg_m2 = 0.17\ndelay_s = 0.06\ndM_dq_N_m_s = -0.3\ndM_du_N_m = 23.0\n\
                    [interval.dM_du_N_m]\nci95 = [21.0, 25.0]\n[interval.dM_dq_N_m_s]\nci95 = [-0.9, 0.3]\n";
        let model = sysid::model::file::parse("m.toml", text, None, &[]).unwrap();
        let craft = Craft::of_model(model, "m.toml").unwrap();
        let all: Vec<Plant> = (0..1000).map(|seed| craft.drawn(seed)).collect();
        let inside = all.iter().filter(|plant| (21.0..25.0).contains(&plant.dm_du)).count();
        assert!((930..970).contains(&inside), "{inside}");
        assert!(all.iter().all(|plant| plant.dm_dq < 0.0 && plant.delay_s == 0.06 && plant.dm_du > 0.0));
    }

    #[test]
    fn sizes_that_no_craft_has_are_refused() {
        assert!(Craft::of_size_and_mass(5000.0, 0.4).unwrap_err().to_string().contains("mass: 5000 kg"));
        assert!(Craft::of_size_and_mass(5.0, f64::NAN).is_err());
    }
}
