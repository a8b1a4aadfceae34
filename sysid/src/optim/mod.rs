//! Optimisation: bounded Levenberg–Marquardt for prediction errors, chords, linear least squares, minimax.

pub mod chord;
pub mod least_squares;
pub mod levenberg_marquardt;
pub mod minimax;
