//! Dry friction of another value each way, a bearing under load or a seal that drags: M −= M_up for q > 0,
//! M += M_down for q < 0, and it sticks at rest while the other moments lie within −M_down to M_up.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "asymmetric_friction",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "M_up", unit: "N m", range: [0.02, 0.15], signed: false },
        Parameter { name: "M_down", unit: "N m", range: [0.005, 0.02], signed: false },
    ],
    moderate_and_strong: [0.0483, 0.0645],
    near: &[],
    make: |values, _| Box::new(AsymmetricFriction([values[0], values[1]])),
};

/// Against a rate upward, and downward, N m.
#[derive(Debug)]
struct AsymmetricFriction([f64; 2]);

impl Effect for AsymmetricFriction {
    fn dry_friction(&self, _x: &State) -> [f64; 2] {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;
    use crate::plant::State;

    #[test]
    fn each_way_has_its_own_level_in_motion_and_at_rest() {
        let friction = Setting::new("asymmetric_friction", &[("M_up", 0.1), ("M_down", 0.04)]).unwrap();
        let after = |u: f64, q: f64| {
            let mut aircraft = Aircraft::new(FREE, std::slice::from_ref(&friction), None, 0);
            aircraft.set_state(State { q, q_p: q, ..State::default() });
            (0..50).for_each(|_| aircraft.advance(u));
            aircraft.state().q
        };
        // one second of sliding: the rate falls by M / I
        assert!((after(0.0, 1.0) - (1.0 - 0.1 / 0.1705)).abs() < 1e-9);
        assert!((after(0.0, -1.0) + (1.0 - 0.04 / 0.1705)).abs() < 1e-9);
        let held = |moment: f64| after(moment / 23.0, 0.0) == 0.0;
        assert!(held(0.099) && !held(0.101) && held(-0.039) && !held(-0.041));
    }
}
