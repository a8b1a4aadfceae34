//! Evidence for one cause: a cumulative sum for each size and sign.
//!
//! ```text
//! z = ψᵀ e / κ,   i = ψᵀ ψ / κ                              score and information of a block of cycles
//! g = max(0, g + min(a (±z − δ i) − a² i / 2, 2.5)),   a = |s| − δ     s the size tested, δ the dead zone
//! ```
//!
//! While the true size is at most δ, exp of the increment has a conditional mean of 1 at most, whatever the controller does, for
//! e\[k\] is unpredictable from what ψ\[k\] is made of. So the mean time to g ≥ h is at least e^h blocks (Lorden, Annals of
//! Mathematical Statistics 42, 1971, theorem 2), and m sums together reach it no sooner than e^h / m. The block at which g was
//! last zero is the maximum-likelihood estimate of the change (Basseville and Nikiforov, *Detection of Abrupt Changes*, 1993,
//! section 2.2); the sums since then give the size: ŝ = Σz / Σi, deviation 1/√Σi.
//!
//! The trace of a constant moment or offset grows with the time since it began; each sum lets it grow from its own beginning, as
//! 1 − (1 − onset) e^(−pace blocks).
//!
//! Old sums fade with 30 s, which only lowers g.

use super::model::{SIZES, Test};
use super::{larger, smaller};

/// Sums since a possible change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    /// g.
    sum: f32,
    /// Share of its lasting trace that the cause has reached.
    grown: f32,
    /// Σi, with the spread of the cause's own scores.
    i: f32,
    /// Σz and Σi in air of one strength for all causes: what the size is estimated from, and causes are compared by.
    z: f32,
    mass: f32,
    since: u32,
}

/// The sums of one cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    sums: [Sums; SIZES],
    best: Finding,
    /// Mean of (z − ŝ i)² / i over a second and over 20 s.
    spread: [f32; 2],
}

/// Most that one block adds to a sum: a gust that sets in is evidence for anything until the spread has seen it.
const LIMIT: f32 = 2.5;
/// The same while the scores scatter much more about the estimated size than they did: then it is the air that has changed.
const GUSTY: f32 = 0.4;
/// So much more.
const SCATTER: f32 = 2.0;
/// Largest square of a deviation that counts in the spread.
const OUTLIER: f32 = 25.0;
/// Shares of a block in the two means of the spread.
const SPREAD: [f32; 2] = [0.2, 0.01];

/// What speaks most for a cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finding {
    /// The largest g.
    pub sum: f32,
    /// Logarithm of the likelihood ratio at the estimated size against none, in air of one strength for all causes: what they are
    /// compared by.
    pub likelihood: f32,
    /// ŝ.
    pub size: f32,
    /// Σi since the change.
    pub information: f32,
    /// Tick of the change.
    pub since: u32,
}

impl Evidence {
    /// Takes a block that ends at `tick`, in air of the strength κ = `air`; what was known before counts `kept`. Returns the
    /// information that it held.
    pub fn take(&mut self, test: &Test, score: f32, information: f32, air: f32, kept: f32, tick: u32) -> f32 {
        let [fast, slow] = self.spread;
        let strength = test.calibration * larger(air, larger(fast, slow));
        let limit = if fast > SCATTER * larger(slow, 1.0) { GUSTY } else { LIMIT };
        let [at_once, pace] = test.onset;
        let (per_strength, per_air) = (1.0 / strength, 1.0 / air);
        let (mut best, mut most) = (None, 0.0);
        for (sums, size) in self.sums.iter_mut().zip(test.sizes) {
            let reach = size.abs() - test.dead_zone;
            let grown = if sums.sum > 0.0 { sums.grown + pace * (1.0 - sums.grown) } else { at_once };
            let (z, i) = (grown * score, grown * grown * information);
            let toward = if size < 0.0 { -z } else { z };
            let step = reach * (toward - (test.dead_zone + 0.5 * reach) * i) * per_strength;
            let sum = kept * sums.sum + smaller(step, limit);
            if reach > 0.0 && sum > 0.0 {
                sums.sum = sum;
                sums.grown = grown;
                sums.i = kept * sums.i + i * per_strength;
                sums.z = kept * sums.z + z * per_air;
                sums.mass = kept * sums.mass + i * per_air;
                if sum > most {
                    (best, most) = (Some(&*sums), sum);
                }
            } else {
                *sums = Sums { since: tick, ..Sums::default() };
            }
        }
        let mut reached = 0.0;
        self.best = match best {
            Some(&Sums { sum, grown, i, z, mass, since }) if mass > 0.0 => {
                reached = grown;
                Finding { sum, likelihood: 0.5 * z * z / mass, size: z / mass, information: i, since }
            }
            _ => Finding { since: tick, ..Finding::default() },
        };
        if information > 0.0 {
            let left = score - self.best.size * reached * information;
            let most = OUTLIER * test.calibration * air;
            let square = smaller(left * left / information, most) / test.calibration;
            let ([fast, slow], [of_fast, of_slow]) = (self.spread, SPREAD);
            self.spread = [fast + of_fast * (square - fast), slow + of_slow * (square - slow)];
        }
        information / strength
    }

