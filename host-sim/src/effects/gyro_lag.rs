//! Low-pass filter of the gyro: T q̇_meas = q − q_meas.

use super::{Effect, Entry, Motion, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "gyro_lag",
    locus: "sensor",
    parameters: &[Parameter { name: "T", unit: "s", range: [0.02, 0.12], signed: false }],
    moderate_and_strong: [0.066, 0.109],
    near: &[],
    make: |values, _| Box::new(GyroLag { time_constant_s: values[0], filtered: 0.0 }),
};

#[derive(Debug)]
struct GyroLag {
    time_constant_s: f64,
    filtered: f64,
}

impl Effect for GyroLag {
    /// Exact for a rate that runs straight from the beginning of the step to its end.
    fn follow(&mut self, motion: &Motion) {
        let (from, to) = (motion.before.q_p, motion.after.q_p);
        if self.time_constant_s <= 0.0 {
            self.filtered = to;
            return;
        }
        let slope = (to - from) / motion.dt;
        let behind = slope * self.time_constant_s;
        let transient = self.filtered - (from - behind);
        self.filtered = to - behind + transient * (-motion.dt / self.time_constant_s).exp();
    }

    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.q = self.filtered;
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn a_ramp_is_followed_t_behind() {
        let lag = Setting::new("gyro_lag", &[("T", 0.08)]).unwrap();
        let mut aircraft = Aircraft::new(FREE, &[lag], None, 0);
        (0..30).for_each(|_| aircraft.advance(0.01));
        let (b, t) = (23.0 * 0.01 / 0.1705, 0.54_f64);
        let expected = b * (t - 0.08 * (1.0 - (-t / 0.08).exp()));
        assert!((aircraft.read().q - expected).abs() < 1e-9);
        assert!((aircraft.state().q - b * t).abs() < 1e-9);
    }
}
