//! The link to the ground: MAVLink 2, common dialect.
//!
//! | in | out |
//! | --- | --- |
//! | `COMMAND_LONG`: arm, HIL mode, start and abort a test, ask for the taps | `COMMAND_ACK`, `STATUSTEXT` |
//! | `PARAM_REQUEST_LIST`, `PARAM_REQUEST_READ`, `PARAM_SET` | `PARAM_VALUE` |
//! | `HIL_SENSOR`, one cycle each | `HIL_ACTUATOR_CONTROLS` |
//! | `MANUAL_CONTROL`: x is the pitch reference of section IV | `DEBUG_FLOAT_ARRAY` `cycle`, `taps` |
//! | `DEBUG_FLOAT_ARRAY` `model`: the monitor's model in pieces | the same: what has come |
//! | `SETUP_SIGNING` | `HEARTBEAT`, `ATTITUDE`, `NAMED_VALUE_FLOAT`: the monitor's evidence |

pub mod decoder;
pub mod frame;
pub mod ground;
pub mod signing;
pub mod telemetry;
pub mod upload;

pub use ground::{Action, Ground};
