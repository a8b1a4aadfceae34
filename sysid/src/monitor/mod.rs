//! What the board's monitor needs to know of an identified vehicle, and its replay over a recording.
//!
//! The innovations form of the likelihood's own predictor (steady Kalman gain of the fitted noise model), its innovations whitened,
//! in balanced coordinates with at most six states ([`reduced`]); for every cause the sizes at which it is tested, the dead zone
//! below which it is no change, and how far its score is from what white innovations would give.

pub mod design;
pub mod file;
pub mod reduced;
pub mod replay;

pub use design::{Design, design};
pub use file::{parse_monitor, read_monitor};
pub use replay::{Row, replay};
