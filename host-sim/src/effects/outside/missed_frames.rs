//! Frames to the servo are missed: for random spans it holds the last command that it got.

use super::spans::Spans;
use super::{Effect, Entry, Parameter};
use crate::seeds::{Stream, generator};

pub(in crate::effects) const ENTRY: Entry = Entry {
    id: "missed_frames",
    locus: "actuator",
    parameters: &[
        Parameter { name: "share", unit: "-", range: [0.05, 0.6], signed: false },
        Parameter { name: "span_s", unit: "s", range: [0.06, 0.3], signed: false },
    ],
    moderate_and_strong: [0.168, 0.365],
    near: &["extra_delay", "servo_lag"],
    make: |values, seed| {
        let missed = Spans::drawn(&mut generator(seed, Stream::Effect), values[1], values[0]);
        Box::new(MissedFrames { missed, held: 0.0 })
    },
};

#[derive(Debug)]
struct MissedFrames {
    missed: Spans,
    held: f64,
}

impl Effect for MissedFrames {
    fn blade(&mut self, t: f64, u: f64, _dt: f64) -> f64 {
        if !self.missed.contain(t) {
            self.held = u;
        }
        self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_is_a_true_one_and_the_share_is_old() {
        let mut servo = (ENTRY.make)(&[0.3, 0.1], 2);
        // the time itself as the command: what is old is behind, by two spans where they touch
        let behind: Vec<f64> =
            (0..200_000).map(|k| f64::from(k) * 1e-3).map(|t| t - servo.blade(t, t, 1e-3)).collect();
        assert!(behind.iter().all(|age| (0.0..0.302).contains(age)));
        let old = behind.iter().filter(|age| **age > 0.0).count() as f64 / behind.len() as f64;
        assert!((old - 0.3).abs() < 0.04, "{old}");
    }
}
