//! Models of the pitch dynamics.

pub mod file;
pub mod grey_box;
pub mod kalman;
pub mod pitch;
pub mod sampled;
mod shift;
pub mod state_space;
mod transition;
