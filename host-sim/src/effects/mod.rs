//! Physics that can be concealed in the aircraft: one file per effect, one line in a list.
//!
//! [`CATALOGUE`] holds what a diagnosis may know by name. [`OUTSIDE`] and [`UNTOUCHED`] hold what no catalogue
//! has, and what a test-bed or a flight can have all the same; on [`UNTOUCHED`] nothing is ever tuned.
//!
//! An effect changes the aircraft at any of these places, in the order in which a command travels:
//!
//! | hook | place |
//! | --- | --- |
//! | [`Effect::logged_at`] | the time whose command the log shows |
//! | [`Effect::delay_s`] | transport delay of the command |
//! | [`Effect::blade`] | from the delayed command to what the blades do; chained in the order of the list |
//! | [`Effect::plant`] | parameters that change over time |
//! | [`Effect::moment`], [`Effect::dry_friction`] | moments on the airframe |
//! | [`Effect::others`], [`Effect::beside`] | what goes on beside the pitch axis |
//! | [`Effect::follow`] | states of the effect's own, after each step |
//! | [`Effect::measure`] | readings of the IMU, before the noise; chained |
//! | [`Effect::limit`] | readings after the noise |

mod angle_lag;
mod angle_skew;
mod asymmetric_friction;
mod asymmetric_servo;
mod asymmetric_thrust;
mod axis_misalignment;
mod clock_skew;
mod cogging;
mod coulomb_friction;
mod cross_feed;
mod cubic_stiffness;
mod effectiveness_fade;
mod encoder_error;
mod end_stop;
mod extra_delay;
mod gravity_stiffness;
mod gust_disturbance;
mod gyro_bias;
mod gyro_lag;
mod gyro_saturation;
mod gyro_scale;
mod gyroscopic_coupling;
mod hysteresis;
mod imu_mount;
mod inertia_step;
mod inflow_lag;
mod linear_stiffness;
mod linkage_backlash;
mod moment_step;
mod oscillator;
mod outside;
mod periodic_moment;
mod position_drive;
mod quadratic_drag;
mod rest_angle;
mod rotor_reaction;
mod servo_deadband;
mod servo_lag;
mod servo_rate_limit;
mod servo_saturation;
mod servo_second_order;
mod setting;
mod slung_load;
mod stribeck_friction;
mod structural_mode;
mod thrust_curve;
mod thrust_dependence;
mod thrust_offset;
mod trim_offset;
mod unilateral_spring;
mod unlisted;
mod untouched;
mod voltage_droop;

use std::fmt;

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::error::Error;
use crate::plant::{Plant, State};
use crate::reading::{Beside, Others, Reading};

pub use setting::{Setting, SettingTruth};

/// Effects that a diagnosis may know by name.
pub const CATALOGUE: &[Entry] = &[
    servo_lag::ENTRY,
    servo_rate_limit::ENTRY,
    servo_saturation::ENTRY,
    linkage_backlash::ENTRY,
    servo_deadband::ENTRY,
    trim_offset::ENTRY,
    thrust_curve::ENTRY,
    inflow_lag::ENTRY,
    effectiveness_fade::ENTRY,
    servo_second_order::ENTRY,
    asymmetric_servo::ENTRY,
    rotor_reaction::ENTRY,
    cross_feed::ENTRY,
    thrust_dependence::ENTRY,
    thrust_offset::ENTRY,
    voltage_droop::ENTRY,
    coulomb_friction::ENTRY,
    quadratic_drag::ENTRY,
    gravity_stiffness::ENTRY,
    cubic_stiffness::ENTRY,
    end_stop::ENTRY,
    structural_mode::ENTRY,
    gyroscopic_coupling::ENTRY,
    inertia_step::ENTRY,
    stribeck_friction::ENTRY,
    asymmetric_friction::ENTRY,
    hysteresis::ENTRY,
    unilateral_spring::ENTRY,
    slung_load::ENTRY,
    moment_step::ENTRY,
    extra_delay::ENTRY,
    clock_skew::ENTRY,
    gyro_bias::ENTRY,
    gyro_scale::ENTRY,
    gyro_lag::ENTRY,
    gyro_saturation::ENTRY,
    imu_mount::ENTRY,
    angle_lag::ENTRY,
    angle_skew::ENTRY,
    axis_misalignment::ENTRY,
    gust_disturbance::ENTRY,
    periodic_moment::ENTRY,
    cogging::ENTRY,
    encoder_error::ENTRY,
    asymmetric_thrust::ENTRY,
];

/// Effects of the catalogue that no proof draws: a rest angle shows only beside a spring, and a straight spring is gravity over the
/// angles of a flight; a drive that holds a position is no rotorcraft.
pub const UNDRAWN: &[Entry] = &[rest_angle::ENTRY, linear_stiffness::ENTRY, position_drive::ENTRY];

/// Physics that no catalogue has.
pub const OUTSIDE: &[Entry] = &[
    outside::angle_damping::ENTRY,
    outside::rate_dependent_thrust::ENTRY,
    outside::servo_hunting::ENTRY,
    outside::command_quantiser::ENTRY,
    outside::missed_frames::ENTRY,
    outside::intermittent_delay::ENTRY,
    outside::vibration_rectification::ENTRY,
    outside::gust_burst::ENTRY,
];

/// Physics that no catalogue has, and that nobody tunes a diagnosis on.
pub const UNTOUCHED: &[Entry] =
    &[untouched::sticky_end::ENTRY, untouched::sagging_supply::ENTRY, untouched::local_friction::ENTRY];

