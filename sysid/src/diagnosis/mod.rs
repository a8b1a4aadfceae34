//! Missing physics: located, named, modelled, and shown to pay.
//!
//! ```text
//! checks of the data ──> selection (every model one number) ──> rotation (each section held out once)
//!        │                       │                                     │
//!        └──> check_data         └──> tests of what is left ──> verdict ──> answer
//! ```

pub mod adequacy;
mod another_value;
mod another_zero;
pub mod answer;
pub mod axes;
pub mod axis_words;
mod balance;
mod between_rows;
mod building;
pub mod candidates;
mod ceiling;
mod change_point;
pub mod component;
pub mod data_checks;
mod describe;
mod diagnose;
mod estimates;
mod excerpt;
mod excitation;
mod experiment;
#[cfg(test)]
mod fixture;
mod gust;
mod input_hold;
mod input_line;
mod judgement;
pub mod left_over;
pub mod levels;
mod locate;
pub mod map;
mod materiality;
pub mod over_time;
mod parts;
mod past_alone;
mod posterior;
mod predicted;
mod prior;
pub mod questions;
mod remainder;
mod rotation;
mod search;
mod selection;
mod shape_in_words;
pub mod shared;
pub mod spectra;
pub mod step_response;
pub mod traces;
pub mod verdict;

pub use diagnose::{Diagnosis, diagnose, diagnose_with};
