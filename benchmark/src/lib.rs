//! How well the diagnosis does, counted so that anyone can count again.
//!
//! | question | call |
//! | --- | --- |
//! | how often is concealed physics found, with sealed truths | [`Proof`] |
//! | what the paper's methods reach in the simulator, in its Table 2 and figures | [`reproduce::paper`] |
//! | what the diagnosed model reaches in public benchmarks | [`reproduce::benchmarks`] |
//! | whether the monitor tells a change, and tests go as they were planned | [`reproduce::monitor`], [`reproduce::plans`] |
//! | what the supervisor promises where tests go wrong, and whether it holds | [`reproduce::supervisor`] |
//!
//! The simulator (`host-sim`) and the diagnosis (`sysid`) meet here and nowhere below: recordings cross, as CSV. Both
//! questions leave a folder of files that need nothing else; the same seed gives the same bytes.

mod black_box;
mod conceal;
mod confusion;
mod error;
pub mod files;
pub mod html;
mod judge;
mod page;
mod prove;
pub mod reproduce;
pub mod seal;
mod sparse;
mod tally;
mod truth;

pub use conceal::{Case, conceal, nominal};
pub use error::Error;
pub use prove::{Proof, answer};
pub use tally::Table;
