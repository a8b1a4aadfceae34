//! A coarse servo: it takes whole steps only, ua = Δ round(uc/Δ).

use super::{Effect, Entry, Parameter};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "command_quantiser",
    locus: "actuator",
    parameters: &[Parameter { name: "step", unit: "rad", range: [0.004, 0.028], signed: false }],
    moderate_and_strong: [0.0056, 0.0077],
    near: &["servo_deadband", "linkage_backlash", "thrust_curve"],
    make: |values, _| Box::new(CommandQuantiser(values[0])),
};

#[derive(Debug)]
struct CommandQuantiser(f64);

impl Effect for CommandQuantiser {
    fn blade(&mut self, _t: f64, u: f64, _dt: f64) -> f64 {
        if self.0 > 0.0 { self.0 * (u / self.0).round() } else { u }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_become_whole_steps() {
        let mut servo = CommandQuantiser(0.01);
        let sent = [0.0049, 0.0051, -0.0149, -0.0151];
        let expected = [0.0, 0.01, -0.01, -0.02];
        for (u, step) in sent.into_iter().zip(expected) {
            assert!((servo.blade(0.0, u, 1e-3) - step).abs() < 1e-15);
        }
    }
}
