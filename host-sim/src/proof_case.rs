//! A case of a proof: what is concealed, how large, before which background, drawn by a seed and a number.
//!
//! Kinds, effects, backgrounds and sizes go round in turn, so that any long run of numbers holds each of them
//! about equally often; plant, signs, further parameters, excitation and noise are random. A case hangs on its
//! seed and its number alone.
//!
//! Of six cases in a row three conceal one effect of the catalogue, one conceals nothing, one an effect outside
//! the catalogue, one a pair. In a quarter of the cases the IMU is fixed to the airframe.

use rand::RngExt;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::air::Air;
use crate::calibrate::{Strength, cost_in, nearest_for_loss, simulate, vaf};
use crate::effects::{CATALOGUE, Entry, OUTSIDE, Setting, UNTOUCHED};
use crate::error::Error;
use crate::flight::{Flight, fly_whole};
use crate::plant::Plant;
use crate::scenario::{Background, Scenario};
use crate::seeds::{Stream, generator};

/// What kind of case it is.
#[derive(Clone, Copy, Debug, Eq, PartialEq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// One effect of the catalogue.
    Effect,
    /// Two effects of the catalogue.
    Pair,
    /// Nothing.
    Nothing,
    /// An effect that no catalogue has.
    Outside,
    /// One of those that nobody tunes on.
    Untouched,
}

/// A case before it is flown.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its kind.
    pub kind: Kind,
    /// What is concealed.
    pub entries: Vec<&'static Entry>,
    /// How much each of them is to cost.
    pub strength: Strength,
    /// Where it is flown, nothing concealed yet.
    pub scenario: Scenario,
    generator: Pcg64,
}

/// A case that was flown.
#[derive(Clone, Debug)]
pub struct Concealed {
    /// Where it was flown.
    pub scenario: Scenario,
    /// The test.
    pub flight: Flight,
    /// What leaving everything out costs, points of VAF on held-out sections.
    pub cost_points: f64,
    /// How large that is: `moderate` from 2 points on, `strong` from 8 on, `weak` below. What no VAF shows has the
    /// size that was asked for. Empty where nothing is concealed.
    pub size: &'static str,
    /// VAF (%) of the true model by section, without noise and background.
    pub true_vaf_percent: Vec<(String, f64)>,
}

/// Effects that no VAF of the rate shows: it takes the mean out, and a gain hides in ∂M/∂u, and the angle is another channel. Their sizes are shares
/// of the usual range, on a logarithmic scale.
const UNSEEN: [&str; 5] = ["gyro_bias", "gyro_scale", "angle_lag", "angle_skew", "encoder_error"];
/// Costs from which on a case counts as moderate and as strong, points.
const MODERATE_POINTS: f64 = 2.0;
const STRONG_POINTS: f64 = 8.0;

/// Pairs that are the second effect with other values: dry friction is the special case of both.
const ONE_TOGETHER: [[&str; 2]; 2] =
    [["coulomb_friction", "asymmetric_friction"], ["coulomb_friction", "stribeck_friction"]];

/// Attempts to draw parameters with which an effect costs what it should.
const DRAWS: usize = 3;
/// Attempts to draw effects with which the test ends as it should.
const ATTEMPTS: usize = 8;
/// Share of cases with the IMU fixed to the airframe.
const RIGID: f64 = 0.25;
/// Share of cases in which roll and yaw are logged though clamped.
const ROLL_YAW_LOGGED: f64 = 0.3;

