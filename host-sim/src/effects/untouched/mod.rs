//! Physics that no catalogue has, and that nobody tunes a diagnosis on: for an honest figure, once.

pub(super) mod local_friction;
pub(super) mod slung_load;
pub(super) mod voltage_droop;

use super::{Effect, Entry, Motion, Parameter};
