//! H∞ norm of a stable continuous-time system, sup_ω σ_max(G(jω)), and the frequency where it is attained.
//!
//! ```text
//! H(γ) = [ A + B R⁻¹ Dᵀ C          γ B R⁻¹ Bᵀ        ]      R = γ² I − Dᵀ D
//!        [ −Cᵀ (I + D R⁻¹ Dᵀ) C/γ  −(A + B R⁻¹ DᵀC)ᵀ ]
//! jω is an eigenvalue of H(γ)  ⇔  γ is a singular value of G(jω)           (γ > σ_max(D))
//! ```
//!
//! From a gain that is attained, γ is raised a little: where H(γ) has eigenvalues on the imaginary axis, the largest
//! gain halfway between neighbours is the next, larger one; where it has none, or none of these gains exceeds γ, γ is an
//! upper bound. Each round squares the error. A delay does not change the norm.
//!
//! Cost: one eigenvalue problem of size 2n for each of two to five rounds.
//!
//! Source: Bruinsma, Steinbuch, A fast algorithm to compute the H∞-norm of a transfer function matrix, Systems & Control
//! Letters 14, 1990; Boyd, Balakrishnan, Kabamba, Math. Control Signals Systems 2, 1989 (the theorem).

use super::continuous::ContinuousStateSpace;
use crate::error::{Error, ErrorKind};
use crate::linalg::eigenvalues;
use nalgebra::DMatrix;

/// Half the relative width of the bracket that the norm is found in.
pub const TOLERANCE: f64 = 1e-7;
/// Eigenvalues within this share of their magnitude of the axis count as on it. A crossing that is nearly a touch is off
/// by the root of the rounding; one too many only costs a gain.
const ON_THE_AXIS: f64 = 1e-5;
/// Rounds at most; the error squares, so that this is never reached by rounding alone.
const MOST_ROUNDS: usize = 60;

/// The norm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HinfNorm {
    /// Gain attained at `omega`: a lower bound.
    pub value: f64,
    /// Proven upper bound, at most 2·[`TOLERANCE`] above `value` (relative).
    pub upper: f64,
    /// Frequency of the peak, rad/s; infinite where D attains the norm.
    pub omega: f64,
}

/// The norm of `system`; `hints` are frequencies in rad/s where the peak may be (none are needed).
///
/// # Errors
/// A pole on or to the right of the imaginary axis: the norm is infinite. Eigenvalues that cannot be computed.
pub fn hinf_norm(system: &ContinuousStateSpace, hints: &[f64]) -> Result<HinfNorm, Error> {
    let poles = system.poles()?;
    if let Some(pole) = poles.first().filter(|pole| pole.re >= 0.0) {
        let found =
            format!("a pole at {:.4} {:+.4}i rad/s: the H-infinity norm is infinite", pole.re, pole.im);
        return Err(Error::new(ErrorKind::Numerical, found, "use a stable model")
            .expecting("all poles left of the imaginary axis"));
    }
    let failed = || {
        let advice = "scale the signals to SI units, or choose a lower order";
        Error::new(ErrorKind::Numerical, "the H-infinity norm could not be computed", advice)
    };
    let candidates = [0.0, f64::INFINITY].into_iter().chain(poles.iter().map(|pole| pole.norm()));
    let start = candidates.chain(hints.iter().copied()).filter(|omega| *omega >= 0.0);
    let (mut value, mut omega) = largest(system, start).ok_or_else(failed)?;
    if value == 0.0 {
        return Ok(HinfNorm { value, upper: f64::MIN_POSITIVE, omega });
    }
    for _ in 0..MOST_ROUNDS {
        let gamma = value * (1.0 + 2.0 * TOLERANCE);
        let crossings = crossings(system, gamma).ok_or_else(failed)?;
        let middles = crossings.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let outer = crossings.first().map(|first| 0.5 * first);
        match largest(system, middles.chain(outer)) {
            Some((larger, at)) if larger > gamma => (value, omega) = (larger, at),
            _ => return Ok(HinfNorm { value, upper: gamma, omega }),
        }
    }
    Err(failed())
}

/// The largest gain over `frequencies`, and where; the first of equals.
fn largest(system: &ContinuousStateSpace, frequencies: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    frequencies
        .filter_map(|omega| system.gain(omega).map(|gain| (gain, omega)))
        .reduce(|best, next| if next.0 > best.0 { next } else { best })
}