impl Trial {
    /// Case `number` of the proof of `seed`.
    ///
    /// # Errors
    /// None that a caller could cause: the campaigns drawn exist.
    pub fn new(seed: u64, number: u64) -> Result<Self, Error> {
        let own_seed = seed.wrapping_mul(1_000_003).wrapping_add(number);
        let mut generator = generator(own_seed, Stream::Choice);
        let (round, place) = (number / 6, number % 6);
        // counts the cases of the same kind
        let (kind, turn) = match place {
            1 => (Kind::Nothing, round),
            3 => (Kind::Outside, round),
            5 => (Kind::Pair, round),
            _ => (Kind::Effect, 3 * round + place / 2),
        };
        let turn = turn as usize;
        let unlisted = || OUTSIDE.iter().chain(UNTOUCHED);
        let outside = || unlisted().nth(turn % unlisted().count());
        let entries: Vec<&Entry> = match kind {
            Kind::Nothing => Vec::new(),
            Kind::Effect => vec![&CATALOGUE[turn % CATALOGUE.len()]],
            Kind::Pair => pair(&mut generator),
            Kind::Outside | Kind::Untouched => outside().into_iter().collect(),
        };
        let untouched = entries.iter().any(|entry| UNTOUCHED.iter().any(|other| other.id == entry.id));
        // each time a list begins again, every effect meets the next size and the next background
        let mixed = match kind {
            Kind::Effect => turn % CATALOGUE.len() + turn / CATALOGUE.len(),
            Kind::Outside | Kind::Untouched => turn % unlisted().count() + turn / unlisted().count(),
            Kind::Nothing | Kind::Pair => turn,
        };
        let strength = if mixed % 2 == 0 { Strength::Moderate } else { Strength::Strong };
        let campaign = if generator.random_bool(0.7) { 4 } else { 3 };
        let amplitude = [0.012, 0.015, 0.019][generator.random_range(0..3)];
        let mut scenario = Scenario::campaign(campaign, amplitude, own_seed)?;
        scenario.plant = Plant::drawn(own_seed);
        scenario.background = [Background::Clean, Background::Lab, Background::Paper][mixed % 3];
        scenario.roll_yaw_logged = generator.random_bool(ROLL_YAW_LOGGED);
        if generator.random_bool(RIGID) {
            scenario.plant = scenario.plant.rigid();
        }
        let kind = if untouched { Kind::Untouched } else { kind };
        Ok(Self { kind, entries, strength, scenario, generator })
    }

    /// The same case in another air: plant, excitation, noise and ids are drawn alike; the sizes are those that cost
    /// what they should in that air.
    #[must_use]
    pub fn with_air(mut self, air: Air) -> Self {
        self.scenario.air = air;
        self
    }

    /// Sizes what is concealed, and flies the test. An effect that cannot cost what it should, at any parameters
    /// drawn, costs the nearest that it can.
    ///
    /// # Errors
    /// As [`fly`](crate::fly); no attempt ended as a test should.
    pub fn fly(mut self) -> Result<Concealed, Error> {
        for _ in 0..ATTEMPTS {
            let mut settings = Vec::new();
            for entry in self.entries.clone() {
                settings.extend(self.sized(entry)?);
            }
            if settings.len() == self.entries.len() {
                let mut scenario = self.scenario.clone();
                scenario.conceal(settings);
                if let Some(flight) = fly_whole(&scenario)? {
                    return Ok(Concealed::new(scenario, flight, self.strength));
                }
            }
            if self.kind == Kind::Pair {
                self.entries = pair(&mut self.generator);
            }
        }
        let ids: Vec<&str> = self.entries.iter().map(|entry| entry.id).collect();
        Err(Error::AlwaysBrokenOff { seed: self.scenario.seed, ids: ids.join(" and ") })
    }

    /// The effect at its size; nothing where every size breaks the test off.
    fn sized(&mut self, entry: &'static Entry) -> Result<Option<Setting>, Error> {
        let (low, high) = self.strength.points();
        let target = self.generator.random_range(low..high);
        if UNSEEN.contains(&entry.id) {
            let share = match self.strength {
                Strength::Moderate => self.generator.random_range(0.3..0.65),
                Strength::Strong => self.generator.random_range(0.65..1.0),
            };
            let [small, large] = entry.parameters[0].range;
            return Ok(Some(entry.drawn(&mut self.generator).resized(small * (large / small).powf(share))));
        }
        let mut best: Option<(Setting, f64)> = None;
        for _ in 0..DRAWS {
            let setting = entry.drawn(&mut self.generator);
            let nearest = nearest_for_loss(&self.scenario, &setting, target)?;
            if let Some((setting, cost)) = nearest
                && best.as_ref().is_none_or(|(_, known)| (cost - target).abs() < (known - target).abs())
            {
                best = Some((setting, cost));
            }
            if best.as_ref().is_some_and(|(_, cost)| (low..high).contains(cost)) {
                break;
            }
        }
        Ok(best.map(|(setting, _)| setting))
    }
}

