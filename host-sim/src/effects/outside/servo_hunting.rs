//! A servo that hunts about the command by a limit cycle of its own (van der Pol): ua = uc + w,
//! ẅ = μ ω (1 − (2 w / a)²) ẇ − ω² w, whose amplitude becomes a while μ is small.

use std::f64::consts::TAU;

use super::{Effect, Entry, Parameter};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "servo_hunting",
    locus: "actuator",
    parameters: &[
        Parameter { name: "a", unit: "rad", range: [0.001, 0.015], signed: false },
        Parameter { name: "f_hz", unit: "Hz", range: [0.4, 2.0], signed: false },
    ],
    moderate_and_strong: [0.0028, 0.004],
    near: &["periodic_moment", "servo_second_order"],
    make: |values, _| {
        let amplitude = values[0].max(1e-9);
        Box::new(ServoHunting { amplitude, omega: TAU * values[1], w: 0.05 * amplitude, rate: 0.0 })
    },
};

/// μ: how fast it settles on its cycle.
const GROWTH: f64 = 0.2;

#[derive(Debug)]
struct ServoHunting {
    amplitude: f64,
    omega: f64,
    w: f64,
    rate: f64,
}

impl Effect for ServoHunting {
    /// Semi-implicit steps, which neither feed nor damp an oscillation.
    fn blade(&mut self, _t: f64, u: f64, dt: f64) -> f64 {
        let before = self.w;
        let damping = GROWTH * self.omega * (1.0 - (2.0 * self.w / self.amplitude).powi(2));
        self.rate += dt * (damping * self.rate - self.omega * self.omega * self.w);
        self.w += dt * self.rate;
        u + (before + self.w) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_settles_on_a_cycle_of_its_amplitude_and_frequency() {
        let mut servo = (ENTRY.make)(&[0.004, 1.5], 0);
        let hunting: Vec<f64> = (0..20_000).map(|_| servo.blade(0.0, 0.01, 1e-3) - 0.01).collect();
        let settled = &hunting[10_000..];
        let highest = settled.iter().fold(0.0_f64, |top, w| top.max(w.abs()));
        assert!((highest / 0.004 - 1.0).abs() < 0.02, "{highest}");
        let crossings = settled.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
        assert!((14..=15).contains(&crossings), "{crossings}");
    }
}
