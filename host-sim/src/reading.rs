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

/// Which signals beside those of the pitch axis there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Others {
    /// The vehicle rolls: `p_rad_s`, `phi_rad`, and `r_rad_s` of nought with its noise.
    pub roll: bool,
    /// It yaws: `r_rad_s`.
    pub yaw: bool,
    /// The command of the roll axis is logged: `u_roll_rad`.
    pub roll_command: bool,
    /// The collective thrust changes: `thrust_norm`.
    pub thrust: bool,
    /// The battery empties: `battery_v`.
    pub battery: bool,
}

impl Others {
    /// Those of either.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            roll: self.roll || other.roll,
            yaw: self.yaw || other.yaw,
            roll_command: self.roll_command || other.roll_command,
            thrust: self.thrust || other.thrust,
            battery: self.battery || other.battery,
        }
    }
}

/// What goes on beside the pitch axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// Motion about the other axes.
    pub roll_yaw: RollYaw,
    /// Command of the roll axis, in the unit of the pitch axis' own.
    pub u_roll: f64,
    /// Collective command, as a share of full thrust.
    pub thrust: f64,
    /// Supply voltage, V.
    pub battery_v: f64,
}

impl Beside {
    /// (T − T̄)/T̄, T̄ the collective thrust of hover.
    #[must_use]
    pub fn thrust_above_hover(&self) -> f64 {
        self.thrust / Self::default().thrust - 1.0
    }
}

impl Default for Beside {
    /// A vehicle that hovers on a battery of its nominal voltage, four cells of 3.7 V.
    fn default() -> Self {
        Self { roll_yaw: RollYaw::default(), u_roll: 0.0, thrust: 0.5, battery_v: 14.8 }
    }
}
