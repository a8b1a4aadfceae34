//! The flight image's parts that need no chip: drivers over `embedded-hal`, attitude estimate, servo outputs, the
//! MAVLink link, parameters and the record that survives a reset. The binaries in `src/bin` wire them to the STM32F405.
//!
//! ```text
//!  TIM2, 50 Hz, highest priority              idle
//!  IMU or HIL ─> pitch filter ─> Cycle::step ──> reports ──> telemetry ─┐
//!                     ^              ├──> Watch::step ──> verdict ──>────┤
//!                     │              │                                  ├─> USART2 ─> ground
//!                     │              └──> servos (neutral unless armed) │
//!                     └── command, reference, HIL sample <── Ground <───┘
//! ```
//!
//! Nothing here panics on what comes over the wire or from a sensor.
#![cfg_attr(not(test), no_std)]

pub mod deadline;
pub mod digest;
pub mod hil;
pub mod imu;
pub mod link;
pub mod parameters;
pub mod pitch_filter;
pub mod reset_record;
pub mod servo;
pub mod settings;
pub mod store;
pub mod watch;