/// Effects that a diagnosis may know by name, those that no proof draws among them.
pub fn named() -> impl Iterator<Item = &'static Entry> {
    CATALOGUE.iter().chain(UNDRAWN)
}

/// Every effect that the simulator knows: with a name, outside, untouched.
pub fn every() -> impl Iterator<Item = &'static Entry> {
    named().chain(OUTSIDE).chain(UNTOUCHED)
}

/// Physics that the plant of eq. 9 leaves out. Every hook does nothing unless it is overridden.
pub trait Effect: fmt::Debug {
    /// The time whose command the log shows at time `t`, s.
    fn logged_at(&self, t: f64) -> f64 {
        t
    }

    /// Delay added to the plant's at time `t`, s.
    fn delay_s(&self, _t: f64) -> f64 {
        0.0
    }

    /// What the blades do, in the mean, during a step of `dt` s from time `t` that is sent `u` (rad).
    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        u
    }

    /// Whether it acts on the thrust that the blades make of their angle, and so behind all that acts on the angle.
    fn of_thrust(&self) -> bool {
        false
    }

    /// Changes the parameters as of time `t`.
    fn plant(&self, _t: f64, _plant: &mut Plant) {}

    /// Called before a tick that ends at `t`, for effects that prepare a signal of their own.
    fn prepare(&mut self, _t: f64) {}

    /// Moment on the airframe at time `t`, state `x` and blade pitch `blade` (rad), N m.
    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        0.0
    }

    /// Dry friction at the state `x` against a rate upward, and downward, N m.
    fn dry_friction(&self, _x: &State) -> [f64; 2] {
        [0.0; 2]
    }

    /// The signals beside those of the pitch axis that it needs; none on a test-bed that frees pitch alone.
    fn others(&self) -> Others {
        Others::default()
    }

    /// Called before each step, with what goes on in its middle beside the pitch axis.
    fn beside(&mut self, _now: &Beside) {}

    /// Carries states of the effect's own over a step that the aircraft has made.
    fn follow(&mut self, _motion: &Motion) {}

    /// Changes what the IMU reads at time `t`; called once per tick.
    fn measure(&mut self, _t: f64, _reading: &mut Reading) {}

    /// Limits what the IMU says, noise included; doing it twice is doing it once.
    fn limit(&self, _reading: &mut Reading) {}

    /// The time window outside which the effect is not there, s.
    fn window_s(&self) -> Option<[f64; 2]> {
        None
    }
}

/// One integration step of the aircraft.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// When it began, s.
    pub t: f64,
    /// Its length, s.
    pub dt: f64,
    /// The plant during it.
    pub plant: Plant,
    /// What the blades did, rad.
    pub blade: f64,
    /// The state at its beginning.
    pub before: State,
    /// The state at its end.
    pub after: State,
}

/// One effect of a list.
pub struct Entry {
    /// Its name, the same in truth files, model files and diagnoses.
    pub id: &'static str,
    /// Where it sits: `actuator`, `pitch_moment`, `sensor`, `timing` or `environment`.
    pub locus: &'static str,
    /// Its parameters; the first is the one that sets the size.
    pub parameters: &'static [Parameter],
    /// Sizes that cost a model without the effect about 5 points of VAF on held-out sections, and about 10, or
    /// the nearest that the usual range allows.
    ///
    /// Median cost over eight seeds of the nominal plant, campaign 4, 0.015 rad, background `Clean`, as
    /// defined in [`crate::calibrate`] and printed by `examples/effect_costs.rs`.
    pub moderate_and_strong: [f64; 2],
    /// For physics outside the catalogue, the ids in it that come near: a diagnosis that names one of them is
    /// wrong, but not far off.
    pub near: &'static [&'static str],
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

impl Entry {
    /// The entry called `id`.
    ///
    /// # Errors
    /// No such effect.
    pub fn find(id: &str) -> Result<&'static Self, Error> {
        every().find(|entry| entry.id == id).ok_or_else(|| {
            let known: Vec<&str> = every().map(|entry| entry.id).collect();
            Error::UnknownEffect { id: id.to_owned(), known: known.join(", ") }
        })
    }

    /// Parameters log-uniform in their range, signs by lot.
    pub(crate) fn drawn(&'static self, generator: &mut Pcg64) -> Setting {
        let value = self.parameters.iter().map(|p| {
            let [low, high] = p.range;
            let magnitude = low * (high / low).powf(generator.random());
            if p.signed && generator.random_bool(0.5) { -magnitude } else { magnitude }
        });
        self.setting(value.collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aircraft::Aircraft;

    /// A rigid plant that nothing damps.
    pub(super) const FREE: Plant = Plant { mount: None, dm_dq: 0.0, ..Plant::nominal() };

    /// The free plant with one effect, from `start`, without commands.
    pub(super) fn fly_freely(id: &str, parameters: &[(&str, f64)], start: State, ticks: usize) -> Aircraft {
        let mut aircraft = Aircraft::new(FREE, &[Setting::new(id, parameters).unwrap()], None, 0);
        aircraft.set_state(start);
        (0..ticks).for_each(|_| aircraft.advance(0.0));
        aircraft
    }

    #[test]
    fn ids_are_unique_and_every_effect_has_a_size() {
        for (i, entry) in every().enumerate() {
            assert!(every().take(i).all(|other| other.id != entry.id), "{}", entry.id);
            assert!(entry.near.iter().all(|id| CATALOGUE.iter().any(|near| near.id == *id)), "{}", entry.id);
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
