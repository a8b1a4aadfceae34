//! Methods that turn data into models.

pub mod block_hankel;
pub mod bootstrap;
pub mod butterworth;
pub mod compare;
pub mod continuous;
pub mod cross_validation;
pub mod fir;
pub mod hinf_match;
pub mod hinf_norm;
mod input_fit;
pub mod kung;
pub mod linear_model;
pub mod lms;
pub mod output_error;
pub mod pi_moesp;
