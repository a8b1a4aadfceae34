//! Physics that no catalogue has, and that nobody tunes a diagnosis on: for an honest figure, once.

pub(super) mod local_friction;
pub(super) mod sagging_supply;
pub(super) mod sticky_end;

use super::{Effect, Entry, Parameter};
