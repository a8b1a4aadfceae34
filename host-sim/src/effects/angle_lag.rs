//! The attitude estimate is filtered: T dθ_meas/dt = θ − θ_meas. The rate is what it is.

use super::{Effect, Entry, Motion, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "angle_lag",
    locus: "sensor",
    parameters: &[Parameter { name: "T", unit: "s", range: [0.02, 0.3], signed: false }],
    moderate_and_strong: [0.08, 0.15],
    near: &[],
    make: |values, _| Box::new(AngleLag { time_constant_s: values[0], filtered: 0.0 }),
};

#[derive(Debug)]
struct AngleLag {
    time_constant_s: f64,
    filtered: f64,
}

impl Effect for AngleLag {
    /// Exact for an angle that runs straight from the beginning of the step to its end.
    fn follow(&mut self, motion: &Motion) {
        let (from, to) = (motion.before.theta_p, motion.after.theta_p);
        if self.time_constant_s <= 0.0 {
            self.filtered = to;
            return;
        }
        let behind = (to - from) / motion.dt * self.time_constant_s;
        let transient = self.filtered - (from - behind);
        self.filtered = to - behind + transient * (-motion.dt / self.time_constant_s).exp();
    }

    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.theta = self.filtered;
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::fly_freely;
    use crate::plant::State;

    #[test]
    fn an_angle_that_runs_is_read_t_behind_and_its_rate_is_not() {
        let start = State { q: 0.4, q_p: 0.4, ..State::default() };
        let mut aircraft = fly_freely("angle_lag", &[("T", 0.1)], start, 25);
        let read = aircraft.read();
        let expected = 0.4 * (0.5 - 0.1 * (1.0 - (-5.0_f64).exp()));
        assert!((read.theta - expected).abs() < 1e-9 && (read.q - 0.4).abs() < 1e-12, "{read:?}");
    }
}
