//! Coloured moments, on a grid of 1 ms that hangs on the seed alone.
//!
//! * Band-passed: m = 2ζω s / (s² + 2ζω s + ω²) n. With n white of intensity S the variance is σ² = ζ ω S. It
//!   has no power at zero frequency and falls off on both sides, so no first-order model describes it.
//! * First order: T ṁ = −m + n, exactly discretised; variance σ².
//!
//! The grid does not depend on plant, delay or effects, so two flights with the same seed meet the same moment.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

const GRID_S: f64 = 1e-3;

/// Spectrum of a moment of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Colour {
    /// Centre ω (rad/s) and damping ratio ζ.
    BandPass {
        /// ω, rad/s.
        omega: f64,
        /// ζ.
        zeta: f64,
    },
    /// Time constant T, s.
    FirstOrder {
        /// T, s.
        time_constant_s: f64,
    },
}

/// A moment over time.
#[derive(Clone, Debug)]
pub struct ColouredMoment {
    sigma: f64,
    colour: Colour,
    generator: Pcg64,
    value: f64,
    integral: f64,
    grid: Vec<f64>,
}

impl ColouredMoment {
    /// Moment of standard deviation `sigma` (N m), at rest at t = 0.
    #[must_use]
    pub const fn new(sigma: f64, colour: Colour, generator: Pcg64) -> Self {
        Self { sigma, colour, generator, value: 0.0, integral: 0.0, grid: Vec::new() }
    }

    /// Makes sure that the moment is known up to `t_s`.
    pub fn extend_to(&mut self, t_s: f64) {
        let wanted = (t_s / GRID_S) as usize + 2;
        while self.grid.len() < wanted {
            self.grid.push(self.sigma * self.value);
            let noise: f64 = StandardNormal.sample(&mut self.generator);
            match self.colour {
                Colour::BandPass { omega, zeta } => {
                    let bandwidth = 2.0 * zeta * omega;
                    // intensity 1 / (ζω) gives unit variance
                    let kick = bandwidth * noise * (GRID_S / (zeta * omega)).sqrt();
                    self.value += GRID_S * (-bandwidth * self.value - omega * omega * self.integral) + kick;
                    self.integral += GRID_S * self.value;
                }
                Colour::FirstOrder { time_constant_s } => {
                    let keep = (-GRID_S / time_constant_s).exp();
                    self.value = keep * self.value + (1.0 - keep * keep).sqrt() * noise;
                }
            }
        }
    }

    /// The moment at `t_s`, N m, interpolated; 0 beyond what [`Self::extend_to`] has made.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let place = (t_s / GRID_S).max(0.0);
        let index = place as usize;
        let share = place - index as f64;
        match (self.grid.get(index), self.grid.get(index + 1)) {
            (Some(a), Some(b)) => a + share * (b - a),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, generator};

    fn moment(colour: Colour) -> ColouredMoment {
        let mut moment = ColouredMoment::new(0.2, colour, generator(1, Stream::Background));
        moment.extend_to(2000.0);
        moment
    }

    fn autocorrelation(moment: &ColouredMoment, lag_s: f64) -> f64 {
        let lag = (lag_s / GRID_S) as usize;
        let n = moment.grid.len() - lag;
        (0..n).map(|i| moment.grid[i] * moment.grid[i + lag]).sum::<f64>() / n as f64
    }

    #[test]
    fn the_band_passed_moment_has_its_variance_and_its_autocorrelation() {
        let (omega, zeta) = (5.0_f64, 0.4_f64);
        let m = moment(Colour::BandPass { omega, zeta });
        let variance = autocorrelation(&m, 0.0);
        // 2000 s are about 2 ζ ω · 2000 = 8000 independent values
        assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.05);
        // e^(−ζω t) (cos ωd t − ζ/√(1−ζ²) sin ωd t): negative at half a period, which no first-order moment is
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        for lag in [0.1_f64, 0.3, 0.6] {
            let (sine, cosine) = (damped * lag).sin_cos();
            let expected = (-zeta * omega * lag).exp() * (cosine - zeta / (1.0 - zeta * zeta).sqrt() * sine);
            assert!((autocorrelation(&m, lag) / variance - expected).abs() < 0.06, "{lag}");
        }
    }

    #[test]
    fn the_first_order_moment_decays_with_its_time_constant() {
        let m = moment(Colour::FirstOrder { time_constant_s: 0.5 });
        let variance = autocorrelation(&m, 0.0);
        assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.08);
        assert!((autocorrelation(&m, 0.5) / variance - (-1.0_f64).exp()).abs() < 0.08);
    }
}
