//! What an experiment is to reach, and what it must keep.

use crate::test::Weather;
use estimator_core::plan::PlanConfig;

/// Accuracy of ∂M/∂q and of the delay that goes with one of ∂M/∂u: what a controller bears of each is about alike.
pub const DAMPING_FACTOR: f64 = 4.0;
/// s of delay per % of ∂M/∂u.
pub const DELAY_S_PER_CENT: f64 = 0.002;

/// What an experiment is to reach, and what it must keep.
#[derive(Clone, Debug)]
pub struct Wishes {
    /// Angle that must not be passed, rad: the travel of the rig, or what the pilot bears.
    pub limit_rad: f64,
    /// Largest amplitude of the excitation, rad.
    pub most_amplitude_rad: f64,
    /// Of the excited samples, those in which the supervisor may hold the craft; they tell nothing.
    pub most_overridden: f64,
    /// Longest test, recoveries not counted, s: what a battery bears.
    pub longest_s: f64,
    /// Half the 95 % interval of ∂M/∂u that is wanted, %; of ∂M/∂q four times that, of the delay 2 ms for each per cent.
    pub accuracy_percent: f64,
    /// The air.
    pub weather: Weather,
    /// Flights by which excursion and supervision are foretold.
    pub flights: u64,
    /// Seed of everything drawn.
    pub seed: u64,
}

/// Flights by which an amplitude is judged.
const SCREENED: u64 = 12;
/// Flights from which the accuracy is foretold; each is estimated from as if it were real.
const ESTIMATED: u64 = 150;
/// Flights by which excitations are held against each other.
const COMPARED: u64 = 2;
/// Flights of a contest, each with either rival.
const CONTESTED: u64 = 12;

impl Wishes {
    /// Seeds of one plan do not meet those of another.
    fn seed_of(&self, purpose: u64, k: u64) -> u64 {
        self.seed.wrapping_mul(1_000_003).wrapping_add(purpose * 100_000 + k)
    }

    pub(crate) fn screening_seeds(&self) -> Vec<u64> {
        (0..SCREENED).map(|k| self.seed_of(1, k)).collect()
    }

    pub(crate) fn forecast_seeds(&self) -> Vec<u64> {
        (0..self.flights).map(|k| self.seed_of(2, k)).collect()
    }

    pub(crate) fn estimated_seeds(&self) -> Vec<u64> {
        (0..ESTIMATED.min(self.flights)).map(|k| self.seed_of(2, k)).collect()
    }

    pub(crate) fn compared_seeds(&self) -> Vec<u64> {
        (0..COMPARED).map(|k| self.seed_of(3, k)).collect()
    }

    pub(crate) fn contested_seeds(&self) -> Vec<u64> {
        (0..CONTESTED).map(|k| self.seed_of(4, k)).collect()
    }

    /// Longest section of a test that a battery bears, s.
    pub(crate) fn longest_section_s(&self) -> f32 {
        let PlanConfig { lead_in_s, pause_s, closed_loop_s, .. } = PlanConfig::default();
        let rest = lead_in_s + 3.0 * pause_s + closed_loop_s;
        ((self.longest_s as f32 - rest) / 3.0).max(1.0)
    }

    /// Half-width that is wanted of a parameter, in the unit of its accuracy; none of one that only has to be there.
    pub(crate) fn wanted(&self, name: &str) -> Option<f64> {
        match name {
            "dM_du" => Some(self.accuracy_percent),
            "dM_dq" => Some(DAMPING_FACTOR * self.accuracy_percent),
            "delay" => Some(DELAY_S_PER_CENT * self.accuracy_percent),
            _ => None,
        }
    }
}
