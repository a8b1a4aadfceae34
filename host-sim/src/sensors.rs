//! What the IMU says: white noise on rate, angle and acceleration.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use serde::Serialize;

use crate::reading::{Reading, RollYaw};

/// Standard deviations of the noise, per sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// On q, rad/s; 0.01 to 0.02 is a small gyro on a machine that vibrates.
    pub q_rad_s: f64,
    /// On θ, rad.
    pub theta_rad: f64,
    /// On q̇, rad/s².
    pub qdot_rad_s2: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self { q_rad_s: 0.015, theta_rad: 0.0025, qdot_rad_s2: 0.5 }
    }
}

impl Noise {
    /// No noise at all.
    #[must_use]
    pub const fn none() -> Self {
        Self { q_rad_s: 0.0, theta_rad: 0.0, qdot_rad_s2: 0.0 }
    }

    /// The same noise, that of the gyros `factor` times as strong.
    #[must_use]
    pub fn with_gyros_times(&self, factor: f64) -> Self {
        Self { q_rad_s: factor * self.q_rad_s, ..*self }
    }

    /// Adds one sample of noise.
    pub fn add(&self, reading: &mut Reading, generator: &mut Pcg64) {
        let mut draw = || -> f64 { StandardNormal.sample(generator) };
        reading.q += self.q_rad_s * draw();
        reading.theta += self.theta_rad * draw();
        reading.q_dot += self.qdot_rad_s2 * draw();
    }

    /// Adds one sample of noise about the other axes: gyros and angles alike.
    pub fn add_roll_yaw(&self, motion: &mut RollYaw, generator: &mut Pcg64) {
        let mut draw = || -> f64 { StandardNormal.sample(generator) };
        motion.p += self.q_rad_s * draw();
        motion.r += self.q_rad_s * draw();
        motion.phi += self.theta_rad * draw();
    }
}
