//! What the IMU reads, and the motion about the other axes that it sees: plain data for effects, plant and sensors.

/// One reading of the IMU.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Pitch rate, rad/s.
    pub q: f64,
    /// Pitch angle, rad.
    pub theta: f64,
    /// Pitch acceleration, rad/s².
    pub q_dot: f64,
    /// Roll and yaw.
    pub roll_yaw: RollYaw,
}

/// Motion about the other axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollYaw {
    /// Roll rate, rad/s.
    pub p: f64,
    /// Yaw rate, rad/s.
    pub r: f64,
    /// Roll angle, rad.
    pub phi: f64,
}
