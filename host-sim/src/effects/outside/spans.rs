//! Spans of time, drawn by a seed: things that come and go.

use rand::RngExt;
use rand_distr::{Distribution, Exp1};
use rand_pcg::Pcg64;

/// Longer than any test, s.
const HORIZON_S: f64 = 600.0;

/// Spans [from, to], s, in order and apart.
#[derive(Debug)]
pub(super) struct Spans(Vec<[f64; 2]>);

impl Spans {
    /// Spans of 0.5 to 1.5 times `length_s`, with exponential gaps between them, that fill `share` of the time.
    pub(super) fn drawn(generator: &mut Pcg64, length_s: f64, share: f64) -> Self {
        let length_s = length_s.max(1e-3);
        let gap_s = length_s * (1.0 / share.clamp(1e-3, 0.99) - 1.0);
        let mut spans = Vec::new();
        let mut t = 0.0;
        while t < HORIZON_S {
            let wait: f64 = Exp1.sample(generator);
            let from = t + gap_s * wait;
            t = from + length_s * generator.random_range(0.5..1.5);
            spans.push([from, t]);
        }
        Self(spans)
    }

    /// Whether `t` lies in one of them.
    pub(super) fn contain(&self, t: f64) -> bool {
        let begun = self.0.partition_point(|[from, _]| *from <= t);
        begun.checked_sub(1).and_then(|i| self.0.get(i)).is_some_and(|[_, to]| t < *to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, generator};

    #[test]
    fn they_fill_their_share_of_the_time() {
        let spans = Spans::drawn(&mut generator(1, Stream::Effect), 0.2, 0.3);
        let inside = (0..600_000).filter(|k| spans.contain(f64::from(*k) * 1e-3)).count();
        // 900 spans: the share is known to 3 % of itself or so
        assert!((inside as f64 / 600_000.0 - 0.3).abs() < 0.03, "{inside}");
        assert!(spans.0.windows(2).all(|pair| pair[0][1] <= pair[1][0]));
        assert!(!spans.contain(spans.0[0][0] - 1e-9) && spans.contain(spans.0[0][0] + 1e-9));
    }
}
