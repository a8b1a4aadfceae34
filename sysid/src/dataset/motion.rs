//! Which ways the axis moves.

use super::{Dataset, Run};

/// Largest rate of the lesser way, as a share of that of the other, from which an axis moves both ways.
const TURNING: f64 = 0.05;

impl Dataset {
    /// Whether the axis moves both ways: what shows where a motion turns, cannot without.
    pub fn moves_both_ways(&self) -> bool {
        let rates = self.runs.iter().flat_map(Run::rate_or_slope);
        let (least, most) = rates.fold((0.0f64, 0.0f64), |(low, high), rate| (low.min(rate), high.max(rate)));
        (-least).min(most) > TURNING * (-least).max(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::{Flight, flight};

    #[test]
    fn an_axis_that_moves_both_ways_is_told_from_one_that_does_not() {
        let both_ways = |flown: &Flight| Dataset::new(&[flown.recording()]).unwrap().moves_both_ways();
        let there_and_back = flight(1, 0.0);
        let one_way = |slowest: f64| Flight {
            q: there_and_back.q.iter().map(|q| q.abs() + slowest).collect(),
            ..there_and_back.clone()
        };
        assert!(both_ways(&there_and_back));
        assert!(!both_ways(&one_way(0.0)) && !both_ways(&one_way(-0.001)));
    }
}
