//! Inputs of a bench test: steps, two-level sequences, tones.

use rand::RngExt;
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

/// What is sent while the input works; nought before and after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// Nothing at all: a ring-down, or what the air does alone.
    Rest,
    /// A constant of this height.
    Step {
        /// Height, in the unit of the input.
        height: f64,
    },
    /// Two levels ±a, each held for a time drawn uniformly between two dwells; switches fall on samples.
    Prbs {
        /// a, in the unit of the input.
        amplitude: f64,
        /// Shortest and longest dwell, s.
        dwell_s: [f64; 2],
    },
    /// The same, each dwell longer by g |q|, q the measured rate at the switch that begins it: feedback that no
    /// correlation of one sample with the next shows.
    PrbsByRate {
        /// a, in the unit of the input.
        amplitude: f64,
        /// Shortest and longest dwell at rest, s.
        dwell_s: [f64; 2],
        /// g, s per rad/s.
        lengthened: f64,
    },
    /// Equally strong sines, their frequencies drawn in a band.
    Tones {
        /// Effective value of the sum, in the unit of the input.
        effective: f64,
        /// Lowest and highest frequency, Hz.
        band_hz: [f64; 2],
        /// How many.
        count: usize,
    },
}

/// An input under way.
#[derive(Debug)]
pub(crate) struct Excitation {
    input: Input,
    generator: Pcg64,
    tones: Vec<[f64; 2]>,
    level: f64,
    /// When a two-level sequence switches next, s.
    switch_s: f64,
}

impl Excitation {
    pub(crate) fn new(input: Input, mut generator: Pcg64) -> Self {
        let tones = match input {
            Input::Tones { band_hz: [low, high], count, .. } => {
                let mut tone = || [low + (high - low) * generator.random::<f64>(), generator.random()];
                (0..count).map(|_| tone().map(|share| TAU * share)).collect()
            }
            _ => Vec::new(),
        };
        let level = if generator.random_bool(0.5) { 1.0 } else { -1.0 };
        Self { input, generator, tones, level, switch_s: f64::NEG_INFINITY }
    }

    /// What is sent at `t`, the measured rate being `q`. To be asked for at each sample while it works, in order.
    pub(crate) fn at(&mut self, t: f64, q: f64) -> f64 {
        match self.input {
            Input::Rest => 0.0,
            Input::Step { height } => height,
            Input::Prbs { amplitude, dwell_s } => amplitude * self.level_at(t, dwell_s, 0.0),
            Input::PrbsByRate { amplitude, dwell_s, lengthened } => {
                amplitude * self.level_at(t, dwell_s, lengthened * q.abs())
            }
            Input::Tones { effective, .. } => {
                let height = effective * (2.0 / self.tones.len().max(1) as f64).sqrt();
                height * self.tones.iter().map(|[omega, phase]| (omega * t + phase).sin()).sum::<f64>()
            }
        }
    }

    fn level_at(&mut self, t: f64, [shortest, longest]: [f64; 2], added_s: f64) -> f64 {
        // the small share keeps a switch on its sample
        if t + 1e-9 >= self.switch_s {
            self.level = -self.level;
            self.switch_s = t + shortest + (longest - shortest) * self.generator.random::<f64>() + added_s;
        }
        self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, generator};

    fn sent(input: Input, q: f64, samples: u32) -> Vec<f64> {
        let mut excitation = Excitation::new(input, generator(1, Stream::Excitation));
        (0..samples).map(|k| excitation.at(f64::from(k) * 0.02, q)).collect()
    }

    /// Dwells between switches, in samples.
    fn dwells(values: &[f64]) -> Vec<usize> {
        let switches: Vec<usize> = (1..values.len()).filter(|k| values[*k] != values[k - 1]).collect();
        switches.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    #[test]
    fn dwells_stay_in_their_range_and_grow_with_the_rate() {
        let (amplitude, dwell_s) = (0.015, [0.2, 0.4]);
        let plain = sent(Input::Prbs { amplitude, dwell_s }, 0.5, 20_000);
        assert!(plain.iter().all(|u| u.abs() == amplitude));
        assert!(dwells(&plain).iter().all(|dwell| (10..=21).contains(dwell)));
        for (q, range) in [(0.0, 10..=21), (-0.5, 35..=46)] {
            let longer = sent(Input::PrbsByRate { amplitude, dwell_s, lengthened: 1.0 }, q, 20_000);
            assert!(dwells(&longer).iter().all(|dwell| range.contains(dwell)));
        }
    }

    #[test]
    fn tones_have_their_effective_value() {
        let tones = sent(Input::Tones { effective: 0.7, band_hz: [0.1, 1.5], count: 20 }, 0.0, 100_000);
        let power = tones.iter().map(|u| u * u).sum::<f64>() / tones.len() as f64;
        assert!((power.sqrt() / 0.7 - 1.0).abs() < 0.02, "{power}");
    }
}
