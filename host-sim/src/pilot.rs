//! The pilot of section IV: steps, doublets and ramps of the pitch reference, by seed.

use rand::RngExt;
use rand_pcg::Pcg64;

/// Largest reference, rad.
const LARGEST_RAD: f64 = 0.25;
/// Smallest that is worth flying, rad.
const SMALLEST_RAD: f64 = 0.08;

#[derive(Clone, Copy, Debug)]
enum Manoeuvre {
    Step,
    Doublet,
    Ramp,
}

#[derive(Clone, Copy, Debug)]
struct Piece {
    manoeuvre: Manoeuvre,
    begin_s: f64,
    length_s: f64,
    /// Height, rad.
    height: f64,
}

/// A reference over the time of section IV.
#[derive(Clone, Debug)]
pub struct ManualReference {
    pieces: Vec<Piece>,
}

impl ManualReference {
    /// A reference for `length_s` seconds: manoeuvres of 2 to 4 s and ±0.08 to ±0.25 rad with 0.5 to 1.5 s of
    /// level flight between them.
    pub fn drawn(length_s: f64, generator: &mut Pcg64) -> Self {
        let mut pieces = Vec::new();
        let mut begin_s = 0.5;
        while begin_s < length_s {
            let manoeuvre =
                [Manoeuvre::Step, Manoeuvre::Doublet, Manoeuvre::Ramp][generator.random_range(0..3)];
            let sign = if generator.random_bool(0.5) { 1.0 } else { -1.0 };
            let height = sign * generator.random_range(SMALLEST_RAD..LARGEST_RAD);
            let length_s = generator.random_range(2.0..4.0);
            pieces.push(Piece { manoeuvre, begin_s, length_s, height });
            begin_s += length_s + generator.random_range(0.5..1.5);
        }
        Self { pieces }
    }

    /// The same, so many times as high.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        self.pieces.iter_mut().for_each(|piece| piece.height *= factor);
        self
    }

    /// θref (rad) `t_s` after the beginning of the section.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let later = self.pieces.partition_point(|piece| piece.begin_s <= t_s);
        let Some(piece) = later.checked_sub(1).and_then(|i| self.pieces.get(i)) else { return 0.0 };
        let done = (t_s - piece.begin_s) / piece.length_s;
        if done >= 1.0 {
            return 0.0;
        }
        piece.height
            * match piece.manoeuvre {
                Manoeuvre::Step => 1.0,
                Manoeuvre::Doublet => {
                    if done < 0.5 {
                        1.0
                    } else {
                        -1.0
                    }
                }
                // up and down again
                Manoeuvre::Ramp => 1.0 - (2.0 * done - 1.0).abs(),
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, generator};

    #[test]
    fn references_are_bounded_busy_and_begin_level() {
        for seed in 0..20 {
            let reference = ManualReference::drawn(25.0, &mut generator(seed, Stream::Reference));
            let values: Vec<f64> = (0..1250).map(|k| reference.at(f64::from(k) * 0.02)).collect();
            assert_eq!(values[0], 0.0);
            assert!(values.iter().all(|v| v.abs() <= LARGEST_RAD));
            assert!(values.iter().filter(|v| v.abs() > 0.02).count() > 500);
        }
    }
}
