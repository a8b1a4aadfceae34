//! A pitch test-bed in `f64`, flown by the very core that flies the real one.
//!
//! ```text
//! Scenario ── fly ──> estimator-core: PRBS, supervisor, controller, NLMS     (f32, 50 Hz)
//!                        │ u                                   ^ q, θ
//!                        v                                     │
//!                     Aircraft: delay → effects → eq. 9 → sensors            (f64, RK4, ≤ 1 ms)
//!                        │
//!                     Flight: recording (what a rig would log) │ truth (apart)
//! ```
//!
//! The recording holds what a real rig would have logged and nothing else. What was concealed in the aircraft,
//! its true parameters and the disturbance are in the truth, which goes to a file of its own. The
//! identification side of the project never links this crate, and this crate never links it: only recordings
//! cross.
//!
//! | module | what |
//! | --- | --- |
//! | [`scenario`] | what to fly: dwell, amplitude, seed, plant, effects, background, air |
//! | [`flight`] | flies it; recording and truth |
//! | [`plant`] | the grey-box plant and its integration, with sticking friction |
//! | [`effects`] | physics that can be concealed, one file each |
//! | [`aircraft`] | delay, effects and plant over one tick |
//! | [`disturbance`], [`sensors`], [`pilot`] | coloured moments, measurement noise, the pilot |
//! | [`air`] | kinds of background |
//! | [`surroundings`] | roll, yaw, thrust and battery beside the pitch axis |
//! | [`reading`], [`recording`] | what the IMU reads, and the rows that a rig would log |
//! | [`mod@bench`], [`excitation`] | tests without the core: steps, ring-downs, tones, dead tails, any rate of the log |
//! | [`free_flight`] | three axes under a controller of 500 Hz |
//! | [`table`], [`dirt`] | a recording of any columns, and what happens to it on the way to a file |
//! | [`proof_case`] | a case of a proof, drawn by a seed: what is concealed, how large, before which background |
//! | [`fault`], [`hazard`] | what breaks on a vehicle; a test that goes wrong, drawn by a seed |
//! | [`calibrate`] | what an effect costs a model that leaves it out, and the size for a given cost |
//!
//! Everything random hangs on the scenario's seed: the same scenario gives the same bytes.

pub mod air;
pub mod aircraft;
pub mod bench;
pub mod calibrate;
pub mod dirt;
pub mod disturbance;
pub mod effects;
pub mod error;
pub mod excitation;
pub mod fault;
pub mod flight;
pub mod free_flight;
pub mod hazard;
pub mod pilot;
pub mod plant;
pub mod proof_case;
pub mod reading;
pub mod recording;
pub mod scenario;
pub mod seeds;
pub mod sensors;
pub mod surroundings;
pub mod table;
pub mod vehicle;

pub use air::Air;
pub use bench::{Bench, Logged};
pub use calibrate::{cost_of_leaving_out, size_for_loss};
pub use effects::{CATALOGUE, OUTSIDE, Setting, UNTOUCHED};
pub use error::Error;
pub use excitation::Input;
pub use flight::{Flight, air_of, fly, fly_in};
pub use free_flight::FreeFlight;
pub use plant::{Mount, Plant};
pub use reading::Others;
pub use scenario::{Background, Scenario};
pub use table::Table;
