//! The rotors push back when they are turned faster or their blades moved: M += Jr du/dt, u the delayed command as it
//! comes to this place in the chain. A command that jumps by Δu gives the impulse Jr Δu.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "rotor_reaction",
    locus: "actuator",
    parameters: &[Parameter { name: "Jr", unit: "N m s/unit", range: [0.1, 4.0], signed: false }],
    moderate_and_strong: [1.67, 2.27],
    near: &[],
    make: |values, _| Box::new(RotorReaction { inertia: values[0], last: 0.0, slope: 0.0 }),
};

#[derive(Debug)]
struct RotorReaction {
    inertia: f64,
    last: f64,
    /// du/dt, in the mean over the step.
    slope: f64,
}

impl Effect for RotorReaction {
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        self.slope = if dt > 0.0 { (u - self.last) / dt } else { 0.0 };
        self.last = u;
        u
    }

    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        self.inertia * self.slope
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn a_command_that_jumps_kicks_the_rate() {
        let reaction = Setting::new("rotor_reaction", &[("Jr", 0.8)]).unwrap();
        let mut aircraft = Aircraft::new(FREE, &[reaction], None, 0);
        let command = |k: i32| if k < 20 { 0.01 } else { -0.01 };
        (0..30).for_each(|k| aircraft.advance(command(k)));
        // 0.4 s up, 0.14 s down after the delay; the impulses add to the command that is held now
        let b = 23.0 * 0.01 / 0.1705;
        let expected = b * (0.4 - 0.14) - 0.8 * 0.01 / 0.1705;
        assert!((aircraft.state().q - expected).abs() < 1e-9, "{}", aircraft.state().q);
    }
}
