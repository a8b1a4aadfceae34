//! Stiction: friction that is largest at rest and falls with the rate (Stribeck),
//! M −= Ms (ρ + (1 − ρ) exp(−(q/qs)²)) sign q, and it sticks at rest up to Ms.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "stribeck_friction",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "Ms", unit: "N m", range: [0.03, 0.3], signed: false },
        Parameter { name: "rho", unit: "-", range: [0.1, 0.4], signed: false },
        Parameter { name: "q_s", unit: "rad/s", range: [0.05, 0.2], signed: false },
    ],
    moderate_and_strong: [0.0406, 0.0541],
    near: &["coulomb_friction"],
    make: |values, _| {
        Box::new(StribeckFriction { breakaway: values[0], share: values[1], rate: values[2].max(1e-6) })
    },
};

#[derive(Debug)]
struct StribeckFriction {
    breakaway: f64,
    share: f64,
    rate: f64,
}

impl Effect for StribeckFriction {
    fn dry_friction(&self, x: &State) -> f64 {
        self.breakaway * (self.share + (1.0 - self.share) * (-(x.q / self.rate).powi(2)).exp())
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;
    use crate::plant::State;

    #[test]
    fn it_holds_up_to_breakaway_and_drags_less_once_it_slides() {
        let friction = [("Ms", 0.2), ("rho", 0.25), ("q_s", 0.1)];
        let friction = Setting::new("stribeck_friction", &friction).unwrap();
        let after = |u: f64, start: State| {
            let mut aircraft = Aircraft::new(FREE, std::slice::from_ref(&friction), None, 0);
            aircraft.set_state(start);
            (0..50).for_each(|_| aircraft.advance(u));
            aircraft.state()
        };
        assert_eq!(after(0.99 * 0.2 / 23.0, State::default()), State::default());
        assert!(after(1.2 * 0.2 / 23.0, State::default()).q > 0.1);
        // far above qs the friction is ρ Ms, so the rate falls by ρ Ms / I in a second
        let fast = after(0.0, State { q: 1.5, q_p: 1.5, ..State::default() });
        assert!((fast.q - (1.5 - 0.05 / 0.1705)).abs() < 1e-9, "{fast:?}");
    }
}