/// Frequencies ≥ 0 at which a singular value equals γ, rising.
fn crossings(system: &ContinuousStateSpace, gamma: f64) -> Option<Vec<f64>> {
    let (n, m, p) = (system.order(), system.b().ncols(), system.c().nrows());
    let (b, c, d) = (system.b(), system.c(), system.d());
    let r = (DMatrix::identity(m, m) * gamma - d.tr_mul(d) / gamma).try_inverse()?;
    let outer = DMatrix::identity(p, p) / gamma + d * &r * d.transpose() / (gamma * gamma);
    let upper_left = system.a() + b * &r * d.transpose() * c / gamma;
    let mut hamiltonian = DMatrix::zeros(2 * n, 2 * n);
    hamiltonian.view_mut((0, 0), (n, n)).copy_from(&upper_left);
    hamiltonian.view_mut((0, n), (n, n)).copy_from(&(b * &r * b.transpose()));
    hamiltonian.view_mut((n, 0), (n, n)).copy_from(&(-(c.tr_mul(&(outer * c)))));
    hamiltonian.view_mut((n, n), (n, n)).copy_from(&-upper_left.transpose());
    let values = eigenvalues(&hamiltonian)?;
    let on_axis = values.iter().filter(|v| v.im >= 0.0 && v.re.abs() <= ON_THE_AXIS * v.norm());
    let mut found: Vec<f64> = on_axis.map(|v| v.im).collect();
    found.sort_by(f64::total_cmp);
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn siso(a: &[f64], b: &[f64], c: &[f64], d: f64) -> ContinuousStateSpace {
        let n = b.len();
        ContinuousStateSpace::new(
            DMatrix::from_row_slice(n, n, a),
            DMatrix::from_column_slice(n, 1, b),
            DMatrix::from_row_slice(1, n, c),
            DMatrix::from_element(1, 1, d),
            0.0,
        )
        .unwrap()
    }

    fn resonance(omega: f64, zeta: f64) -> ContinuousStateSpace {
        siso(&[0.0, 1.0, -omega * omega, -2.0 * zeta * omega], &[0.0, omega * omega], &[1.0, 0.0], 0.0)
    }

    #[test]
    fn resonance_peak_meets_the_closed_form() {
        for omega in [1e-4, 0.01, 7.0, 900.0, 1e5] {
            for zeta in [1e-4, 1e-3, 0.01, 0.2, 0.6] {
                let found = hinf_norm(&resonance(omega, zeta), &[]).unwrap();
                let root = f64::sqrt(1.0 - zeta * zeta);
                let (peak, at) = (1.0 / (2.0 * zeta * root), omega * f64::sqrt(1.0 - 2.0 * zeta * zeta));
                assert!(
                    (found.value / peak - 1.0).abs() < 2.0 * TOLERANCE,
                    "{omega} {zeta} {found:?} {peak}"
                );
                assert!(found.value <= peak * (1.0 + 1e-9) && found.upper >= peak, "{found:?} {peak}");
                assert!((found.omega / at - 1.0).abs() < 2e-3, "{found:?} {at}");
            }
        }
    }

    #[test]
    fn peaks_at_zero_and_at_infinity() {
        let lag = hinf_norm(&siso(&[-2.0], &[3.0], &[1.0], 0.0), &[]).unwrap();
        assert!((lag.value - 1.5).abs() < 1e-15 && lag.omega == 0.0);
        // (s + 1)/(s + 2): largest at infinity
        let lead = hinf_norm(&siso(&[-2.0], &[1.0], &[-1.0], 1.0), &[]).unwrap();
        assert!((lead.value - 1.0).abs() < 1e-12 && lead.omega == f64::INFINITY, "{lead:?}");
        let nothing = hinf_norm(&siso(&[-2.0], &[0.0], &[1.0], 0.0), &[]).unwrap();
        assert_eq!(nothing.value, 0.0);
    }

    #[test]
    fn two_inputs_and_outputs_meet_a_dense_grid() {
        let a = DMatrix::from_row_slice(
            4,
            4,
            &[0.0, 1.0, 0.0, 0.0, -9.0, -0.3, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, -40.0, -0.5],
        );
        let b = DMatrix::from_row_slice(4, 2, &[0.0, 0.1, 1.0, 0.0, 0.2, 0.0, 0.0, 2.0]);
        let c = DMatrix::from_row_slice(3, 4, &[1.0, 0.0, 0.0, 0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        let d = DMatrix::from_row_slice(3, 2, &[0.1, 0.0, 0.0, -0.2, 0.0, 0.05]);
        let system = ContinuousStateSpace::new(a, b, c, d, 0.1).unwrap();
        let found = hinf_norm(&system, &[]).unwrap();
        let dense = (0..40_000).filter_map(|k| system.gain(5e-4 * f64::from(k))).fold(0.0, f64::max);
        assert!(dense <= found.upper && found.value <= dense * (1.0 + 1e-5), "{found:?} {dense}");
    }

    #[test]
    fn an_unstable_system_is_refused_with_its_pole() {
        let error = hinf_norm(&siso(&[0.5], &[1.0], &[1.0], 0.0), &[]).unwrap_err();
        assert!(error.to_string().contains("0.5000"), "{error}");
    }
}
