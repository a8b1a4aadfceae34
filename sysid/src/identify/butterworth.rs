//! Butterworth low pass, the weight of H∞ matching.
//!
//! ```text
//! |G_W(jω)|² = 1 / (1 + (ω/ω_c)^2N)
//! G_W(s) = Π_k ω_c² / (s² + 2 ζ_k ω_c s + ω_c²) · (ω_c / (s + ω_c) if N is odd),   ζ_k = sin((2k+1) π / 2N)
//! ```
//!
//! Source: Butterworth, On the theory of filter amplifiers, Wireless Engineer 7, 1930.

use super::continuous::ContinuousStateSpace;
use crate::error::Error;
use core::f64::consts::PI;
use nalgebra::DMatrix;

/// The weight G_W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Butterworth {
    /// N, 1 to 25.
    pub order: usize,
    /// ω_c, 3 to 60 rad/s.
    pub cutoff: f64,
}

impl Butterworth {
    /// |G_W(jω)|.
    #[must_use]
    pub fn gain(&self, omega: f64) -> f64 {
        1.0 / (1.0 + (omega / self.cutoff).powi(2 * self.order as i32)).sqrt()
    }

    /// G_W as a cascade of second-order sections, the best damped first, so that no signal in between is large.
    fn sections(&self) -> Vec<f64> {
        let n = self.order;
        let mut damping: Vec<f64> =
            (0..n / 2).map(|k| (PI * (2 * k + 1) as f64 / (2 * n) as f64).sin()).collect();
        damping.reverse();
        damping
    }

    /// G_W in series after `system`, which has one input and one output; its delay is left out.
    ///
    /// # Errors
    /// A cutoff that is not finite.
    pub fn after(&self, system: &ContinuousStateSpace) -> Result<ContinuousStateSpace, Error> {
        let (n, total, w) = (system.order(), system.order() + self.order, self.cutoff);
        let (mut a, mut b) = (DMatrix::zeros(total, total), DMatrix::zeros(total, 1));
        a.view_mut((0, 0), (n, n)).copy_from(system.a());
        b.view_mut((0, 0), (n, 1)).copy_from(system.b());
        // what drives the next section: a row over the states, and a direct term
        let mut drive = DMatrix::zeros(1, total);
        drive.view_mut((0, 0), (1, n)).copy_from(system.c());
        let mut direct = system.d()[0];
        let mut at = n;
        let mut connect =
            |row: usize, drive: &mut DMatrix<f64>, direct: &mut f64, a: &mut DMatrix<f64>, output: usize| {
                for column in 0..total {
                    a[(row, column)] += w * drive[(0, column)];
                }
                b[(row, 0)] += w * *direct;
                drive.fill(0.0);
                drive[(0, output)] = 1.0;
                *direct = 0.0;
            };
        if self.order % 2 == 1 {
            a[(at, at)] = -w;
            connect(at, &mut drive, &mut direct, &mut a, at);
            at += 1;
        }
        for damping in self.sections() {
            a[(at, at + 1)] = w;
            a[(at + 1, at)] = -w;
            a[(at + 1, at + 1)] = -2.0 * damping * w;
            connect(at + 1, &mut drive, &mut direct, &mut a, at);
            at += 2;
        }
        ContinuousStateSpace::new(a, b, drive, DMatrix::from_element(1, 1, direct), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_space_has_the_gain_of_the_formula() {
        let unit = ContinuousStateSpace::new(
            DMatrix::from_element(1, 1, -1.0),
            DMatrix::zeros(1, 1),
            DMatrix::zeros(1, 1),
            DMatrix::from_element(1, 1, 1.0),
            0.0,
        )
        .unwrap();
        for order in 1..=25 {
            let weight = Butterworth { order, cutoff: 7.0 };
            let series = weight.after(&unit).unwrap();
            for omega in [0.0, 1.0, 6.9, 7.0, 8.0, 20.0] {
                let (found, expected) = (series.gain(omega).unwrap(), weight.gain(omega));
                assert!((found - expected).abs() < 1e-12, "{order} {omega} {found} {expected}");
            }
        }
    }
}
