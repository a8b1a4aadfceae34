//! An actuator or a link that stalls: for random spans of some seconds the command comes Δ later.

use super::spans::Spans;
use super::{Effect, Entry, Parameter};
use crate::seeds::{Stream, generator};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "intermittent_delay",
    locus: "timing",
    parameters: &[
        Parameter { name: "Delta", unit: "s", range: [0.03, 0.3], signed: false },
        Parameter { name: "share", unit: "-", range: [0.2, 0.5], signed: false },
    ],
    moderate_and_strong: [0.09, 0.1265],
    near: &["extra_delay", "servo_lag", "clock_skew"],
    make: |values, seed| {
        let stalled = Spans::drawn(&mut generator(seed, Stream::Effect), STALL_S, values[1]);
        Box::new(IntermittentDelay { added_s: values[0], stalled })
    },
};

/// Mean length of a stall, s.
const STALL_S: f64 = 3.0;

#[derive(Debug)]
struct IntermittentDelay {
    added_s: f64,
    stalled: Spans,
}

impl Effect for IntermittentDelay {
    fn delay_s(&self, t: f64) -> f64 {
        if self.stalled.contain(t) { self.added_s } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_delay_comes_and_goes() {
        let link = (ENTRY.make)(&[0.1, 0.4], 5);
        let delays: Vec<f64> = (0..50_000).map(|k| link.delay_s(f64::from(k) * 0.01)).collect();
        assert!(delays.iter().all(|delay| [0.0, 0.1].contains(delay)));
        let share = delays.iter().filter(|delay| **delay > 0.0).count() as f64 / delays.len() as f64;
        // some seventy spans in 500 s
        assert!((share - 0.4).abs() < 0.12, "{share}");
    }
}
