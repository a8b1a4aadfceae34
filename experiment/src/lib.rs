//! The experiment before it is flown.
//!
//! ```text
//! a model, or size and mass ── Craft ─┐
//! limits, accuracy ───────── Wishes ──┼─> candidates ──> the best, one test or two ──> length ──> forecast ──> Plan
//! two rivals of a diagnosis ─ Rivals ─┘    (largest amplitude that the limits bear, by dwell)
//! ```
//!
//! | question | where |
//! | --- | --- |
//! | what is known of the craft, and how it may be | [`craft`] |
//! | one test as the board flies it | [`mod@test`] |
//! | how far it goes, how often the supervisor holds it, what its recording tells | [`forecast`] |
//! | whether it tells two rivals apart | [`rivals`] |
//! | which excitations come into question | [`search`] |
//! | the whole | [`plan()`] |
//! | the board's parameters in a file | [`parameters`] |
//!
//! Every test is flown by the core in the simulator (`host-sim`) and estimated from by `sysid`; recordings cross, as CSV. The same
//! wishes give the same plan, whatever the number of threads.

pub mod craft;
mod error;
pub mod forecast;
pub mod parameters;
mod plan;
pub mod rivals;
pub mod search;
pub mod test;
pub mod vehicle;
mod wishes;

pub use craft::Craft;
pub use error::Error;
pub use plan::{Considered, Plan, PlannedTest, plan};
pub use rivals::{Chance, Rivals};
pub use test::{Test, Weather};
pub use wishes::Wishes;

/// Named, so that its stream stays the same.
type Rng = rand_pcg::Pcg64;