/// Two different effects of the catalogue that are two together.
fn pair(generator: &mut Pcg64) -> Vec<&'static Entry> {
    loop {
        let first = generator.random_range(0..CATALOGUE.len());
        let second = (first + generator.random_range(1..CATALOGUE.len())) % CATALOGUE.len();
        let pair = [&CATALOGUE[first], &CATALOGUE[second]];
        if !ONE_TOGETHER.iter().any(|ids| ids.iter().all(|id| pair.iter().any(|entry| entry.id == *id))) {
            return pair.to_vec();
        }
    }
}

impl Concealed {
    fn new(scenario: Scenario, flight: Flight, asked: Strength) -> Self {
        let simulated = simulate(scenario.plant, &scenario.effects, scenario.seed, &flight);
        let mut sections = Vec::new();
        for row in &flight.rows {
            if row.section != estimator_core::Section::Between && !sections.contains(&row.section) {
                sections.push(row.section);
            }
        }
        let of = |section| (format!("{section}"), vaf(&flight, &simulated, section));
        let true_vaf_percent = sections.into_iter().map(of).collect();
        let cost_points = if scenario.effects.is_empty() { 0.0 } else { cost_in(&scenario, &flight) };
        let unseen = scenario.effects.iter().all(|effect| UNSEEN.contains(&effect.entry().id));
        let size = match (unseen, asked) {
            _ if scenario.effects.is_empty() => "",
            (true, Strength::Moderate) => "moderate",
            (true, Strength::Strong) => "strong",
            _ if cost_points >= STRONG_POINTS => "strong",
            _ if cost_points >= MODERATE_POINTS => "moderate",
            _ => "weak",
        };
        Self { scenario, flight, cost_points, size, true_vaf_percent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use std::collections::BTreeSet;

    #[test]
    fn six_rounds_of_single_effects_are_all_combinations() {
        let numbers = 0..12 * CATALOGUE.len() as u64;
        let trials = numbers.map(|number| Trial::new(1, number).unwrap());
        let single = trials.filter(|trial| trial.kind == Kind::Effect);
        let combinations: BTreeSet<String> = single
            .map(|t| format!("{} {:?} {:?}", t.entries[0].id, t.strength, t.scenario.background))
            .collect();
        assert_eq!(combinations.len(), 6 * CATALOGUE.len());
    }

    #[test]
    fn every_kind_comes_up_and_cases_hang_on_seed_and_number() {
        let kinds: BTreeSet<Kind> = (0..120).map(|number| Trial::new(1, number).unwrap().kind).collect();
        assert_eq!(kinds.len(), 5);
        let described = |seed, number| format!("{:?}", Trial::new(seed, number).unwrap());
        assert_eq!(described(1, 17), described(1, 17));
        assert_ne!(described(1, 17), described(2, 17));
        let pairs = (0..600).map(|number| Trial::new(1, number).unwrap()).filter(|t| t.kind == Kind::Pair);
        assert!(pairs.clone().all(|t| t.entries[0].id != t.entries[1].id));
        let mut generator = Pcg64::seed_from_u64(1);
        for _ in 0..10_000 {
            let ids: Vec<&str> = pair(&mut generator).iter().map(|entry| entry.id).collect();
            let frictions = ids.iter().filter(|id| id.ends_with("_friction")).count();
            assert!(frictions < 2 || !ids.contains(&"coulomb_friction"), "{ids:?}");
        }
        assert_eq!(pairs.count(), 100);
    }

    #[test]
    fn a_case_is_flown_in_the_air_it_is_given() {
        let [usual, other] = [Air::BandPassed, Air::ThreePoles].map(|air| {
            let trial = Trial::new(3, 1).unwrap().with_air(air);
            trial.fly().unwrap()
        });
        assert_eq!(other.flight.truth.background.air, Air::ThreePoles);
        assert_eq!(usual.flight.truth.background.sigma, other.flight.truth.background.sigma);
        assert_eq!(usual.scenario.plant, other.scenario.plant);
        assert_ne!(usual.flight.recording(), other.flight.recording());
    }

    #[test]
    fn what_was_concealed_costs_about_what_it_should() {
        for number in [0, 2] {
            let trial = Trial::new(3, number).unwrap();
            let (low, high) = trial.strength.points();
            let concealed = trial.fly().unwrap();
            let cost = concealed.cost_points;
            assert!((0.8 * low..1.2 * high).contains(&cost), "{number}: {cost}");
            assert_eq!(concealed.true_vaf_percent.len(), 4);
            assert!(concealed.true_vaf_percent.iter().all(|(_, vaf)| *vaf > 40.0));
        }
    }
}
