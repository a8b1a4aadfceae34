//! Stiction: friction that is largest at rest and falls with the rate (Stribeck 1902; in this form Armstrong-Hélouvry,
//! Dupont, Canudas de Wit 1994): M −= [Mc + (Ms − Mc) exp(−(q/qs)²)] sign q, and it sticks at rest up to Ms.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "stribeck_friction",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "Ms", unit: "N m", range: [0.03, 0.3], signed: false },
        Parameter { name: "Mc", unit: "N m", range: [0.005, 0.03], signed: false },
        Parameter { name: "qs", unit: "rad/s", range: [0.05, 0.2], signed: false },
    ],
    moderate_and_strong: [0.0378, 0.0496],
    near: &[],
    make: |values, _| {
        Box::new(StribeckFriction { breakaway: values[0], sliding: values[1], rate: values[2].max(1e-6) })
    },
};

#[derive(Debug)]
struct StribeckFriction {
    breakaway: f64,
    sliding: f64,
    rate: f64,
}

impl Effect for StribeckFriction {
    fn dry_friction(&self, x: &State) -> [f64; 2] {
        let falling = (-(x.q / self.rate).powi(2)).exp();
        [self.sliding + (self.breakaway - self.sliding) * falling; 2]
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
        let friction = [("Ms", 0.2), ("Mc", 0.05), ("qs", 0.1)];
        let friction = Setting::new("stribeck_friction", &friction).unwrap();
        let after = |u: f64, start: State| {
            let mut aircraft = Aircraft::new(FREE, std::slice::from_ref(&friction), None, 0);
            aircraft.set_state(start);
            (0..50).for_each(|_| aircraft.advance(u));
            aircraft.state()
        };
        assert_eq!(after(0.99 * 0.2 / 23.0, State::default()), State::default());
        assert!(after(1.2 * 0.2 / 23.0, State::default()).q > 0.1);
        // far above qs the friction is Mc, so the rate falls by Mc / I in a second
        let fast = after(0.0, State { q: 1.5, q_p: 1.5, ..State::default() });
        assert!((fast.q - (1.5 - 0.05 / 0.1705)).abs() < 1e-9, "{fast:?}");
    }
}
