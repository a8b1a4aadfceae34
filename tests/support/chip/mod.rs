//! The flight image on the emulated chip: starts it, speaks MAVLink with it, flies the simulated aircraft with it.

pub mod case;
pub mod debugger;
pub mod emulator;
pub mod flash;
pub mod pilot;
pub mod twin;

pub use debugger::Debugger;
pub use emulator::Emulator;
pub use flash::Flash;
pub use pilot::Pilot;
pub use twin::{Simulated, Twin};
