//! Identification and diagnosis of pitch attitude dynamics, from recordings alone.
//!
//! ```text
//! recordings ── checks ──> dataset ──┬─> identify: taps, state space, grey box ──> validate (VAF on held-out data)
//!                                    └─> diagnosis: where does the model differ, what is missing, does it pay
//! ```
//!
//! | question | call |
//! | --- | --- |
//! | read a recording, with everything that is odd about it | [`recording::read`] |
//! | the impulse response that the autopilot would have estimated | [`identify::lms::replay`] |
//! | a state space from an impulse response | [`identify::kung::realise`] |
//! | an unstructured impulse response, and the best VAF that any linear model could reach | [`identify::fir`] |
//! | a state space from the data, order and block size by cross-validation | [`identify::cross_validation::cross_validated`] |
//! | the grey box by maximum likelihood; its delay, and what the data cannot tell | [`identify::output_error`] |
//! | the grey box nearest to a state space in the H∞ norm | [`identify::hinf_match::hinf_match`] |
//! | all methods side by side, on sections that none has seen | [`identify::compare::identify`] |
//! | whether errors are white, or hold something of the input; response and coherence without a model | [`validate`] |
//! | what the user's simulation leaves out | [`diagnosis::diagnose`] |
//! | what changed on a craft between two recordings | [`compare::compare`] |
//!
//! The symbols are those of [`model::plant`]. Every estimate is an [`estimate::Estimate`]: value, unit, interval.
//! Errors are [`error::Error`]: what was found, where, what to do. Nothing here knows the simulator.

pub mod catalogue;
pub mod compare;
pub mod dataset;
pub mod diagnosis;
pub mod error;
pub mod estimate;
pub mod files;
pub mod held_out;
pub mod identify;
pub mod legal;
pub mod likelihood;
mod linalg;
pub mod model;
pub mod monitor;
pub mod moving_mean;
pub mod optim;
pub mod progress;
pub mod recording;
pub mod toml_file;
pub mod validate;
