//! Models of the pitch dynamics.

pub mod baseline;
pub mod effect;
pub mod file;
pub mod innovation_filter;
pub mod kalman;
mod kick;
pub mod noise;
pub mod oscillator;
pub mod pitch;
pub mod plant;
pub mod sampled;
mod shift;
pub mod state_space;
mod transition;
