//! Contact beyond an angle: M −= ks (|θ|−θs) sign θ for |θ| > θs.

use super::{Effect, Entry, Parameter};
use crate::plant::State;

pub(super) const ENTRY: Entry = Entry {
    id: "end_stop",
    locus: "pitch_moment",
    parameters: &[
        Parameter { name: "ks", unit: "N m/rad", range: [1.0, 30.0], signed: false },
        Parameter { name: "theta_s", unit: "rad", range: [0.1, 0.5], signed: false },
    ],
    moderate_and_strong: [1.4, 2.15],
    near: &[],
    make: |values, _| Box::new(EndStop { stiffness: values[0], angle: values[1] }),
};

#[derive(Debug)]
struct EndStop {
    stiffness: f64,
    angle: f64,
}

impl Effect for EndStop {
    fn moment(&self, _t: f64, x: &State, _blade: f64) -> f64 {
        -self.stiffness * (x.theta.abs() - self.angle).max(0.0).copysign(x.theta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{FREE, fly_freely};

    #[test]
    fn a_bounce_takes_half_a_period_of_the_contact_and_gives_the_rate_back() {
        let (ks, angle) = (20.0, 0.2);
        let contact_s = std::f64::consts::PI * (FREE.inertia_kg_m2 / ks).sqrt();
        let start = State { q: 0.5, q_p: 0.5, ..State::default() };
        let aircraft = fly_freely("end_stop", &[("ks", ks), ("theta_s", angle)], start, 50);
        // 0.4 s on the way to the stop, half a period in it, the rest on the way back
        let expected = angle - 0.5 * (1.0 - angle / 0.5 - contact_s);
        assert!((aircraft.state().q + 0.5).abs() < 1e-4, "{:?}", aircraft.state());
        assert!((aircraft.state().theta - expected).abs() < 1e-4);
    }
}
