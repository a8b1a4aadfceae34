//! One test that the board can fly: the same excitation in sections I to III, the closed loop in IV.

use crate::Error;
use crate::craft::Craft;
use estimator_core::Section;
use estimator_core::plan::PlanConfig;
use estimator_core::supervisor::SupervisorConfig;
use host_sim::flight::BackgroundTruth;
use host_sim::recording::Row;
use host_sim::{Air, Background, Flight, Plant, Scenario, Setting, air_of, fly_in};
use serde::Serialize;
use sysid::recording::{ReadOptions, Recording, parse};

/// Angle of release as a share of that of the trip: the default's.
const RELEASE: f32 = 0.375;
/// The paper's amplitude, rad, and ∂M/∂u / Iyy of its machine, 1/s² per rad: together the motion in which the air is sized.
const USUAL_AMPLITUDE_RAD: f64 = 0.015;
const USUAL_GAIN: f64 = 23.0 / 0.1705;

/// Sections of the test in which it is sized, s.
const SIZED_S: f32 = 10.0;

/// What the air does to the craft.
#[derive(Clone, Copy, Debug, Default)]
pub struct Weather {
    /// How strong: what it leaves of the VAF of a true model in a test that moves the craft as the paper's moved theirs.
    pub background: Background,
    /// Of which kind.
    pub air: Air,
}

/// One test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Test {
    /// Shortest and longest dwell of the PRBS, s.
    pub dwell_s: [f32; 2],
    /// Amplitude of the PRBS, rad.
    pub amplitude_rad: f32,
    /// Length of each of the sections I to III, s.
    pub section_s: f32,
    /// Length of section IV, in which the pilot leads and the controller follows, s; 0 where it is left out.
    pub closed_loop_s: f32,
    /// Angle at which the supervisor takes over, rad.
    pub trip_theta_rad: f32,
}

/// A flight of a test, reduced to what a plan foretells.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    /// Largest measured angle, rad.
    pub angle_rad: f64,
    /// The same of section IV, where it was flown.
    pub closed_loop_angle_rad: f64,
    /// Largest measured rate, rad/s.
    pub rate_rad_s: f64,
    /// Of the samples of sections I to III, those in which the supervisor held the craft.
    pub overridden: f64,
    /// Length of the whole test, s.
    pub length_s: f64,
    /// Whether the supervisor broke the test off.
    pub broken_off: bool,
}

impl Test {
    /// Length without recoveries, s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        let PlanConfig { lead_in_s, section_s, pause_s, closed_loop_s } = self.sections();
        f64::from(lead_in_s + 3.0 * (section_s + pause_s) + closed_loop_s)
    }

    fn sections(&self) -> PlanConfig {
        let Self { section_s, closed_loop_s, .. } = *self;
        PlanConfig { section_s, closed_loop_s, ..PlanConfig::default() }
    }

    fn supervisor(&self) -> SupervisorConfig {
        let usual = SupervisorConfig::default();
        SupervisorConfig {
            trip_theta_rad: self.trip_theta_rad,
            release_theta_rad: usual
                .release_theta_rad
                .min((RELEASE * self.trip_theta_rad * 1e3).floor() / 1e3),
            ..usual
        }
    }

    /// The board's parameters, by their MAVLink names.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static str, f32)> {
        let (sections, supervisor) = (self.sections(), self.supervisor());
        vec![
            ("EXC_AMPL", self.amplitude_rad),
            ("EXC_DWELL_MIN", self.dwell_s[0]),
            ("EXC_DWELL_MAX", self.dwell_s[1]),
            ("TEST_LEAD", sections.lead_in_s),
            ("TEST_SECTION", sections.section_s),
            ("TEST_PAUSE", sections.pause_s),
            ("TEST_LOOP", sections.closed_loop_s),
            ("LIM_THETA", supervisor.trip_theta_rad),
            ("LIM_RATE", supervisor.trip_q_rad_s),
            ("REL_THETA", supervisor.release_theta_rad),
            ("REL_RATE", supervisor.release_q_rad_s),
        ]
    }

    /// The test on a craft drawn by `seed`, with `concealed` beside what its model has.
    ///
    /// # Errors
    /// No usual test, as long as the simulator has one.
    pub fn scenario(
        &self,
        craft: &Craft,
        concealed: &[Setting],
        weather: Weather,
        seed: u64,
    ) -> Result<Scenario, Error> {
        let mut scenario = Scenario::campaign(4, self.amplitude_rad, seed)?;
        scenario.dwell_s = self.dwell_s;
        scenario.plan = self.sections();
        scenario.supervisor = self.supervisor();
        scenario.plant = craft.drawn(seed);
        scenario.background = weather.background;
        scenario.air = weather.air;
        scenario.conceal(craft.effects().iter().chain(concealed).cloned().collect());
        Ok(scenario)
    }

    /// Flies it on a craft drawn by `seed`.
    ///
    /// # Errors
    /// A craft that cannot be.
    pub fn fly(
        &self,
        craft: &Craft,
        concealed: &[Setting],
        weather: Weather,
        seed: u64,
    ) -> Result<Flight, Error> {
        let scenario = self.scenario(craft, concealed, weather, seed)?;
        Ok(fly_in(&scenario, air(&scenario.plant, weather, seed)?)?)
    }
}

