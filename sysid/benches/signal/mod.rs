//! The input of the benchmarks, and their random numbers.

/// Numbers in [0, 1) of a linear congruential generator.
pub fn uniform(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Two-level input of 0.015 rad with switches every 20 to 40 samples.
pub struct TwoLevel {
    level: f64,
    left: usize,
}

impl TwoLevel {
    pub fn new() -> Self {
        Self { level: 0.015, left: 0 }
    }

    /// The next sample; a switch draws the time to the one after it.
    pub fn next(&mut self, uniform: &mut impl FnMut() -> f64) -> f64 {
        if self.left == 0 {
            self.level = -self.level;
            self.left = 20 + (20.0 * uniform()) as usize;
        }
        self.left -= 1;
        self.level
    }
}
