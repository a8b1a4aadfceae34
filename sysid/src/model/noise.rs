//! The noise model: a coloured disturbance moment and the white noise of the sensors.

use super::plant::{DISTURBANCE, GUST, State};

/// Coloured disturbance moment, and the white noise of the sensors, relative to the noise of the first channel.
///
/// The moment has the spectrum S(ω) = σ² (z² + ω²) / ((ω₀² − ω²)² + (2ζω₀ω)²): a low pass for large z, a band pass for
/// z → 0; two real poles for ζ ≥ 1, a resonance below. A gust adds 2 σw² T / (1 + T²ω²), a roll-off divides by 1 + T²ω².
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
    /// A third pole: a gust beside it, or a further roll-off.
    pub third: Option<Third>,
    /// g: by how much q, x₁ and x₂ are corrected by what is new in the command, relative to the noise of the first measured channel.
    pub corrects: Option<[f64; 3]>,
}

/// The third pole of the noise model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Third {
    /// A moment of its own beside the two poles'.
    Gust(Gust),
    /// The two poles' moment passes one more low pass, T ẇ = −w + M.
    RollOff {
        /// T, s.
        time_constant: f64,
    },
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
        match self.third {
            Some(Third::RollOff { .. }) => x[GUST],
            _ => self.zero * x[DISTURBANCE] + x[DISTURBANCE + 1] + x[GUST],
        }
    }

    /// Spectral density of the moment at `omega` rad/s, up to the scale of the noise.
    pub fn spectrum(&self, omega: f64) -> f64 {
        let square = |x: f64| x * x;
        let pole = |t: f64| 1.0 / (1.0 + square(t * omega));
        let poles = square(self.intensity) * (square(self.zero) + square(omega))
            / (square(square(self.frequency) - square(omega))
                + square(2.0 * self.damping * self.frequency * omega));
        match self.third {
            None => poles,
            Some(Third::Gust(Gust { sigma, time_constant: t })) => poles + 2.0 * square(sigma) * t * pole(t),
            Some(Third::RollOff { time_constant }) => poles * pole(time_constant),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::plant::{Plant, Q};
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
            third: Some(Third::Gust(gust)),
            corrects: None,
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
