//! The grey-box pitch plant (Riccardi, Panizza, Lovera, ERF 2014, eq. 9 and 10) in continuous time.
//!
//! ```text
//! Iyy q̇  = (∂M/∂q) q + (∂M/∂u) u(t−τ) + k (θP−θ) + c (qP−q) + M_w
//! J   q̇P = −k (θP−θ) − c (qP−q)          θ̇ = q,  θ̇P = qP
//! M_w = z x₁ + x₂ + w,  ẋ₁ = x₂,  ẋ₂ = −ω₀² x₁ − 2ζω₀ x₂ + n,  T ẇ = −w + n'     coloured disturbance moment
//! ```
//!
//! The state is always (q, qP, θ, θP, qF, x₁, x₂, w), qF the rate behind a gyro's filter and w a gust. Without a mount the IMU sits
//! rigidly on the airframe and rows qP, θP stay zero; without a filter so does qF.

use super::noise::{Disturbance, Third};
use nalgebra::{SMatrix, SVector};

/// Number of states of the airframe, its mount and the disturbance together.
pub const STATES: usize = 8;
/// State matrix, per second.
pub type StateMatrix = SMatrix<f64, STATES, STATES>;
/// State vector (q, qP, θ, θP, qF, x₁, x₂, w) in rad/s, rad/s, rad, rad, rad/s, N m s, N m, N m.
pub type State = SVector<f64, STATES>;

/// Index of the pitch rate of the airframe.
pub const Q: usize = 0;
/// Index of the pitch rate of the IMU on its mount.
pub const Q_IMU: usize = 1;
/// Index of the pitch angle of the airframe.
pub const THETA: usize = 2;
/// Index of the pitch angle of the IMU on its mount.
pub const THETA_IMU: usize = 3;
/// Index of the pitch rate behind the gyro's filter.
pub const GYRO: usize = 4;
/// Index of the first disturbance state.
pub const DISTURBANCE: usize = 5;
/// Index of the gust's moment.
pub const GUST: usize = 7;

/// The vibration-damping mount of the IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// Stiffness k, N m/rad, positive.
    pub stiffness: f64,
    /// Damping c, N m s/rad, not negative.
    pub damping: f64,
    /// Moment of inertia J of what the mount carries, kg m², positive.
    pub inertia: f64,
}

impl Mount {
    /// The mount with undamped frequency `mode_hz` in Hz and damping ratio `zeta`, carrying `inertia` in kg m².
    pub fn from_mode(mode_hz: f64, zeta: f64, inertia: f64) -> Self {
        let omega = core::f64::consts::TAU * mode_hz;
        Self { stiffness: inertia * omega * omega, damping: 2.0 * zeta * omega * inertia, inertia }
    }
}

/// Parameters of the pitch plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Iyy, kg m²; 1 where the inertia is unknown, and every moment is then per unit inertia.
    pub inertia: f64,
    /// ∂M/∂q, N m s/rad, not positive for a damped vehicle.
    pub dm_dq: f64,
    /// ∂M/∂u, N m per unit of the input.
    pub dm_du: f64,
    /// Loop delay τ, s, not negative.
    pub delay: f64,
    /// The IMU's mount; `None` where the IMU is fixed rigidly.
    pub mount: Option<Mount>,
}

impl Plant {
    /// The state matrix with a linear stiffness `k` in N m/rad and damping `c` in N m s/rad added to the airframe
    /// (the linear parts of the effects in use), and the disturbance driving the pitch moment.
    pub fn state_matrix(&self, k: f64, c: f64, disturbance: &Disturbance) -> StateMatrix {
        let mut a = StateMatrix::zeros();
        let iyy = self.inertia;
        a[(Q, Q)] = (self.dm_dq - c) / iyy;
        a[(Q, THETA)] = -k / iyy;
        a[(THETA, Q)] = 1.0;
        if let Some(mount) = self.mount {
            a[(Q, Q)] -= mount.damping / iyy;
            a[(Q, Q_IMU)] = mount.damping / iyy;
            a[(Q, THETA)] -= mount.stiffness / iyy;
            a[(Q, THETA_IMU)] = mount.stiffness / iyy;
            a[(Q_IMU, Q)] = mount.damping / mount.inertia;
            a[(Q_IMU, Q_IMU)] = -mount.damping / mount.inertia;
            a[(Q_IMU, THETA)] = mount.stiffness / mount.inertia;
            a[(Q_IMU, THETA_IMU)] = -mount.stiffness / mount.inertia;
            a[(THETA_IMU, Q_IMU)] = 1.0;
        }
        let Disturbance { frequency, damping, zero, .. } = *disturbance;
        a[(Q, DISTURBANCE)] = zero / iyy;
        a[(Q, DISTURBANCE + 1)] = 1.0 / iyy;
        a[(DISTURBANCE, DISTURBANCE + 1)] = 1.0;
        a[(DISTURBANCE + 1, DISTURBANCE)] = -frequency * frequency;
        a[(DISTURBANCE + 1, DISTURBANCE + 1)] = -2.0 * damping * frequency;
        match disturbance.third {
            None => {}
            Some(Third::Gust(gust)) => {
                a[(Q, GUST)] = 1.0 / iyy;
                a[(GUST, GUST)] = -1.0 / gust.time_constant;
            }
            Some(Third::RollOff { time_constant }) => {
                for (column, share) in [(DISTURBANCE, zero), (DISTURBANCE + 1, 1.0), (GUST, -1.0)] {
                    a[(GUST, column)] = share / time_constant;
                    a[(Q, column)] = 0.0;
                }
                a[(Q, GUST)] = 1.0 / iyy;
            }
        }
        a
    }

    /// The states that the IMU measures: (rate, angle).
    pub fn measured(&self) -> (usize, usize) {
        if self.mount.is_some() { (Q_IMU, THETA_IMU) } else { (Q, THETA) }
    }
}
