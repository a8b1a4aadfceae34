//! An effect with its parameters, and how it stands in a truth file.

use serde::Serialize;

use super::unlisted::SHAPES;
use super::{Effect, Entry, Parameter};
use crate::error::Error;
use crate::reading::Reading;

/// An effect with its parameters: what is concealed.
#[derive(Clone, Debug)]
pub struct Setting {
    pub(super) entry: &'static Entry,
    pub(super) values: Vec<f64>,
}

impl Setting {
    /// The effect `id` with named parameters, in any order.
    ///
    /// # Errors
    /// An unknown effect; a parameter that is missing, unknown, or no finite number.
    pub fn new(id: &str, parameters: &[(&str, f64)]) -> Result<Self, Error> {
        Self::of(Entry::find(id)?, parameters)
    }

    /// A term without a name, by its shape, as a model file has it: coefficients and scales.
    ///
    /// # Errors
    /// An unknown shape; otherwise as [`Setting::new`].
    pub fn unlisted(shape: &str, parameters: &[(&str, f64)]) -> Result<Self, Error> {
        let entry = SHAPES.iter().find(|entry| entry.id == shape).ok_or_else(|| {
            let known: Vec<&str> = SHAPES.iter().map(|entry| entry.id).collect();
            Error::UnknownEffect { id: shape.to_owned(), known: known.join(", ") }
        })?;
        Self::of(entry, parameters)
    }

    fn of(entry: &'static Entry, parameters: &[(&str, f64)]) -> Result<Self, Error> {
        let wrong = |problem| Error::Parameter { id: entry.id, problem };
        let known = || entry.parameters.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
        if let Some((name, _)) =
            parameters.iter().find(|(n, _)| entry.parameters.iter().all(|p| p.name != *n))
        {
            return Err(wrong(format!("it has no parameter `{name}`; it has {}", known())));
        }
        let value = |p: &Parameter| match parameters.iter().find(|(name, _)| *name == p.name) {
            Some((_, value)) if value.is_finite() && (p.signed || *value >= 0.0) => Ok(*value),
            Some((_, value)) => {
                let kind = if p.signed { "a finite number" } else { "a finite number, 0 or positive" };
                Err(wrong(format!("`{}` is {value}; it must be {kind}, in {}", p.name, p.unit)))
            }
            None => Err(wrong(format!("parameter `{}` ({}) is missing", p.name, p.unit))),
        };
        let values = entry.parameters.iter().map(value).collect::<Result<_, _>>()?;
        Ok(Self { entry, values })
    }

    /// The effect at its moderate or strong size ([`Entry::moderate_and_strong`]), other parameters at the
    /// geometric mean of their range, signed ones positive.
    ///
    /// # Errors
    /// An unknown effect.
    pub fn usual(id: &str, strong: bool) -> Result<Self, Error> {
        let entry = Entry::find(id)?;
        let [moderate, large] = entry.moderate_and_strong;
        let mut values: Vec<f64> =
            entry.parameters.iter().map(|p| (p.range[0] * p.range[1]).sqrt()).collect();
        values[0] = if strong { large } else { moderate };
        Ok(entry.setting(values))
    }

    /// The effect that this is a setting of.
    #[must_use]
    pub const fn entry(&self) -> &'static Entry {
        self.entry
    }

    /// Its parameters with their values.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, f64)> {
        self.entry.parameters.iter().zip(self.values.iter().copied())
    }

    /// The same effect at another size: the first parameter, its sign kept.
    #[must_use]
    pub fn resized(&self, magnitude: f64) -> Self {
        let mut resized = self.clone();
        resized.values[0] = magnitude.copysign(self.values[0]);
        resized
    }

    /// The same effect with the sign of its size turned round.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut mirrored = self.clone();
        mirrored.values[0] = -self.values[0];
        mirrored
    }

    /// Whether readings of the IMU end at some value.
    #[must_use]
    pub fn clips(&self) -> bool {
        let beyond = Reading { q: f64::MAX, theta: f64::MAX, ..Reading::default() };
        let mut reading = beyond;
        self.build(0).limit(&mut reading);
        reading != beyond
    }

    /// The effect itself, at rest; what is random in it hangs on `seed`.
    #[must_use]
    pub fn build(&self, seed: u64) -> Box<dyn Effect> {
        (self.entry.make)(&self.values, seed)
    }
}

/// A setting as it stands in a truth file.
#[derive(Clone, Debug, Serialize)]
pub struct SettingTruth {
    id: &'static str,
    locus: &'static str,
    parameters: Vec<ParameterTruth>,
    /// The effect is not there outside it, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    location_time_s: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Serialize)]
struct ParameterTruth {
    name: &'static str,
    unit: &'static str,
    value: f64,
}

impl SettingTruth {
    /// The setting in a test that ended at `end_s`.
    pub(crate) fn new(setting: &Setting, end_s: f64) -> Self {
        let parameters = setting
            .parameters()
            .map(|(p, value)| ParameterTruth { name: p.name, unit: p.unit, value })
            .collect();
        let location_time_s = setting.build(0).window_s().map(|window| window.map(|t| t.min(end_s)));
        Self { id: setting.entry.id, locus: setting.entry.locus, parameters, location_time_s }
    }
}
