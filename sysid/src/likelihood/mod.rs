//! The likelihood of data under a model: the unknowns, the predictor, fits, free runs.

pub mod blow_up;
pub mod contest;
pub mod evidence;
mod first_counted;
pub mod fit;
pub mod free_run;
pub mod horizon;
mod known_drives;
pub mod precision;
pub mod problem;
pub mod sensor_noise;