    /// What speaks most for the cause.
    #[must_use]
    pub const fn best(&self) -> &Finding {
        &self.best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: Test = Test {
        dead_zone: 0.05,
        calibration: 1.0,
        onset: [1.0, 0.0],
        sizes: [-0.5, -0.25, -0.1, 0.1, 0.25, 0.5],
    };

    #[test]
    fn a_size_beyond_the_dead_zone_is_found_with_its_beginning() {
        let mut evidence = Evidence::default();
        for tick in 0..200 {
            let size = if tick < 120 { 0.0 } else { -0.3 };
            // without noise z = s i
            evidence.take(&TEST, size * 10.0, 10.0, 1.0, 1.0, tick);
        }
        let best = evidence.best();
        assert!((best.size + 0.3).abs() < 1e-4 && best.since == 119, "{best:?}");
        let expected = 0.5 * 0.3_f32 * 0.3 * 800.0;
        assert!((best.likelihood - expected).abs() < 1e-2 * expected && best.sum < best.likelihood);
    }

    #[test]
    fn without_evidence_the_change_would_begin_now() {
        let mut evidence = Evidence::default();
        for tick in 0..100 {
            evidence.take(&TEST, 0.0, 10.0, 1.0, 1.0, tick);
            assert_eq!(evidence.best(), &Finding { since: tick, ..Finding::default() });
        }
    }

    #[test]
    fn what_lies_within_the_dead_zone_is_never_evidence() {
        let mut evidence = Evidence::default();
        for tick in 0..10_000 {
            evidence.take(&TEST, 0.05 * 10.0, 10.0, 1.0, 1.0, tick);
            assert_eq!(evidence.best().sum, 0.0);
        }
    }

    /// A craft at rest excites nothing: its blocks hold neither score nor information.
    #[test]
    fn what_holds_nothing_says_nothing() {
        let mut evidence = Evidence::default();
        for tick in 0..100 {
            assert_eq!(evidence.take(&TEST, 0.0, 0.0, 1.0, 1.0, tick), 0.0);
            assert_eq!(evidence.best(), &Finding { since: tick, ..Finding::default() });
        }
        assert_eq!(evidence.spread, [0.0; 2]);
        evidence.take(&TEST, 5.0, 10.0, 1.0, 1.0, 100);
        assert_eq!(evidence.best().since, 99);
        // traces so small that their squares are zero
        let mut evidence = Evidence::default();
        evidence.take(&TEST, 1e-22, 0.0, 1.0, 1.0, 7);
        assert_eq!(evidence.best(), &Finding { since: 7, ..Finding::default() });
    }

    #[test]
    fn a_cause_that_is_gone_loses_its_evidence() {
        let mut evidence = Evidence::default();
        (0..100).for_each(|tick| {
            evidence.take(&TEST, 2.0, 10.0, 1.0, 0.993, tick);
        });
        assert!(evidence.best().sum > 5.0);
        (100..1000).for_each(|tick| {
            evidence.take(&TEST, 0.0, 10.0, 1.0, 0.993, tick);
        });
        assert_eq!(evidence.best().sum, 0.0);
    }
}
