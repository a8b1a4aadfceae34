//! A spring that gives way and remembers, a bundle of cables that rub: M −= Mh z, ż = (k/Mh)(q − |q| z)
//! (Bouc 1967, Wen 1976, with n = 1 and no softening term: Dahl 1968). From rest it is a spring of stiffness k, after
//! a long way one way a friction of Mh.

use super::{Effect, Entry, Motion, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "hysteresis",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "Mh", unit: "N m", range: [0.01, 0.25], signed: false },
        Parameter { name: "k", unit: "N m/rad", range: [0.5, 6.0], signed: false },
    ],
    moderate_and_strong: [0.0362, 0.0461],
    near: &[],
    make: |values, _| {
        Box::new(Hysteresis { level: values[0].max(1e-9), stiffness: values[1], z: 0.0, ahead: 0.0 })
    },
};

#[derive(Debug)]
struct Hysteresis {
    level: f64,
    stiffness: f64,
    z: f64,
    /// z in the middle of the next step, if it goes as far as the last.
    ahead: f64,
}

impl Hysteresis {
    /// z after the way `way` (rad), exactly: dz = (k/Mh)(1 − z sign way) d(way), whatever the time it takes.
    fn after(&self, way: f64) -> f64 {
        let end = 1.0_f64.copysign(way);
        end + (self.z - end) * (-way.abs() * self.stiffness / self.level).exp()
    }

    fn turn(&mut self, way: f64) {
        self.z = self.after(way);
        self.ahead = self.after(way / 2.0);
    }
}

impl Effect for Hysteresis {
    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        -self.level * self.ahead
    }

    fn follow(&mut self, motion: &Motion) {
        self.turn(motion.after.theta - motion.before.theta);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn it_loads_along_an_exponential_and_turns_along_another() {
        let mut spring = Hysteresis { level: 0.1, stiffness: 2.0, z: 0.0, ahead: 0.0 };
        (0..100).for_each(|_| spring.turn(1e-3));
        let loaded = 1.0 - (-2.0_f64).exp();
        assert!((spring.z - loaded).abs() < 1e-12);
        spring.turn(-0.03);
        assert!((spring.z - ((loaded + 1.0) * (-0.6_f64).exp() - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn a_slide_costs_the_work_of_the_closed_form() {
        // from rest over the way s: ∫ Mh z dθ = Mh (s − (Mh/k)(1 − exp(−s k/Mh)))
        let start = State { q: 0.5, q_p: 0.5, ..State::default() };
        let x = fly_freely("hysteresis", &[("Mh", 0.05), ("k", 1.0)], start, 20).state();
        let work = 0.05 * (x.theta - 0.05 * (1.0 - (-x.theta / 0.05).exp()));
        assert!(x.theta > 0.1 && (0.5 * 0.1705 * (0.25 - x.q * x.q) - work).abs() < 1e-5, "{x:?}");
    }
}
