//! Missing physics: located, named, modelled, and shown to pay.

pub mod answer;
mod building;
pub mod change_point;
pub mod consistency;
pub mod data_checks;
pub mod describe;
mod diagnose;
pub mod evaluation;
mod excitation;
mod experiment;
pub mod goodness;
pub mod gust;
pub mod locate;
pub mod over_time;
mod placebo;
pub mod remainder;
mod search;
pub mod selection;
mod verdict;

pub use diagnose::{Diagnosis, diagnose};
