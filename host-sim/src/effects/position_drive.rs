//! A drive turns the body to the angle that it is told: M = clamp(∂M/∂u u − k θ, ±M_max) in place of ∂M/∂u u.

use super::{Effect, Entry, Parameter};
use crate::plant::{Plant, State};
use std::cell::Cell;

pub(super) const ENTRY: Entry = Entry {
    id: "position_drive",
    locus: "actuator",
    parameters: &[
        Parameter { name: "k", unit: "N m/rad", range: [1.0, 30.0], signed: false },
        Parameter { name: "M_max", unit: "N m", range: [0.1, 1.0], signed: false },
    ],
    moderate_and_strong: [3.0, 20.0],
    near: &[],
    make: |values, _| {
        Box::new(PositionDrive { k: values[0], most: values[1], gain: Cell::new(Plant::nominal().dm_du) })
    },
};

#[derive(Debug)]
struct PositionDrive {
    k: f64,
    most: f64,
    /// ∂M/∂u as it stands.
    gain: Cell<f64>,
}

impl Effect for PositionDrive {
    fn plant(&self, _t: f64, plant: &mut Plant) {
        self.gain.set(plant.dm_du);
    }
    fn moment(&self, _t: f64, x: &State, blade: f64) -> f64 {
        let control = self.gain.get() * blade;
        (control - self.k * x.theta).clamp(-self.most, self.most) - control
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pushes_to_the_commanded_angle_and_no_harder_than_it_can() {
        let drive = PositionDrive { k: 10.0, most: 2.0, gain: Cell::new(5.0) };
        let moment = |blade: f64, theta: f64| {
            5.0 * blade + drive.moment(0.0, &State { theta, ..State::default() }, blade)
        };
        assert_eq!(
            [moment(1.0, 0.5), moment(1.0, 0.4), moment(1.0, 0.0), moment(1.0, 2.0)],
            [0.0, 1.0, 2.0, -2.0]
        );
    }
}
