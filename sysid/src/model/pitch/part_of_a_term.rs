//! What one term of a model does over a sample: the model with it against the model without it.

use super::{Driven, PitchModel, Point};
use crate::model::plant::Q;

/// The part of one term from one row to the next.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// The moment, held over the sample, that moves the pitch rate by as much as the term does, N m.
    pub moment: f64,
    /// What the term adds to the measured rate at the next row, rad/s.
    pub measured: f64,
    /// Where the model with the term is at the next row, before the measurement is seen.
    pub next: Point,
}

impl PitchModel<'_> {
    /// The part of the term called `id` between row `k`, where the model is at `point`, and the next; `without` is the
    /// same model without that term, and both are driven by the input of a run. `None` where either diverges.
    pub fn part(
        &self,
        without: &PitchModel<'_>,
        id: &str,
        point: &Point,
        [with_it, without_it]: [&Driven<'_, '_>; 2],
        k: usize,
    ) -> Option<Part> {
        let (mut next, mut other) = (*point, self.less(id, point));
        if !with_it.advance(&mut next, k) || !without_it.advance(&mut other, k) {
            return None;
        }
        let per_moment: f64 = self.per_moment_of_substep.iter().map(|response| response[Q]).sum();
        let sensed = self.sensed(&next)[0] - without.sensed(&self.less(id, &next))[0];
        Some(Part { moment: (next.x[Q] - other.x[Q]) / per_moment, measured: sensed, next })
    }

    /// `point` without the own states of the term called `id`.
    fn less(&self, id: &str, point: &Point) -> Point {
        let own =
            self.terms.iter().find(|term| term.effect.about().id == id).map_or(0..0, |term| term.own.clone());
        let mut less = *point;
        let kept = point.own.len() - own.len();
        less.own.copy_within(own.end.., own.start);
        less.own[kept..].fill(0.0);
        less
    }
}
