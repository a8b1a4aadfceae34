//! Another axis' command drives this one, as of motors that are not quite where the mixer has them: M += c u_roll(t), the
//! command as it is sent.

use super::{Beside, Effect, Entry, Others, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "cross_feed",
    locus: "actuator",
    parameters: &[Parameter { name: "c", unit: "N m/unit", range: [0.5, 15.0], signed: true }],
    moderate_and_strong: [2.49, 3.85],
    near: &[],
    make: |values, _| Box::new(CrossFeed { gain: values[0], command: 0.0 }),
};

#[derive(Debug)]
struct CrossFeed {
    gain: f64,
    command: f64,
}

impl Effect for CrossFeed {
    fn others(&self) -> Others {
        Others { roll: true, roll_command: true, ..Others::default() }
    }

    fn beside(&mut self, now: &Beside) {
        self.command = now.u_roll;
    }

    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        self.gain * self.command
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aircraft::SAMPLE_PERIOD_S;
    use crate::effects::tests::{FREE, fly_freely};
    use crate::surroundings::Surroundings;

    #[test]
    fn the_rate_is_the_sum_of_the_held_commands() {
        let x = fly_freely("cross_feed", &[("c", 3.0)], State::default(), 80).state();
        let around = Surroundings::drawn(0, (ENTRY.make)(&[3.0], 0).others());
        let impulse: f64 =
            (0..80).map(|k| SAMPLE_PERIOD_S * around.at(f64::from(k) * SAMPLE_PERIOD_S).u_roll).sum();
        let expected = 3.0 * impulse / FREE.inertia_kg_m2;
        assert!(expected.abs() > 1e-3 && (x.q - expected).abs() < 1e-9, "{x:?} {expected}");
    }
}
