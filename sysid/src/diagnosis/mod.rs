//! Missing physics: located, named, modelled, and shown to pay.

pub mod answer;
pub mod baseline;
mod diagnose;
pub mod effects;
mod excitation;
mod experiment;
pub mod free_run;
pub mod held_out;
pub mod judge;
pub mod locate;
pub mod problem;
pub mod rank;
pub mod search;
pub mod words;

pub use diagnose::{Diagnosis, diagnose};
