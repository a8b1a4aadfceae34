//! The IMU is turned about its vertical axis: q_meas = q cos a + p sin a. The logged roll rate is the vehicle's.

use super::{Effect, Entry, Others, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "axis_misalignment",
    locus: "sensor",
    parameters: &[Parameter { name: "angle_deg", unit: "deg", range: [2.0, 30.0], signed: true }],
    moderate_and_strong: [6.11, 8.87],
    near: &[],
    make: |values, _| Box::new(AxisMisalignment { angle: values[0].to_radians() }),
};

#[derive(Debug)]
struct AxisMisalignment {
    angle: f64,
}

impl Effect for AxisMisalignment {
    fn others(&self) -> Others {
        Others { roll: true, ..Others::default() }
    }

    fn measure(&mut self, _t: f64, reading: &mut Reading) {
        let (sine, cosine) = self.angle.sin_cos();
        reading.q = reading.q * cosine + reading.roll_yaw.p * sine;
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::fly_freely;
    use crate::plant::State;

    #[test]
    fn the_pitch_gyro_shows_both_rates_and_the_angle_is_true() {
        let start = State { q: 0.4, q_p: 0.4, ..State::default() };
        let mut aircraft = fly_freely("axis_misalignment", &[("angle_deg", 30.0)], start, 20);
        let read = aircraft.read();
        let p = read.roll_yaw.p;
        assert!(p.abs() > 1e-3 && (read.q - (0.4 * 0.75_f64.sqrt() + 0.5 * p)).abs() < 1e-12, "{read:?}");
        assert_eq!(read.theta, aircraft.state().theta);
    }
}
