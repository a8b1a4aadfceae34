//! Roll and yaw couple in, in free flight: M += ΔI p r, θ̇ = q cos φ − r sin φ.

use super::{Beside, Effect, Entry, Others, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "gyroscopic_coupling",
    locus: "pitch_moment",
    parameters: &[Parameter { name: "dI", unit: "kg m²", range: [0.05, 0.3], signed: false }],
    moderate_and_strong: [0.124, 0.192],
    near: &[],
    make: |values, _| Box::new(GyroscopicCoupling { difference: values[0], product: 0.0 }),
};

#[derive(Debug)]
struct GyroscopicCoupling {
    difference: f64,
    /// p r, rad²/s².
    product: f64,
}

impl Effect for GyroscopicCoupling {
    fn others(&self) -> Others {
        Others { roll: true, yaw: true, ..Others::default() }
    }

    fn beside(&mut self, now: &Beside) {
        self.product = now.roll_yaw.p * now.roll_yaw.r;
    }

    fn moment(&self, _t: f64, _x: &State, _blade: f64) -> f64 {
        self.difference * self.product
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};
    use crate::reading::RollYaw;
    use crate::surroundings::Surroundings;

    #[test]
    fn rate_and_angle_are_the_integrals_of_the_coupled_equations() {
        let mut aircraft = fly_freely("gyroscopic_coupling", &[("dI", 0.2)], State::default(), 100);
        // the same by Simpson's rule on a grid of its own
        let around = Surroundings::drawn(0, (ENTRY.make)(&[0.2], 0).others());
        let (mut q, mut theta, h) = (0.0, 0.0, 1e-3);
        let torque = |t| {
            let RollYaw { p, r, .. } = around.at(t).roll_yaw;
            0.2 * p * r / FREE.inertia_kg_m2
        };
        for k in 0..2000 {
            let t = f64::from(k) * h;
            let half = q + h / 12.0 * (torque(t) + 4.0 * torque(t + h / 4.0) + torque(t + h / 2.0));
            let next = q + h / 6.0 * (torque(t) + 4.0 * torque(t + h / 2.0) + torque(t + h));
            let angle = |t: f64, q: f64| {
                let RollYaw { r, phi, .. } = around.at(t).roll_yaw;
                q * phi.cos() - r * phi.sin()
            };
            theta += h / 6.0 * (angle(t, q) + 4.0 * angle(t + h / 2.0, half) + angle(t + h, next));
            q = next;
        }
        // the aircraft holds φ and r over its steps of 1 ms: second order
        assert!((aircraft.state().q - q).abs() < 1e-5, "{:?} {q}", aircraft.state());
        assert!((aircraft.state().theta - theta).abs() < 1e-5, "{:?} {theta}", aircraft.state());
        assert_eq!(aircraft.read().roll_yaw, around.at(2.0).roll_yaw);
    }
}
