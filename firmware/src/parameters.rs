//! The parameters that the ground may read and set: name, unit, legal range, place in the core's configuration.
//!
//! A value is taken when it lies in the range of the table *and* the core builds a test from it; else the old one stays.

use estimator_core::constants::{MAX_INPUT_DELAY, MAX_TAPS};
use estimator_core::{Config, ConfigError, Cycle};

/// One parameter.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// MAVLink name, at most 16 characters.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// Legal range; the core may narrow it.
    pub range: [f32; 2],
    get: fn(&Config) -> f32,
    set: fn(&mut Config, f32),
}

macro_rules! parameter {
    ($name:literal, $unit:literal, $range:expr, $($field:ident).+) => {
        Parameter { name: $name, unit: $unit, range: $range, get: |c| c.$($field).+, set: |c, value| c.$($field).+ = value }
    };
}

/// All parameters, in the order of their MAVLink index.
pub const PARAMETERS: [Parameter; 18] = [
    parameter!("EXC_AMPL", "rad", [0.0, 0.03], prbs.amplitude_rad),
    parameter!("EXC_DWELL_MIN", "s", [0.02, 10.0], prbs.dwell_min_s),
    parameter!("EXC_DWELL_MAX", "s", [0.02, 10.0], prbs.dwell_max_s),
    Parameter {
        name: "EXC_SEED",
        unit: "",
        // whole numbers that an f32 holds exactly
        range: [0.0, 16_777_215.0],
        get: |c| c.seed as f32,
        set: |c, value| c.seed = value as u64,
    },
    parameter!("TEST_LEAD", "s", [0.0, 600.0], plan.lead_in_s),
    parameter!("TEST_SECTION", "s", [0.02, 3600.0], plan.section_s),
    parameter!("TEST_PAUSE", "s", [0.0, 600.0], plan.pause_s),
    parameter!("TEST_LOOP", "s", [0.0, 3600.0], plan.closed_loop_s),
    parameter!("LIM_THETA", "rad", [0.01, 0.6], supervisor.trip_theta_rad),
    parameter!("LIM_RATE", "rad/s", [0.01, 6.0], supervisor.trip_q_rad_s),
    parameter!("REL_THETA", "rad", [0.001, 0.54], supervisor.release_theta_rad),
    parameter!("REL_RATE", "rad/s", [0.001, 5.4], supervisor.release_q_rad_s),
    parameter!("LMS_STEP", "", [1e-6, 1.999], lms.step),
    parameter!("LMS_LEAK", "", [0.0, 0.01], lms.leakage),
    Parameter {
        name: "LMS_TAPS",
        unit: "",
        range: [1.0, MAX_TAPS as f32],
        get: |c| f32::from(c.lms.taps),
        set: |c, value| c.lms.taps = value as u16,
    },
    Parameter {
        name: "LMS_DELAY",
        unit: "samples",
        range: [0.0, MAX_INPUT_DELAY as f32],
        get: |c| f32::from(c.lms.input_delay),
        set: |c, value| c.lms.input_delay = value as u8,
    },
    parameter!("MON_ARL", "h", [0.1, 1e4], monitor.run_length_h),
    Parameter {
        name: "MON_WATCH",
        unit: "",
        // a bit for each cause; 0 turns the monitor off
        range: [0.0, 255.0],
        get: |c| f32::from(c.monitor.watched),
        set: |c, value| c.monitor.watched = value as u8,
    },
];

/// Why a value was not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// No parameter has this name.
    Unknown,
    /// Outside its range, or no number.
    Range(ConfigError),
}

/// The parameter of this MAVLink name with its index.
#[must_use]
pub fn find(name: &str) -> Option<(usize, &'static Parameter)> {
    PARAMETERS.iter().enumerate().find(|(_, parameter)| parameter.name == name)
}

impl Parameter {
    /// Its value in `config`.
    #[must_use]
    pub fn value(&self, config: &Config) -> f32 {
        (self.get)(config)
    }
}

/// The configuration with every parameter as in `values`, in the order of the table; none where they are not legal.
#[must_use]
pub fn restore(values: &[f32; PARAMETERS.len()]) -> Option<Config> {
    let mut config = Config::default();
    for (parameter, &value) in PARAMETERS.iter().zip(values) {
        let [low, high] = parameter.range;
        (value >= low && value <= high).then(|| (parameter.set)(&mut config, value))?;
    }
    config.build::<MAX_TAPS>().ok().map(|_| config)
}

/// Sets one parameter, or leaves `config` as it was; its index and the test that follows from the new configuration.
///
/// # Errors
/// An unknown name, or a value that is not legal, with the range.
pub fn set(config: &mut Config, name: &str, value: f32) -> Result<(usize, Cycle<MAX_TAPS>), Refusal> {
    let (index, parameter) = find(name).ok_or(Refusal::Unknown)?;
    let [low, high] = parameter.range;
    // written so that NaN fails
    if !(value >= low && value <= high) {
        let (name, unit) = (parameter.name, parameter.unit);
        return Err(Refusal::Range(ConfigError { name, unit, found: value, low, high }));
    }
    let mut wanted = *config;
    (parameter.set)(&mut wanted, value);
    let test = wanted.build().map_err(Refusal::Range)?;
    *config = wanted;
    Ok((index, test))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_reads_back_what_was_set_and_is_legal_by_default() {
        for parameter in PARAMETERS {
            let mut config = Config::default();
            let value = parameter.value(&config);
            assert!(set(&mut config, parameter.name, value).is_ok(), "{}", parameter.name);
            assert_eq!(config, Config::default());
            assert!(parameter.name.len() <= 16);
        }
    }

    #[test]
    fn all_are_restored_together_or_none() {
        let mut config = Config::default();
        set(&mut config, "LIM_THETA", 0.3).unwrap();
        set(&mut config, "LMS_TAPS", 64.0).unwrap();
        let values = PARAMETERS.map(|parameter| parameter.value(&config));
        assert_eq!(restore(&values), Some(config));
        for place in 0..values.len() {
            let mut spoilt = values;
            spoilt[place] = f32::NAN;
            assert_eq!(restore(&spoilt), None);
        }
    }

    #[test]
    fn what_is_not_legal_changes_nothing() {
        for parameter in PARAMETERS {
            let [low, high] = parameter.range;
            for bad in [f32::NAN, f32::INFINITY, low - 1.0, high * 2.0 + 1.0] {
                let mut config = Config::default();
                assert!(matches!(set(&mut config, parameter.name, bad), Err(Refusal::Range(_))), "{bad}");
                assert_eq!(config, Config::default());
            }
        }
    }

    #[test]
    fn the_core_has_the_last_word() {
        let mut config = Config::default();
        let refusal = set(&mut config, "EXC_DWELL_MIN", 5.0);
        assert!(matches!(refusal, Err(Refusal::Range(ConfigError { name: "prbs.dwell_max_s", .. }))));
        assert_eq!(set(&mut config, "NO_SUCH", 1.0), Err(Refusal::Unknown));
    }
}
