//! A cable that rubs in a part of the travel only: dry friction Mc for |θ − θ0| < w.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "local_friction",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "Mc", unit: "N m", range: [0.03, 0.3], signed: false },
        Parameter { name: "theta_0", unit: "rad", range: [0.03, 0.15], signed: true },
        Parameter { name: "width", unit: "rad", range: [0.03, 0.1], signed: false },
    ],
    moderate_and_strong: [0.053, 0.106],
    near: &["coulomb_friction"],
    make: |values, _| Box::new(LocalFriction { level: values[0], centre: values[1], half_width: values[2] }),
};

#[derive(Debug)]
struct LocalFriction {
    level: f64,
    centre: f64,
    half_width: f64,
}

impl Effect for LocalFriction {
    fn dry_friction(&self, x: &State) -> [f64; 2] {
        if (x.theta - self.centre).abs() < self.half_width { [self.level; 2] } else { [0.0; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::fly_freely;

    #[test]
    fn a_passage_costs_the_work_of_the_window() {
        let rub = [("Mc", 0.05), ("theta_0", 0.1), ("width", 0.04)];
        let start = State { q: 0.6, q_p: 0.6, ..State::default() };
        let x = fly_freely("local_friction", &rub, start, 30).state();
        let lost = 0.5 * 0.1705 * (0.36 - x.q * x.q);
        assert!(x.theta > 0.2);
        // the window is found to the millisecond at either end
        assert!((lost - 0.05 * 0.08).abs() < 0.05 * 1e-3, "{lost}");
    }
}
