//! A spring with memory, a bundle of cables that rub: M −= k z, with z of Bouc and Wen (n = 1, β = γ),
//! ż = q (1 − |z|/zs) where it is being loaded, ż = q where it is being unloaded.

use super::{Effect, Entry, Motion, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "hysteretic_spring",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "k", unit: "N m/rad", range: [0.2, 6.0], signed: false },
        Parameter { name: "z_s", unit: "rad", range: [0.02, 0.15], signed: false },
    ],
    moderate_and_strong: [0.555, 0.83],
    near: &["coulomb_friction", "gravity_stiffness"],
    make: |values, _| Box::new(HystereticSpring { stiffness: values[0], limit: values[1].max(1e-6), z: 0.0 }),
};

#[derive(Debug)]
struct HystereticSpring {
    stiffness: f64,
    limit: f64,
    z: f64,
}

impl HystereticSpring {
    /// z after the way `way` (rad), exactly: it depends on the way alone, not on the time.
    fn turn(&mut self, way: f64) {
        let unloading = if self.z * way < 0.0 { way.abs().min(self.z.abs()) } else { 0.0 };
        self.z += unloading.copysign(way);
        let loading = way.abs() - unloading;
        let end = self.limit.copysign(way);
        if loading > 0.0 {
            self.z = end + (self.z - end) * (-loading / self.limit).exp();
        }
    }
}

impl Effect for HystereticSpring {
    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        -self.stiffness * self.z
    }

    fn follow(&mut self, motion: &Motion) {
        self.turn(motion.after.theta - motion.before.theta);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_loads_along_an_exponential_and_unloads_along_a_straight_line() {
        let mut spring = HystereticSpring { stiffness: 1.0, limit: 0.05, z: 0.0 };
        (0..100).for_each(|_| spring.turn(1e-3));
        let loaded = 0.05 * (1.0 - (-2.0_f64).exp());
        assert!((spring.z - loaded).abs() < 1e-12);
        (0..20).for_each(|_| spring.turn(-1e-3));
        assert!((spring.z - (loaded - 0.02)).abs() < 1e-12);
        spring.turn(-0.123_456);
        let beyond = 0.123_456 - (loaded - 0.02);
        assert!((spring.z + 0.05 * (1.0 - (-beyond / 0.05).exp())).abs() < 1e-12);
    }
}
