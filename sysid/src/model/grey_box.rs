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
        if let Some(gust) = disturbance.gust {
            a[(Q, GUST)] = 1.0 / iyy;
            a[(GUST, GUST)] = -1.0 / gust.time_constant;
        }
        a
    }

    /// The states that the IMU measures: (rate, angle).
    pub fn measured(&self) -> (usize, usize) {
        if self.mount.is_some() { (Q_IMU, THETA_IMU) } else { (Q, THETA) }
    }
}

/// Coloured disturbance moment, and the white noise of the sensors, relative to the noise of the first channel.
///
/// The moment has the spectrum S(ω) = σ² (z² + ω²) / ((ω₀² − ω²)² + (2ζω₀ω)²): a low pass for large z, a band pass for
/// z → 0; two real poles for ζ ≥ 1, a resonance below. A gust adds 2 σw² T / (1 + T²ω²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// σ: intensity of the driving noise relative to the noise of the first measured channel.
    pub intensity: f64,
    /// Natural frequency ω₀ of the two poles, rad/s.
    pub frequency: f64,
    /// Damping ratio ζ of the two poles.
    pub damping: f64,
    /// Zero z, rad/s.
    pub zero: f64,
    /// Noise of the angle relative to the noise of the rate, s.
    pub angle_noise: f64,
    /// A gust beside it.
    pub gust: Option<Gust>,
}

/// A moment T ẇ = −w + n'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gust {
    /// σw: standard deviation of the moment relative to the noise of the first measured channel.
    pub sigma: f64,
    /// T, s.
    pub time_constant: f64,
}

impl Disturbance {
    /// The moment M_w at state `x`, N m.
    pub fn moment(&self, x: &State) -> f64 {
        self.zero * x[DISTURBANCE] + x[DISTURBANCE + 1] + x[GUST]
    }

    /// Spectral density of the moment at `omega` rad/s, up to the scale of the noise.
    pub fn spectrum(&self, omega: f64) -> f64 {
        let square = |x: f64| x * x;
        let gust = self.gust.map_or(0.0, |Gust { sigma, time_constant: t }| {
            2.0 * square(sigma) * t / (1.0 + square(t * omega))
        });
        gust + square(self.intensity) * (square(self.zero) + square(omega))
            / (square(square(self.frequency) - square(omega))
                + square(2.0 * self.damping * self.frequency * omega))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Complex, SMatrix};

    #[test]
    fn the_spectrum_is_that_of_the_states() {
        let plant = Plant { inertia: 0.2, dm_dq: -0.3, dm_du: 20.0, delay: 0.0, mount: None };
        let gust = Gust { sigma: 0.7, time_constant: 0.6 };
        let disturbance = Disturbance {
            intensity: 3.0,
            frequency: 5.0,
            damping: 0.4,
            zero: 0.8,
            angle_noise: 1.0,
            gust: Some(gust),
        };
        let a = plant.state_matrix(0.0, 0.0, &disturbance);
        let mut block = SMatrix::<Complex<f64>, 3, 3>::zeros();
        let drives = [disturbance.intensity, gust.sigma * (2.0 / gust.time_constant).sqrt()];
        for omega in [0.3_f64, 2.0, 4.9, 20.0] {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let s = if i == j { Complex::new(0.0, omega) } else { Complex::from(0.0) };
                block[(i, j)] = s - a[(DISTURBANCE + i, DISTURBANCE + j)];
            }
            let response = block.try_inverse().unwrap();
            let moment = |driven: usize| {
                (0..3)
                    .map(|i| response[(i, driven)] * (a[(Q, DISTURBANCE + i)] * plant.inertia))
                    .sum::<Complex<f64>>()
            };
            let power = (moment(1) * drives[0]).norm_sqr() + (moment(2) * drives[1]).norm_sqr();
            assert!((power / disturbance.spectrum(omega) - 1.0).abs() < 1e-12, "{omega}");
        }
    }
}
