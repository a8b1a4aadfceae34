//! Physics that no catalogue has.

pub(super) mod angle_damping;
pub(super) mod command_quantiser;
pub(super) mod gust_burst;
pub(super) mod intermittent_delay;
pub(super) mod missed_frames;
pub(super) mod rate_dependent_thrust;
pub(super) mod servo_hunting;
mod spans;
pub(super) mod vibration_rectification;

use super::{Effect, Entry, Motion, Parameter};
