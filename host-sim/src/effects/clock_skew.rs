//! Input and output are stamped by two clocks: u_logged(t) = u(t (1 + ε)).
//!
//! The vehicle flies with the true command; only the log shows another one.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "clock_skew",
    locus: "timing",
    parameters: &[Parameter { name: "epsilon", unit: "s/s", range: [0.0002, 0.003], signed: true }],
    moderate_and_strong: [0.00056, 0.0008],
    near: &[],
    make: |values, _| Box::new(ClockSkew(values[0])),
};

#[derive(Debug)]
struct ClockSkew(f64);

impl Effect for ClockSkew {
    fn logged_at(&self, t: f64) -> f64 {
        t * (1.0 + self.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::Setting;
    use crate::scenario::{Background, Scenario};

    #[test]
    fn the_log_shows_the_command_of_another_time_and_the_flight_is_the_same() {
        let background = Background::None;
        let scenario = Scenario { background, ..Scenario::campaign(4, 0.015, 3).unwrap() };
        let straight = crate::fly(&scenario).unwrap();
        for epsilon in [0.002, -0.002] {
            let effects = vec![Setting::new("clock_skew", &[("epsilon", epsilon)]).unwrap()];
            let skewed = crate::fly(&Scenario { effects, ..scenario.clone() }).unwrap();
            for (k, row) in skewed.rows.iter().enumerate() {
                assert_eq!(row.q_rad_s, straight.rows[k].q_rad_s);
                let true_row = (f64::from(k as u32) * (1.0 + epsilon) + 1e-6) as usize;
                assert_eq!(row.u_rad, straight.rows[true_row].u_rad, "row {k}");
            }
            // 0.2 s of the future are missing at the end of a test of 100 s
            let missing = straight.rows.len() - skewed.rows.len();
            assert_eq!(missing > 0, epsilon > 0.0);
            assert!(missing < 15);
        }
    }
}
