//! The collective thrust acts beside the centre of gravity, as with a load that has shifted or a rotor that has become weak:
//! M += c (T − T̄)/T̄, T the logged `thrust_norm`, T̄ that of hover.

use super::{Beside, Effect, Entry, Others, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "thrust_offset",
    locus: "actuator",
    parameters: &[Parameter { name: "c", unit: "N m", range: [0.01, 0.5], signed: true }],
    moderate_and_strong: [0.075, 0.106],
    near: &[],
    make: |values, _| Box::new(ThrustOffset { moment: values[0], above: 0.0 }),
};

#[derive(Debug)]
struct ThrustOffset {
    moment: f64,
    /// (T − T̄)/T̄.
    above: f64,
}

impl Effect for ThrustOffset {
    fn others(&self) -> Others {
        Others { thrust: true, ..Others::default() }
    }

    fn beside(&mut self, now: &Beside) {
        self.above = now.thrust_above_hover();
    }

    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        self.moment * self.above
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_more_thrust_is_a_fifth_of_c() {
        let mut effect = (ENTRY.make)(&[-0.4], 0);
        for (thrust, expected) in [(0.5, 0.0), (0.6, -0.08), (0.45, 0.04)] {
            effect.beside(&Beside { thrust, ..Beside::default() });
            assert!((effect.moment(0.0, &State::default(), 0.0) - expected).abs() < 1e-12);
        }
    }
}
