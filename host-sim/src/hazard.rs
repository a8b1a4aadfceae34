//! A test that goes wrong: a craft far from the one that the controller was tuned for, physics concealed in it, gusts, and a fault.
//!
//! | drawn | range |
//! | --- | --- |
//! | Iyy | 0.5 to 2 times the nominal, log-uniform |
//! | ∂M/∂u | so that ∂M/∂u / Iyy is 0.6 to 1.5 times the nominal, log-uniform |
//! | ∂M/∂q | −1 to +0.1 N m s/rad: from well damped to unstable |
//! | delay | 0 to 0.1 s |
//! | centre of gravity | in three of ten above the pivot: G from 0 to −half of what the controller's stiffness holds |
//! | physics | each effect that the simulator knows in turn, log-uniform in its range, signs by lot; every fifth without |
//! | air | its four kinds; σ 0.005 to 0.12 N m, log-uniform; in three of ten one to three gusts of 2 to 8 s, 1.5 to 3 times as strong |
//! | excitation | the paper's campaigns and amplitudes |
//! | limit | 0.2 to 0.4 rad |
//! | fault | in three of ten one of the sensors, in one of ten one of the servo, from 1 tick to 2 s |

use estimator_core::constants::AMPLITUDES_RAD;
use estimator_core::supervisor::SupervisorConfig;
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::Air;
use crate::aircraft::SAMPLE_PERIOD_S;
use crate::effects::{Setting, every};
use crate::error::Error;
use crate::fault::{Failing, FailingVehicle, Fault};
use crate::flight::{BackgroundTruth, vehicle};
use crate::plant::{Mount, Plant};
use crate::scenario::Scenario;
use crate::seeds::{Stream, generator};

/// Stiffness that the controller gives the nominal craft, as a share of ∂M/∂u: its gain Kp.
const ANGLE_GAIN: f64 = 0.06;

/// One such test.
#[derive(Clone, Debug)]
pub struct Hazard {
    /// What is flown.
    pub scenario: Scenario,
    /// The air it is flown in.
    pub background: BackgroundTruth,
    /// What breaks.
    pub failing: Option<Failing>,
}

impl Hazard {
    /// The test of `number` out of those of `seed`.
    ///
    /// # Errors
    /// None that a caller could cause: the campaigns drawn exist.
    pub fn drawn(seed: u64, number: u64) -> Result<Self, Error> {
        let own = seed.wrapping_mul(1_000_003).wrapping_add(number);
        let mut random = generator(own, Stream::Choice);
        let amplitude = AMPLITUDES_RAD[random.random_range(0..AMPLITUDES_RAD.len())];
        let mut scenario = Scenario::campaign(random.random_range(1..=4), amplitude, own)?;
        scenario.plant = plant(&mut random);
        let trip: f32 = random.random_range(0.2..0.4);
        scenario.supervisor = SupervisorConfig {
            trip_theta_rad: trip,
            release_theta_rad: trip.min(0.3) / 2.0,
            ..SupervisorConfig::default()
        };
        let mut effects = Vec::new();
        if !number.is_multiple_of(5) {
            let turn = number as usize - number as usize / 5 - 1;
            let entry = every().nth(turn % every().count());
            effects.extend(entry.map(|entry| entry.drawn(&mut random)));
        }
        if random.random_bool(0.3) {
            let most = 0.5 * ANGLE_GAIN * scenario.plant.dm_du;
            let above = Setting::new("gravity_stiffness", &[("G", -random.random_range(0.0..most))])?;
            effects.retain(|effect: &Setting| effect.entry().id != "gravity_stiffness");
            effects.push(above);
        }
        scenario.conceal(effects);
        scenario.air = Air::ALL[random.random_range(0..Air::ALL.len())];
        if random.random_bool(0.3) {
            scenario.gusts = gusts(&mut random);
        }
        let sigma = log_uniform(&mut random, 0.005, 0.12);
        let [omega, zeta] = [random.random_range(3.0..7.0), random.random_range(0.3..0.6)];
        let background = BackgroundTruth::of_strength(scenario.air, sigma, omega, zeta);
        let failing = failing(&mut random, number);
        Ok(Self { scenario, background, failing })
    }

