//! Missing physics: located, named, modelled, and shown to pay.

mod account;
pub mod anonymous;
pub mod answer;
pub mod baseline;
pub mod beginning;
pub mod consistency;
mod diagnose;
pub mod dull;
pub mod effects;
mod excitation;
mod experiment;
pub mod free_run;
pub mod goodness;
pub mod gust;
pub mod held_out;
pub mod judge;
mod judgement;
pub mod locate;
pub mod over_time;
mod placebo;
pub mod problem;
pub mod rank;
pub mod scaled;
pub mod search;
pub mod unlisted;
pub mod words;

pub use diagnose::{Diagnosis, diagnose};
