//! The terms of a model in the order in which they act, and what all of them together do.

use super::{OWN_STATES, Output, Term};
use crate::model::effect::{Conditions, Effect};

/// A term with the place of its own states among those of all terms.
#[derive(Clone)]
pub struct Placed<'a> {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Its parameters.
    pub values: &'a [f64],
    /// Where its own states stand.
    pub own: core::ops::Range<usize>,
    /// Where those stand that carry the collective thrust.
    pub collective: core::ops::Range<usize>,
}

/// The terms that act, those of the thrust behind those of the blades' angle; the background acts by its noise alone.
pub fn placed(terms: &[Term]) -> Vec<Placed<'_>> {
    let mut acting: Vec<&Term> = terms.iter().filter(|term| !term.effect.is_background()).collect();
    acting.sort_by_key(|term| term.effect.of_thrust());
    let mut placed: Vec<Placed<'_>> = Vec::with_capacity(acting.len());
    for Term { effect, values } in acting {
        let begin = placed.last().map_or(0, |before| before.collective.end);
        let end = begin + effect.states();
        let carried = if effect.carries_thrust() { effect.states() } else { 0 };
        placed.push(Placed { effect: *effect, values, own: begin..end, collective: end..end + carried });
    }
    placed
}

/// What a log shows of `y`.
pub fn limited(terms: &[Placed<'_>], y: Output) -> Output {
    terms.iter().fold(y, |y, term| term.effect.limit(term.values, y))
}

/// Delay that the terms add, s.
pub fn later(terms: &[Placed<'_>], at: &Conditions) -> f64 {
    terms.iter().map(|term| term.effect.delay(term.values, at)).sum()
}

/// Factor by which the terms change the inertia.
pub fn inertia_factor(terms: &[Placed<'_>], at: &Conditions) -> f64 {
    terms.iter().map(|term| term.effect.inertia(term.values, at)).product()
}

/// Stiffness and damping (N m/rad, N m s/rad) that stand for the effects' moments in the mean, at the signals'
/// sizes: statistical linearisation (Booton, 1954) by three Gauss–Hermite nodes.
pub fn linear_part(terms: &[&Term], at: &Conditions) -> (f64, f64) {
    let sizes = &at.sizes;
    let own = [0.0; OWN_STATES];
    let moment = |q: f64, theta: f64| -> f64 {
        terms.iter().map(|term| term.effect.moment(&term.values, &own, q, theta, at)).sum()
    };
    let root = 3f64.sqrt();
    let slope = |plus: f64, minus: f64, size: f64| -(plus - minus) / (2.0 * root * size);
    let (dq, dtheta) = (root * sizes.q, root * sizes.theta);
    (
        slope(moment(0.0, dtheta), moment(0.0, -dtheta), sizes.theta),
        slope(moment(dq, 0.0), moment(-dq, 0.0), sizes.q),
    )
}
