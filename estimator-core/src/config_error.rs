//! A field outside its legal range, and the check that finds it. Every part of the configuration is built on it.

use core::fmt;

use crate::decimal::Decimal;

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
        let [found, low, high] = [found, low, high].map(|value| Decimal(*value));
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
