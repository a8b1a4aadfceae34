//! The whole configuration in SI units, checked once.
//!
//! Every part has its own `…Config` with public SI fields and a `Default`; [`Config`] gathers them. `build`
//! checks every field against its legal range and returns the form that the cycle runs on. Nothing after
//! `build` can fail.

use crate::attitude::AttitudeConfig;
use crate::convergence::ConvergenceConfig;
use crate::cycle::Cycle;
use crate::lms::LmsConfig;
use crate::monitor::MonitorConfig;
use crate::plan::PlanConfig;
use crate::prbs::PrbsConfig;
use crate::supervisor::SupervisorConfig;

pub use crate::config_error::ConfigError;

/// Configuration of the core. The default is the paper's campaign 4 at 0.015 rad.
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
    /// What the monitor watches for.
    pub monitor: MonitorConfig,
}

impl Config {
    /// Checks every field and builds the cycle with an FIR of `N` taps.
    ///
    /// # Errors
    /// The first field outside its legal range, by name, with the range.
    pub fn build<const N: usize>(&self) -> Result<Cycle<N>, ConfigError> {
        self.monitor.check()?;
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
        let cases: [fn(&mut Config); 7] = [
            |c| c.prbs.amplitude_rad = f32::NAN,
            |c| c.plan.section_s = f32::NAN,
            |c| c.supervisor.trip_theta_rad = f32::NAN,
            |c| c.attitude.rate_gain_s = f32::NAN,
            |c| c.lms.regularisation_rad2 = f32::NAN,
            |c| c.convergence.max_gain_drift = f32::NAN,
            |c| c.monitor.run_length_h = f32::NAN,
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
