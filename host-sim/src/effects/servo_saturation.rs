//! The range of the collective is exhausted: |ua| ≤ u_max.

use super::{Effect, Entry, Parameter};

pub(super) const ENTRY: Entry = Entry {
    id: "servo_saturation",
    locus: "actuator",
    parameters: &[Parameter { name: "u_max", unit: "rad", range: [0.006, 0.018], signed: false }],
    moderate_and_strong: [0.0166, 0.0062],
    near: &[],
    make: |values, _| Box::new(ServoSaturation(values[0])),
};

#[derive(Debug)]
struct ServoSaturation(f64);

impl Effect for ServoSaturation {
    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        u.clamp(-self.0, self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_inside_the_range_passes_and_the_rest_stays_at_its_end() {
        let mut servo = ServoSaturation(0.01);
        let sent = [-0.02, -0.01, 0.004, 0.03];
        assert_eq!(sent.map(|u| servo.blade(0.0, u, 1e-3)), [-0.01, -0.01, 0.004, 0.01]);
    }
}
