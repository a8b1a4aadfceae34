//! A moment that drifts over the whole recording, and one that changes once.

use super::{Search, without};
use crate::diagnosis::gust::is_drift;

impl Search<'_, '_> {
    /// The model at `place` with what acts from some moment on in the place of a background that drifts: a random walk follows
    /// any step, and with it in the model none is left to be seen.
    pub(super) fn visit_change_instead(&mut self, place: usize) {
        let fit = &self.visited[place].fit;
        let drift = (0..fit.effects.len()).find(|&i| {
            let own = &fit.minimum.values[fit.own_range(self.problem, i)];
            fit.effects[i].noise(own).is_some_and(|third| is_drift(&third, &self.problem.sizes))
        });
        let rest = drift.and_then(|i| without(self.problem, fit, i));
        let Some(rest) = rest.and_then(|rest| self.visit(rest)) else { return };
        self.once_more(rest, &self.candidates.acting_from_a_moment());
    }
}