/// The air of a day, in N m: whatever the test, the craft is shaken as in one that moves it as much as the paper's moved theirs.
fn air(plant: &Plant, weather: Weather, seed: u64) -> Result<BackgroundTruth, Error> {
    let gain = (plant.dm_du / plant.inertia_kg_m2).abs();
    let mut usual = Scenario::campaign(4, (USUAL_AMPLITUDE_RAD * USUAL_GAIN / gain) as f32, seed)?;
    usual.plant = *plant;
    usual.plan = PlanConfig { section_s: SIZED_S, closed_loop_s: 0.0, ..PlanConfig::default() };
    usual.background = weather.background;
    usual.air = weather.air;
    Ok(air_of(&usual)?)
}

impl Flown {
    /// What `flight` was.
    #[must_use]
    pub fn of(flight: &Flight) -> Self {
        let largest = |value: &dyn Fn(&Row) -> f32| {
            flight.rows.iter().fold(0.0, |most: f64, row| most.max(f64::from(value(row)).abs()))
        };
        let in_closed_loop = |row: &Row| if row.section == Section::IV { row.theta_rad } else { 0.0 };
        let excited = flight.rows.iter().filter(|row| row.section.sequence().is_some());
        let excited: Vec<bool> = excited.map(|row| row.supervised).collect();
        let overridden = excited.iter().filter(|&&supervised| supervised).count();
        Self {
            angle_rad: largest(&|row| row.theta_rad),
            closed_loop_angle_rad: largest(&in_closed_loop),
            rate_rad_s: largest(&|row| row.q_rad_s),
            overridden: overridden as f64 / excited.len().max(1) as f64,
            length_s: flight.rows.last().map_or(0.0, |row| row.t_s),
            broken_off: matches!(flight.outcome, estimator_core::Phase::Aborted { .. }),
        }
    }
}

/// What a rig would have logged, as a recording.
///
/// # Errors
/// None that a flight could cause.
pub fn recording(flight: &Flight) -> Result<Recording, Error> {
    Ok(parse("flown.csv", flight.recording().as_bytes(), &ReadOptions::default())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimator_core::prbs::PrbsConfig;
    use estimator_core::{Config, constants::TAPS};

    const TEST: Test = Test {
        dwell_s: [0.2, 0.4],
        amplitude_rad: 0.015,
        section_s: 20.0,
        closed_loop_s: 25.0,
        trip_theta_rad: 0.3,
    };

    #[test]
    fn the_core_builds_a_test_from_the_parameters() {
        let prbs = PrbsConfig { amplitude_rad: 0.015, dwell_min_s: 0.2, dwell_max_s: 0.4 };
        let config =
            Config { prbs, plan: TEST.sections(), supervisor: TEST.supervisor(), ..Config::default() };
        assert!(config.build::<TAPS>().is_ok());
        assert_eq!(TEST.length_s(), 5.0 + 3.0 * 25.0 + 25.0);
    }

    #[test]
    fn the_air_does_not_grow_with_the_excitation() {
        let craft = Craft::of_size_and_mass(5.0, 0.415).unwrap();
        let sigma = |amplitude_rad| {
            let test = Test { amplitude_rad, ..TEST };
            test.fly(&craft, &[], Weather::default(), 3).unwrap().truth.background.sigma
        };
        assert_eq!(sigma(0.005), sigma(0.015));
    }

    #[test]
    fn a_smaller_limit_is_kept_by_the_supervisor() {
        let craft = Craft::of_size_and_mass(5.0, 0.415).unwrap();
        let flown = |trip_theta_rad| {
            let test = Test { dwell_s: [0.4, 0.8], trip_theta_rad, ..TEST };
            Flown::of(&test.fly(&craft, &[], Weather::default(), 5).unwrap())
        };
        let (near, far) = (flown(0.1), flown(0.4));
        assert!(near.angle_rad < far.angle_rad && near.overridden > far.overridden, "{near:?} {far:?}");
    }
}
