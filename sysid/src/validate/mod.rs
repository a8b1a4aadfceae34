//! How good a model is, on data it has not seen.

pub mod coherence;
pub mod cross_correlation;
pub mod cross_spectrum;
pub mod vaf;
pub mod whiteness;

/// Odds that a test rejects what is true.
pub const ODDS: f64 = 0.01;
