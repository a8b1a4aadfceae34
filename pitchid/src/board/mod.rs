//! A flight image on the other end of a line: MAVLink 2 to it, recordings from it.

mod cycle;
mod key;
mod link;
mod log;
mod port;
mod station;
pub mod taps;
mod texts;
mod upload;

pub use cycle::{CycleReport, Phase};
pub use key::Key;
pub use log::Log;
pub use port::Port;
pub use station::{Heard, Station};

use crate::failure::Failure;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C.
#[derive(Clone)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// From now on Ctrl-C asks for an orderly end.
    pub fn on_ctrl_c() -> Result<Self, Failure> {
        let flag = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&flag);
        ctrlc::set_handler(move || set.store(true, Ordering::Relaxed)).map_err(|error| {
            Failure::new(format!("Ctrl-C cannot be caught: {error}"), "run it in a terminal")
        })?;
        Ok(Self(flag))
    }

    /// Whether it has been pressed.
    pub fn wanted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
