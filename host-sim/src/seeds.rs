//! Independent random streams of one seed.

use rand::SeedableRng;
use rand_pcg::Pcg64;

/// What a stream is for. Each has its own, so drawing more of one leaves the others as they are.
#[derive(Clone, Copy, Debug)]
pub enum Stream {
    /// True plant.
    Plant = 1,
    /// Background moment.
    Background = 2,
    /// Sensor noise.
    Sensors = 3,
    /// Pilot's reference.
    Reference = 4,
    /// Which effect and how large.
    Choice = 5,
    /// Effects that are themselves random.
    Effect = 6,
    /// Sensor noise about the other axes.
    RollYaw = 7,
    /// Strength of the background, where it wanders.
    Strength = 8,
    /// Thrust and battery.
    Surroundings = 9,
    /// What happens to a finished recording.
    Dirt = 10,
    /// Excitation and set points of an experiment.
    Excitation = 11,
}

/// Generator of `stream` for `seed`.
#[must_use]
pub fn generator(seed: u64, stream: Stream) -> Pcg64 {
    // an odd multiplier keeps different seeds different in every stream
    Pcg64::seed_from_u64(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ ((stream as u64) << 56))
}
