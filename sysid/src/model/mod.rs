//! Models of the pitch dynamics.

pub mod file;
pub mod grey_box;
pub mod kalman;
pub mod pitch;
pub mod sampled;
pub mod state_space;
