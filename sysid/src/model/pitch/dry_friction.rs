//! Dry friction over a substep: as much of it as stops the motion, and no more than there is (implicit in the sign: Moreau, 1988),
//! rest where it falls within the substep. A sign, however smoothed, overshoots rest at every step where friction is large against
//! the inertia, and what a fit sees then is that trembling.

use super::PitchModel;
use super::placed::inertia_factor;
use crate::model::effect::{Conditions, Effect};
use crate::model::plant::Q;

/// Whether an effect with these values is dry friction.
pub fn rubs(effect: &dyn Effect, values: &[f64]) -> bool {
    effect.friction(values, 0.0).is_some()
}

impl PitchModel<'_> {
    /// Dry friction over a substep that begins at the rate `before` and would end at the rate `free` without it: its mean moment, and
    /// the mean rate by which the angle moves less where the motion comes to rest on the way, at a share of the substep at which it
    /// has fallen to zero evenly. From rest it goes on if more drives it than friction holds.
    pub(super) fn rubbed(&self, before: f64, free: f64, at: &Conditions) -> (f64, f64) {
        let inertia = inertia_factor(&self.terms, at);
        let lost = |rate: f64| {
            let levels = self.rubbing.iter().filter_map(|term| term.effect.friction(term.values, rate));
            self.per_moment[Q] * levels.sum::<f64>() / inertia
        };
        let slid = |rate: f64| free - lost(rate).copysign(before);
        let mut end = slid(before);
        let mut comes_to_rest = 0.0;
        if before * end > 0.0 {
            end = slid(0.5 * (before + end));
        }
        if before * end <= 0.0 {
            let moved = if before == 0.0 { 0.0 } else { before / (before - end) };
            let driven = free - before;
            let gone_on = |rate: f64| {
                (1.0 - moved) * (driven.abs() - lost(rate.copysign(driven))).max(0.0).copysign(driven)
            };
            end = gone_on(0.0);
            if end != 0.0 {
                end = gone_on(0.5 * end);
            }
            comes_to_rest = -0.5 * (before * (1.0 - moved) + end * moved);
        }
        ((end - free) / self.per_moment[Q], comes_to_rest)
    }
}
