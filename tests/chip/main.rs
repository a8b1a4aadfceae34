//! The flight image on the emulated chip.
//!
//! | module | what it is about |
//! | --- | --- |
//! | `flight` | a whole test, against the host's run of the same core |
//! | `attacks` | somebody else on the link |
//! | `failsafe` | the ways in which the image gives up |
//! | `faults` | sensors, orders and frames that are not as they should be |
//! | `ground` | `pitchid fly` flies the chip |
//! | `monitor` | the monitor over the link and out of the flash |
//! | `settings` | what the flash held before the power came |
//! | `upsets` | limits hit, resets, floods |

mod attacks;
mod failsafe;
mod faults;
mod flight;
mod ground;
mod monitor;
mod settings;
mod upsets;