    /// The vehicle, at rest.
    ///
    /// # Errors
    /// A plant that cannot be.
    pub fn vehicle(&self) -> Result<FailingVehicle, Error> {
        Ok(FailingVehicle::new(vehicle(&self.scenario, self.background)?, self.failing))
    }
}

fn log_uniform(random: &mut Pcg64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.random())
}

fn plant(random: &mut Pcg64) -> Plant {
    let nominal = Plant::nominal();
    let inertia_kg_m2 = nominal.inertia_kg_m2 * log_uniform(random, 0.5, 2.0);
    let authority = nominal.dm_du / nominal.inertia_kg_m2 * log_uniform(random, 0.6, 1.5);
    let mode = Mount::of_mode(random.random_range(8.0..25.0), random.random_range(0.1..0.7), 5e-4);
    Plant {
        inertia_kg_m2,
        dm_dq: random.random_range(-1.0..0.1),
        dm_du: authority * inertia_kg_m2,
        delay_s: random.random_range(0.0..0.1),
        mount: random.random_bool(0.75).then_some(mode),
    }
}

fn gusts(random: &mut Pcg64) -> Vec<([f64; 2], f64)> {
    let count = random.random_range(1..=3);
    let gust = |_| {
        let from = random.random_range(2.0..110.0);
        ([from, from + random.random_range(2.0..8.0)], random.random_range(1.5..3.0))
    };
    (0..count).map(gust).collect()
}

fn failing(random: &mut Pcg64, number: u64) -> Option<Failing> {
    let share = 0.02 * f64::from(random.random_range(0_u32..=30));
    let faults = [
        Fault::SamplesLost,
        Fault::SamplesPatchy,
        Fault::SamplesLate { ticks: random.random_range(1..=4) },
        Fault::RateFrozen,
        Fault::AngleFrozen,
        Fault::RateNotFinite,
        Fault::AngleInfinite,
        Fault::Wild { q_rad_s: log_uniform(random, 0.5, 1e3) as f32, theta_rad: 0.0 },
        Fault::Wild { q_rad_s: 0.0, theta_rad: -log_uniform(random, 0.1, 1e3) as f32 },
        Fault::AngleOff { rad: random.random_range(-0.1..0.1) },
        Fault::ServoStuck,
        Fault::ServoNeutral,
        Fault::ServoWeak { share: share as f32 },
        Fault::CommandsPatchy,
    ];
    let of_sensors = faults.iter().filter(|fault| fault.is_of_sensors()).count();
    let place = match number % 10 {
        1 | 4 | 7 => random.random_range(0..of_sensors),
        9 => random.random_range(of_sensors..faults.len()),
        _ => return None,
    };
    let from = random.random_range(50_u32..6000);
    let length_s = log_uniform(random, SAMPLE_PERIOD_S, 2.0);
    Some(Failing { fault: faults[place], from, to: from + 1 + (length_s / SAMPLE_PERIOD_S) as u32 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_effect_and_every_fault_comes_up_and_every_craft_can_be() {
        let (mut effects, mut faults, mut without) = (BTreeSet::new(), BTreeSet::new(), 0);
        for number in 0..1000 {
            let hazard = Hazard::drawn(1, number).unwrap();
            hazard.vehicle().unwrap();
            effects.extend(hazard.scenario.effects.iter().map(|effect| effect.entry().id));
            faults.extend(hazard.failing.map(|failing| failing.fault.told()));
            without += usize::from(hazard.failing.is_none());
        }
        assert_eq!(effects.len(), every().count());
        assert_eq!(faults.len(), 13);
        assert_eq!(without, 600);
    }

    #[test]
    fn a_hazard_hangs_on_seed_and_number() {
        let described = |seed, number| format!("{:?}", Hazard::drawn(seed, number).unwrap());
        assert_eq!(described(1, 17), described(1, 17));
        assert_ne!(described(1, 17), described(2, 17));
        assert_ne!(described(1, 17), described(1, 18));
    }
}
