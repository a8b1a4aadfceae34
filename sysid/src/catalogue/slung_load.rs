//! A load slung below the pivot.

use crate::dataset::Amplitudes;
use crate::model::effect::{About, Conditions, Effect, Locus, Parameter, Scale};
use crate::model::oscillator::oscillate;

/// M += r Iyy (ω² a + 2ζω ȧ), ä = −q̇ − ω² a − 2ζω ȧ, ω = 2π f: a is the angle about the pivot by which the load is ahead
/// of the body, r its inertia about the pivot relative to the body's (a pendulum under a moving support; Lamb,
/// Dynamics, 1923). The load's weight beside it is `gravity_stiffness`.
pub struct SlungLoad;

impl Effect for SlungLoad {
    fn about(&self) -> About {
        About {
            id: "slung_load",
            locus: Locus::PitchMoment,
            sentence: "a load swings below the pivot with a frequency of its own",
            equation: "M += share Iyy (w^2 a + 2 zeta w a'), a'' = -dq/dt - w^2 a - 2 zeta w a', w = 2 pi f_hz",
            variable: "theta",
            condition: "around the frequency at which the load swings",
        }
    }
    fn source(&self) -> Option<&'static str> {
        Some("Lamb, 1923")
    }
    fn parameters(&self, data: &Amplitudes) -> Vec<Parameter> {
        vec![
            Parameter {
                name: "f_hz",
                unit: "Hz",
                lower: (3.0 / data.duration).max(0.1),
                upper: (0.1 / data.step).min(4.0),
                scale: Scale::Log,
            },
            Parameter { name: "share", unit: "1", lower: 1e-3, upper: 2.0, scale: Scale::Log },
            Parameter { name: "zeta", unit: "1", lower: 1e-3, upper: 0.7, scale: Scale::Log },
        ]
    }
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>> {
        [0.4, 0.7, 1.2, 2.2].map(|f_hz| vec![f_hz, 0.1, 0.05]).to_vec()
    }
    fn rings(&self, p: &[f64]) -> Option<[f64; 2]> {
        Some([p[0], p[2]])
    }
    fn start_ringing(&self, f_hz: f64, zeta: f64) -> Option<Vec<f64>> {
        Some(vec![f_hz, 0.1, zeta])
    }
    fn states(&self) -> usize {
        2
    }
    fn within_sample(&self) -> bool {
        true
    }
    /// States: how far the load is ahead of the body, a, and the load's own rate q + ȧ.
    fn moment(&self, p: &[f64], s: &[f64], q: f64, _theta: f64, at: &Conditions) -> f64 {
        let omega = std::f64::consts::TAU * p[0];
        let ahead = s[1] - q;
        let middle = s[0] + 0.5 * at.dt * ahead;
        p[1] * at.inertia * omega * (omega * middle + 2.0 * p[2] * ahead)
    }
    fn follow(&self, p: &[f64], s: &mut [f64], q: f64, _theta: f64, at: &Conditions) {
        s[1] -= q;
        oscillate(s, std::f64::consts::TAU * p[0], p[2], 0.0, at.dt);
        s[1] += q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pushed_body_shares_its_momentum_with_the_load() {
        // Free, undamped, from a rate q0: q = q0 (1 + r cos Ω t)/(1 + r), Ω² = (1 + r) ω².
        let (p, inertia, dt) = ([0.7, 0.3, 0.0], 0.2, 0.002);
        let at = Conditions { dt, inertia, ..Conditions::default() };
        let (mut s, mut q) = ([0.0; 2], 1.0);
        for k in 1..=1000 {
            let moment = |q: f64| SlungLoad.moment(&p, &s, q, 0.0, &at);
            let middle = q + 0.5 * dt * moment(q) / inertia;
            q += dt * moment(middle) / inertia;
            SlungLoad.follow(&p, &mut s, middle, 0.0, &at);
            let swing = std::f64::consts::TAU * p[0] * (1.0 + p[1]).sqrt();
            let expected = (1.0 + p[1] * (swing * dt * f64::from(k)).cos()) / (1.0 + p[1]);
            assert!((q - expected).abs() < 2e-3, "{k}: {q} {expected}");
        }
    }
}
