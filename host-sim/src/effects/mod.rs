//! Physics that can be concealed in the aircraft: one file per effect, one line in [`CATALOGUE`].
//!
//! An effect changes the aircraft at any of these places, in the order in which a command travels:
//!
//! | hook | place |
//! | --- | --- |
//! | [`Effect::delay_s`] | transport delay of the command |
//! | [`Effect::blade`] | from the delayed command to what the blades do; chained in the order of the list |
//! | [`Effect::plant`] | parameters that change over time |
//! | [`Effect::moment`], [`Effect::dry_friction`] | moments on the airframe |
//! | [`Effect::measure`] | readings of the IMU, before the noise; chained |

mod coulomb_friction;
mod extra_delay;
mod gravity_stiffness;
mod gust_disturbance;
mod quadratic_drag;
mod servo_lag;
mod trim_offset;

use serde::Serialize;
use std::fmt;

use crate::error::Error;
use crate::plant::{Plant, State};
use crate::sensors::Reading;

/// Every effect that the simulator knows.
pub const CATALOGUE: &[Entry] = &[
    servo_lag::ENTRY,
    trim_offset::ENTRY,
    coulomb_friction::ENTRY,
    quadratic_drag::ENTRY,
    gravity_stiffness::ENTRY,
    extra_delay::ENTRY,
    gust_disturbance::ENTRY,
];

/// Physics that the plant of eq. 9 leaves out. Every hook does nothing unless it is overridden.
pub trait Effect: fmt::Debug {
    /// Delay added to the plant's at time `t`, s.
    fn delay_s(&self, _t: f64) -> f64 {
        0.0
    }

    /// What the blades do during a step of `dt` s that is sent `u` (rad).
    fn blade(&mut self, u: f64, _dt: f64) -> f64 {
        u
    }

    /// Changes the parameters as of time `t`.
    fn plant(&self, _t: f64, _plant: &mut Plant) {}

    /// Called before a tick that ends at `t`, for effects that prepare a signal of their own.
    fn prepare(&mut self, _t: f64) {}

    /// Moment on the airframe at time `t` and state `x`, N m.
    fn moment(&self, _t: f64, _x: &State) -> f64 {
        0.0
    }

    /// Dry friction Mc, N m.
    fn dry_friction(&self) -> f64 {
        0.0
    }

    /// Changes what the IMU reads at time `t`; called once per tick.
    fn measure(&mut self, _t: f64, _reading: &mut Reading) {}
}

/// One effect of the catalogue.
pub struct Entry {
    /// Its name, the same in truth files, model files and diagnoses.
    pub id: &'static str,
    /// Where it sits: `actuator`, `pitch_moment`, `sensor`, `timing` or `environment`.
    pub locus: &'static str,
    /// Its parameters; the first is the one that sets the size.
    pub parameters: &'static [Parameter],
    /// Sizes that cost a model without the effect about 5 points of VAF on held-out sections, and about 10.
    /// Two effects cost less within their usual range, and stand at its end (`trim_offset`, `quadratic_drag`:
    /// 3.4 points); a gust costs 6.4 at the least; friction is steep and uneven (3.7 and 12).
    ///
    /// Median cost over eight seeds of the nominal plant, campaign 4, 0.015 rad, background `Clean`, as
    /// defined in [`crate::calibrate`] and printed by `examples/effect_costs.rs`.
    pub moderate_and_strong: [f64; 2],
    /// Builds it from its parameters, in their order, and a seed.
    make: fn(&[f64], u64) -> Box<dyn Effect>,
}

/// A parameter of an effect.
#[derive(Debug, PartialEq)]
pub struct Parameter {
    /// Its name in files.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Smallest and largest usual magnitude.
    pub range: [f64; 2],
    /// True where the negative of the range is usual too.
    pub signed: bool,
}

/// An effect with its parameters: what is concealed.
#[derive(Clone, Debug)]
pub struct Setting {
    entry: &'static Entry,
    values: Vec<f64>,
}

impl Entry {
    /// The entry called `id`.
    ///
    /// # Errors
    /// No such effect.
    pub fn find(id: &str) -> Result<&'static Self, Error> {
        CATALOGUE.iter().find(|entry| entry.id == id).ok_or_else(|| {
            let known: Vec<&str> = CATALOGUE.iter().map(|entry| entry.id).collect();
            Error::UnknownEffect { id: id.to_owned(), known: known.join(", ") }
        })
    }

    /// The effect with `values` in the order of its parameters.
    pub(crate) fn setting(&'static self, values: Vec<f64>) -> Setting {
        debug_assert_eq!(values.len(), self.parameters.len());
        Setting { entry: self, values }
    }
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

impl Setting {
    /// The effect `id` with named parameters, in any order.
    ///
    /// # Errors
    /// An unknown effect; a parameter that is missing, unknown, or no finite number.
    pub fn new(id: &str, parameters: &[(&str, f64)]) -> Result<Self, Error> {
        let entry = Entry::find(id)?;
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
}

#[derive(Clone, Debug, Serialize)]
struct ParameterTruth {
    name: &'static str,
    unit: &'static str,
    value: f64,
}

impl From<&Setting> for SettingTruth {
    fn from(setting: &Setting) -> Self {
        let parameters = setting
            .parameters()
            .map(|(p, value)| ParameterTruth { name: p.name, unit: p.unit, value })
            .collect();
        Self { id: setting.entry.id, locus: setting.entry.locus, parameters }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_unique_and_every_effect_has_a_size() {
        for (i, entry) in CATALOGUE.iter().enumerate() {
            assert!(CATALOGUE[..i].iter().all(|other| other.id != entry.id));
            let range = entry.parameters[0].range;
            assert!(
                entry.moderate_and_strong.iter().all(|s| (range[0]..=range[1]).contains(s)),
                "{}",
                entry.id
            );
            for strong in [false, true] {
                assert_eq!(Setting::usual(entry.id, strong).unwrap().entry().id, entry.id);
            }
        }
    }

    #[test]
    fn wrong_settings_say_what_to_write() {
        let text = |id, parameters: &[(&str, f64)]| Setting::new(id, parameters).unwrap_err().to_string();
        assert_eq!(text("servo_lag", &[]), "effect `servo_lag`: parameter `T` (s) is missing");
        assert_eq!(text("servo_lag", &[("t", 0.1)]), "effect `servo_lag`: it has no parameter `t`; it has T");
        assert!(text("servo_lag", &[("T", -0.1)]).contains("0 or positive"));
        assert!(
            text("no_such", &[]).starts_with("no effect is called `no_such`; the simulator knows servo_lag,")
        );
    }
}
