//! Mass or inertia changes at a moment in time: Iyy → Iyy (1 + δ) for t > t*.

use super::{Effect, Entry, Parameter};
use crate::plant::Plant;

pub(super) const ENTRY: Entry = Entry {
    id: "inertia_step",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "delta", unit: "-", range: [0.1, 0.5], signed: true },
        Parameter { name: "t_star", unit: "s", range: [30.0, 70.0], signed: false },
    ],
    moderate_and_strong: [0.46, 0.5],
    near: &[],
    make: |values, _| Box::new(InertiaStep { change: values[0], time_s: values[1] }),
};

#[derive(Debug)]
struct InertiaStep {
    change: f64,
    time_s: f64,
}

impl Effect for InertiaStep {
    fn plant(&self, t: f64, plant: &mut Plant) {
        if t > self.time_s {
            // a machine keeps some inertia, whatever falls off it
            plant.inertia_kg_m2 *= (1.0 + self.change).max(0.05);
        }
    }

    fn window_s(&self) -> Option<[f64; 2]> {
        Some([self.time_s, f64::INFINITY])
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn the_same_command_accelerates_less_from_then_on() {
        let step = Setting::new("inertia_step", &[("delta", 0.25), ("t_star", 0.5)]).unwrap();
        let mut aircraft = Aircraft::new(FREE, &[step], None, 0);
        (0..50).for_each(|_| aircraft.advance(0.01));
        let b = 23.0 * 0.01 / 0.1705;
        // the step that begins at t* still has the old inertia
        let expected = b * (0.5 - 0.06) + b / 1.25 * 0.5;
        assert!((aircraft.state().q - expected).abs() < 3e-4 * b, "{}", aircraft.state().q);
    }
}
