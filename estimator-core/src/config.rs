//! The whole configuration in SI units, checked once.
//!
//! Every part has its own `…Config` with public SI fields and a `Default`; [`Config`] gathers them. `build`
//! checks every field against its legal range and returns the form that the cycle runs on. Nothing after
//! `build` can fail.

use core::fmt;

use crate::attitude::AttitudeConfig;
use crate::constants::TICKS_PER_S;
use crate::convergence::ConvergenceConfig;
use crate::cycle::Cycle;
use crate::lms::LmsConfig;
use crate::plan::PlanConfig;
use crate::prbs::PrbsConfig;
use crate::supervisor::SupervisorConfig;

/// Configuration of one test. The default is the paper's campaign 4 at 0.015 rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Config {
    /// Seed from which the three excitation sequences are derived.
    pub seed: u64,
    /// Excitation of sections I to III.
    pub prbs: PrbsConfig,
    /// Durations of the sections and of the pauses between them.
    pub plan: PlanConfig,
    /// Limits that the supervisor guards.
    pub supervisor: SupervisorConfig,
    /// Controller of recoveries, pauses and section IV.
    pub attitude: AttitudeConfig,
    /// On-board estimator.
    pub lms: LmsConfig,
    /// When the estimator calls itself converged.
    pub convergence: ConvergenceConfig,
}

impl Config {
    /// Checks every field and builds the cycle with an FIR of `N` taps.
    ///
    /// # Errors
    /// The first field outside its legal range, by name, with the range.
    pub fn build<const N: usize>(&self) -> Result<Cycle<N>, ConfigError> {
        Ok(Cycle {
            seed: self.seed,
            prbs: self.prbs.build()?,
            plan: self.plan.build()?,
            supervisor: self.supervisor.build()?,
            attitude: self.attitude.build()?,
            lms: self.lms.build()?,
            convergence: self.convergence.build()?,
        })
    }
}

/// A field of the configuration that lies outside its legal range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    /// Path of the field, for example `prbs.dwell_min_s`.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// The value found.
    pub found: f32,
    /// Lowest legal value.
    pub low: f32,
    /// Highest legal value.
    pub high: f32,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, unit, found, low, high } = self;
        let space = if unit.is_empty() { "" } else { " " };
        write!(f, "{name} is {found}{space}{unit}; set it within {low} to {high}{space}{unit}")
    }
}

impl core::error::Error for ConfigError {}

/// Ok when `found` is a number within [`low`, `high`].
pub(crate) fn within(
    name: &'static str,
    unit: &'static str,
    found: f32,
    [low, high]: [f32; 2],
) -> Result<(), ConfigError> {
    // written so that NaN fails
    if found >= low && found <= high { Ok(()) } else { Err(ConfigError { name, unit, found, low, high }) }
}

/// Duration in whole ticks, rounded to the nearest.
pub(crate) fn ticks(seconds: f32) -> u32 {
    libm::roundf(seconds * TICKS_PER_S) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_default_configuration_builds() {
        assert!(Config::default().build::<60>().is_ok());
    }

    #[test]
    fn an_illegal_step_size_is_named_with_its_range() {
        let mut config = Config::default();
        config.lms.step = 2.0;
        let text = config.build::<60>().err().unwrap().to_string();
        assert_eq!(text, "lms.step is 2; set it within 0.000001 to 1.999");
    }

    #[test]
    fn nan_is_refused_in_every_part() {
        let cases: [fn(&mut Config); 6] = [
            |c| c.prbs.amplitude_rad = f32::NAN,
            |c| c.plan.section_s = f32::NAN,
            |c| c.supervisor.trip_theta_rad = f32::NAN,
            |c| c.attitude.rate_gain_s = f32::NAN,
            |c| c.lms.regularisation_rad2 = f32::NAN,
            |c| c.convergence.max_gain_drift = f32::NAN,
        ];
        for spoil in cases {
            let mut config = Config::default();
            spoil(&mut config);
            assert!(config.build::<60>().is_err());
        }
    }

    #[test]
    fn limits_in_the_wrong_order_are_refused() {
        let mut config = Config::default();
        config.prbs.dwell_max_s = config.prbs.dwell_min_s / 2.0;
        assert_eq!(config.build::<60>().err().unwrap().name, "prbs.dwell_max_s");
        let mut config = Config::default();
        config.supervisor.release_theta_rad = config.supervisor.trip_theta_rad;
        assert_eq!(config.build::<60>().err().unwrap().name, "supervisor.release_theta_rad");
    }
}
