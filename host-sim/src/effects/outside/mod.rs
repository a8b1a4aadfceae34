//! Physics that no catalogue has.

pub(super) mod angle_damping;
pub(super) mod asymmetric_thrust;
pub(super) mod command_quantiser;
pub(super) mod ground_effect;
pub(super) mod gust_burst;
pub(super) mod hysteretic_spring;
pub(super) mod intermittent_delay;
pub(super) mod missed_frames;
pub(super) mod moment_window;
pub(super) mod periodic_moment;
pub(super) mod rate_dependent_thrust;
pub(super) mod servo_resonance;
mod spans;
pub(super) mod stribeck_friction;
pub(super) mod vibration_rectification;

use super::{Effect, Entry, Motion, Parameter};
