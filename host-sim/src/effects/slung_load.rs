//! A load slung below the pivot: a pendulum of its own frequency that the body carries along,
//!
//! ```text
//! M += r Iyy (ω² a + 2ζω ȧ),   ä = −q̇ − ω² a − 2ζω ȧ,   ω = 2π f
//! ```
//!
//! a: how far the load is behind the body, as an angle about the pivot; r: its share, the load's inertia about the pivot
//! over the body's. With a mass m on a cable l from a hook h below the pivot, a = l α / h, ω² = g / l and r = m h² / Iyy
//! (small angles). The weight on the hook is a stiffness m g h beside it, which `gravity_stiffness` has.

use std::f64::consts::TAU;

use super::oscillator::Oscillator;
use super::{Effect, Entry, Motion, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "slung_load",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "share", unit: "1", range: [0.02, 0.6], signed: false },
        Parameter { name: "f_hz", unit: "Hz", range: [0.35, 1.2], signed: false },
        Parameter { name: "zeta", unit: "1", range: [0.01, 0.1], signed: false },
    ],
    moderate_and_strong: [0.114, 0.159],
    near: &[],
    make: |values, _| {
        let (omega, zeta) = (TAU * values[1], values[2]);
        Box::new(SlungLoad {
            share: values[0],
            omega,
            zeta,
            inertia: 0.0,
            behind: Oscillator::new(omega, zeta),
        })
    },
};

#[derive(Debug)]
struct SlungLoad {
    share: f64,
    omega: f64,
    zeta: f64,
    /// Iyy as it was in the last step, kg m².
    inertia: f64,
    behind: Oscillator,
}

impl Effect for SlungLoad {
    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        let Oscillator { position, velocity, .. } = self.behind;
        self.share * self.inertia * self.omega * (self.omega * position + 2.0 * self.zeta * velocity)
    }

    fn follow(&mut self, motion: &Motion) {
        self.inertia = motion.plant.inertia_kg_m2;
        self.behind.advance(-(motion.after.q - motion.before.q) / motion.dt, motion.dt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn a_body_that_is_pushed_shares_its_momentum_and_swings_against_the_load() {
        // without damping: q = b t / (1 + r) + b r / ((1 + r) Ω) sin Ω t after a step, Ω² = (1 + r) ω²
        let (share, f_hz, b) = (0.3, 0.8, 23.0 * 0.01 / 0.1705);
        let load = Setting::new("slung_load", &[("share", share), ("f_hz", f_hz), ("zeta", 0.0)]).unwrap();
        let mut aircraft = Aircraft::new(FREE, &[load], None, 0);
        let frequency = TAU * f_hz * (1.0_f64 + share).sqrt();
        for k in 1..=100 {
            aircraft.advance(0.01);
            let t = (f64::from(k) * 0.02 - 0.06).max(0.0);
            let q = b / (1.0 + share) * (t + share / frequency * (frequency * t).sin());
            assert!((aircraft.state().q - q).abs() < 3e-3 * b, "{t} {} {q}", aircraft.state().q);
        }
    }
}
