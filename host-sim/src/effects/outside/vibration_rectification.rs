//! The gyro rectifies the vibration of working rotors: q_meas = q + b ua².

use super::{Effect, Entry, Motion, Parameter};
use crate::reading::Reading;

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "vibration_rectification",
    locus: "sensor",
    parameters: &[Parameter { name: "b", unit: "rad/s per rad²", range: [50.0, 2000.0], signed: true }],
    moderate_and_strong: [484.0, 661.0],
    near: &["gyro_bias"],
    make: |values, _| Box::new(VibrationRectification { gain: values[0], blade: 0.0 }),
};

#[derive(Debug)]
struct VibrationRectification {
    gain: f64,
    blade: f64,
}

impl Effect for VibrationRectification {
    fn follow(&mut self, motion: &Motion) {
        self.blade = motion.blade;
    }

    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        reading.q += self.gain * self.blade * self.blade;
    }
}

#[cfg(test)]
mod tests {
    use crate::aircraft::Aircraft;
    use crate::effects::Setting;
    use crate::effects::tests::FREE;

    #[test]
    fn the_rate_is_off_by_the_square_of_the_command_whatever_its_sign() {
        for u in [0.02, -0.02] {
            let gyro = Setting::new("vibration_rectification", &[("b", 500.0)]).unwrap();
            let mut aircraft = Aircraft::new(FREE, &[gyro], None, 0);
            (0..10).for_each(|_| aircraft.advance(u));
            assert!((aircraft.read().q - aircraft.state().q - 500.0 * 4e-4).abs() < 1e-12);
        }
    }
}
