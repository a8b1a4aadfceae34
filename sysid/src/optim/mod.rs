//! Optimisation: bounded Levenberg–Marquardt for prediction errors, chords, minimax.

pub mod chord;
pub mod levenberg_marquardt;
pub mod minimax;
