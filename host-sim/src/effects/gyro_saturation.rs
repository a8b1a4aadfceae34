//! The rate clips: |q_meas| ≤ q_max, noise included.

use super::{Effect, Entry, Parameter};
use crate::reading::Reading;

pub(super) const ENTRY: Entry = Entry {
    id: "gyro_saturation",
    locus: "sensor",
    parameters: &[Parameter { name: "q_max", unit: "rad/s", range: [0.2, 0.6], signed: false }],
    moderate_and_strong: [0.379, 0.32],
    near: &[],
    make: |values, _| Box::new(GyroSaturation(values[0])),
};

#[derive(Debug)]
struct GyroSaturation(f64);

impl Effect for GyroSaturation {
    fn limit(&self, reading: &mut Reading) {
        reading.q = reading.q.clamp(-self.0, self.0);
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::Setting;
    use crate::scenario::Scenario;

    #[test]
    fn no_reading_leaves_the_range_whatever_the_noise() {
        let effects = vec![Setting::new("gyro_saturation", &[("q_max", 0.25)]).unwrap()];
        let flight = crate::fly(&Scenario { effects, ..Scenario::campaign(4, 0.015, 3).unwrap() }).unwrap();
        assert!(flight.rows.iter().all(|row| row.q_rad_s.abs() <= 0.25));
        let clipped = flight.rows.iter().filter(|row| row.q_rad_s.abs() == 0.25).count();
        let beyond = flight.states.iter().filter(|x| x.q_p.abs() > 0.27).count();
        assert!(beyond > 100 && clipped as f64 > 0.8 * beyond as f64, "{clipped} {beyond}");
    }
}
