//! A spring that acts about another zero than the angle's.
//!
//! A rig whose angle keeps to one side hangs in a balance of two moments, and neither shows without the other:
//!
//! ```text
//! M += M0 − G sin θ,    M0 = G sin θ̄ − ∂M/∂u ū     where it hangs
//! ```
//!
//! With gravity alone the model would hang at zero, with a constant moment alone it would turn over: each by itself is worth
//! nothing, and a search that adds one term at a time finds neither. Both are tried in one step. Beside a slow background, which can
//! hold the craft as well, nine in ten are held by a constant moment.

use super::selection::without;
use crate::catalogue::gravity_stiffness::GravityStiffness;
use crate::catalogue::trim_offset::TrimOffset;
use crate::likelihood::fit::{Fit, SKETCH, fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use rayon::prelude::*;

/// Both of them.
pub const PAIR: [&dyn Effect; 2] = [&GravityStiffness, &TrimOffset];
/// What pulls back to the angle's zero.
const SPRINGS: [&str; 3] = ["gravity_stiffness", "linear_stiffness", "cubic_stiffness"];
/// Prior probability that a constant moment holds what hangs aside, and neither the command nor the background.
const HELD: f64 = 0.9;
/// Stiffnesses to begin with, as shares of what turns the input's moment into the angle's spread.
const SHARES: [f64; 2] = [0.3, 1.0];
/// Strengths of the disturbance to begin with: a weak one cannot take the pendulum's swing for its own.
const STRENGTHS: [f64; 2] = [0.03, 0.3];

/// Whether a term of `effects` pulls back to zero where the angle keeps to one side of it, and the user's model has no moment against
/// that.
pub fn pulls_aside(problem: &Problem<'_>, effects: &[&'static dyn Effect]) -> bool {
    let known = problem.baseline.terms.iter().any(|term| is_trim(term.effect));
    !known && effects.iter().any(|e| SPRINGS.contains(&e.about().id)) && problem.hangs_aside
}

/// Whether the effect is the constant moment.
pub fn is_trim(effect: &dyn Effect) -> bool {
    effect.about().id == TrimOffset.about().id
}

/// ln of the prior of the constant moment, or of its absence, in a model that pulls aside.
pub fn log_prior_of_trim(effects: &[&'static dyn Effect]) -> f64 {
    if effects.iter().any(|effect| is_trim(*effect)) { HELD.ln() } else { (1.0 - HELD).ln() }
}

/// `before` with both terms, and with gravity alone from there: beside a slow background the constant moment may not be seen.
/// Nothing where the angle does not keep to one side.
pub fn about_another_zero(problem: &Problem<'_>, before: &Fit) -> Vec<Fit> {
    let both = if problem.hangs_aside { hanging(problem, before) } else { None };
    let alone = both.as_ref().and_then(|both| without(problem, both, both.effects.len() - 1));
    both.into_iter().chain(alone).collect()
}

fn hanging(problem: &Problem<'_>, before: &Fit) -> Option<Fit> {
    let angle = problem.data.mean_angle()?;
    let effects = [&before.effects[..], &PAIR].concat();
    let input = problem.data.mean_input();
    let noise = problem.noise_range();
    let sketch = |(share, strength): (f64, f64)| {
        let mut values = before.minimum.values.clone();
        let stiffness = share * problem.sizes.moment / problem.sizes.theta;
        let gain = problem.unpack(&before.effects, &values).plant.dm_du;
        values[noise.clone()].copy_from_slice(&problem.noise_start(strength));
        values.extend([stiffness, stiffness * angle.sin() - gain * input]);
        fit(problem, &effects, &values, SKETCH)
    };
    let starts: Vec<(f64, f64)> =
        SHARES.iter().flat_map(|&share| STRENGTHS.map(|strength| (share, strength))).collect();
    let sketches: Vec<Fit> = starts.into_par_iter().filter_map(sketch).collect();
    let best = sketches.into_iter().min_by(|a, b| a.criterion().total_cmp(&b.criterion()))?;
    refit(problem, &effects, &best.minimum.values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fixture::{asked, flight_with};

    #[test]
    fn a_craft_that_hangs_aside_is_found_with_its_stiffness_and_a_level_one_is_not_asked() {
        let (stiffness, hangs_at) = (1.2, 0.35_f64);
        let aside = flight_with(3, |_, _, angle| stiffness * (hangs_at.sin() - angle.sin()));
        let fits = asked(&aside, |problem, plain| {
            let value =
                |fit: &Fit| fit.minimum.values[fit.range_of(problem, "gravity_stiffness").unwrap()][0];
            let fits = about_another_zero(problem, plain);
            let gain = |fit: &Fit| plain.criterion() - fit.criterion();
            fits.iter().map(|fit| (fit.ids(), value(fit), gain(fit))).collect::<Vec<_>>()
        });
        let (ids, value, gain) = &fits[0];
        assert_eq!(ids, &["gravity_stiffness", "trim_offset"]);
        assert!((value / stiffness - 1.0).abs() < 0.1 && *gain > 30.0, "{fits:?}");
        assert_eq!(fits[1].0, ["gravity_stiffness"]);
        let level = flight_with(3, |_, _, angle| -stiffness * angle.sin());
        assert_eq!(asked(&level, |problem, plain| about_another_zero(problem, plain).len()), 0);
    }
}
