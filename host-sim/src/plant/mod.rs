//! The pitch plant: parameters, equations of motion, integration.

mod dynamics;
mod parameters;

pub use dynamics::{Loads, State};
pub use parameters::{Mount, Plant};
