#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(test)]
extern crate std;

pub mod attitude;
pub mod cause;
pub mod config;
pub mod constants;
pub mod convergence;
pub mod cycle;
pub mod decimal;
pub mod delay_line;
pub mod health;
pub mod lms;
pub mod monitor;
pub mod plan;
pub mod prbs;
pub mod supervisor;
pub mod telemetry;
pub mod vehicle;

mod config_error;
mod input;

pub use attitude::AttitudeConfig;
pub use cause::{Event, Fault, Trip};
pub use config::{Config, ConfigError};
pub use convergence::{Convergence, Verdict};
pub use cycle::{Cycle, CycleState};
pub use plan::Section;
pub use supervisor::Phase;
pub use telemetry::{Command, Input, Sample, Telemetry};
pub use vehicle::{Vehicle, fly, turn};
