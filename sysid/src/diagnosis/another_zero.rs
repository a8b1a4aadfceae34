//! A spring that acts about another zero than the angle's, and one that the command hardly moves.
//!
//! A rig whose angle keeps to one side hangs in a balance of two moments, and neither shows without the other:
//!
//! ```text
//! M += M0 − G sin θ,    M0 = G sin θ̄ − ∂M/∂u ū     where it hangs
//! ```
//!
//! With gravity alone the model would hang at zero, with a constant moment alone it would turn over: each by itself is worth
//! nothing, and a search that adds one term at a time finds neither. Both are tried in one step, and so is gravity about θ̄ as its
//! zero, which over large swings is not the same. Beside a slow background, which can hold the craft as well, eight in ten are held
//! by a constant moment, and one in ten by the zero of its springs or of the sensor.

use super::selection::without;
use crate::catalogue::gravity_stiffness::{GravityStiffness, STIFFEST};
use crate::catalogue::linear_stiffness::LinearStiffness;
use crate::catalogue::position_drive::PositionDrive;
use crate::catalogue::rest_angle::RestAngle;
use crate::catalogue::trim_offset::TrimOffset;
use crate::likelihood::fit::{Fit, SKETCH, fit, refit};
use crate::likelihood::problem::Problem;
use crate::model::baseline::{Regression, swing_of};
use crate::model::effect::Effect;
use rayon::prelude::*;

/// What hangs, and what may hold it.
const PAIRS: [[&dyn Effect; 2]; 4] = [
    [&GravityStiffness, &TrimOffset],
    [&GravityStiffness, &RestAngle],
    [&LinearStiffness, &TrimOffset],
    [&LinearStiffness, &RestAngle],
];
/// What pulls back to the angle's zero.
const SPRINGS: [&str; 3] = ["gravity_stiffness", "linear_stiffness", "cubic_stiffness"];
/// Those of them that stand in each other's place.
const STRAIGHT: [&str; 2] = ["gravity_stiffness", "linear_stiffness"];
/// Prior probability that a constant moment holds what hangs aside, or another zero, and neither the command nor the background.
const HELD: f64 = 0.8;
const ZEROED: f64 = 0.1;
/// Stiffnesses to begin with, beside that of the swing, as shares of what turns the input's moment into the angle's spread.
const SHARES: [f64; 2] = [0.3, 1.0];
/// Strengths of the disturbance to begin with: a weak one cannot take the pendulum's swing for its own.
const STRENGTHS: [f64; 2] = [0.03, 0.3];

/// Whether a term of `effects` pulls back to zero where the angle keeps to one side of it, and the user's model has nothing that holds
/// it there.
pub fn pulls_aside(problem: &Problem<'_>, effects: &[&'static dyn Effect]) -> bool {
    let known: Vec<&dyn Effect> = problem.baseline.terms.iter().map(|term| term.effect).collect();
    holder(&known).is_none() && effects.iter().any(|e| SPRINGS.contains(&e.about().id)) && problem.hangs_aside
}

/// Whether the effect is the constant moment.
pub fn is_trim(effect: &dyn Effect) -> bool {
    effect.about().id == TrimOffset.about().id
}

/// The term of `effects` that holds them aside, the constant moment before another zero.
pub fn holder(effects: &[&'static dyn Effect]) -> Option<&'static dyn Effect> {
    PAIRS.into_iter().find_map(|[_, held]| effects.iter().copied().find(|e| e.about().id == held.about().id))
}

/// ln of the prior of what holds a model that pulls aside, or of its absence.
pub fn log_prior_of_holder(effects: &[&'static dyn Effect]) -> f64 {
    match holder(effects) {
        Some(held) if is_trim(held) => HELD.ln(),
        Some(_) => ZEROED.ln(),
        None => (1.0 - HELD - ZEROED).ln(),
    }
}

/// `before` with both terms of each pair that is `asked_of`, and with its spring alone from there: beside a slow background what holds
/// it may not be seen. Nothing where the angle does not keep to one side.
pub fn about_another_zero(
    problem: &Problem<'_>,
    before: &Fit,
    asked_of: impl Fn(&dyn Effect) -> bool,
) -> Vec<Fit> {
    if !problem.hangs_aside || has_straight_spring(problem, before) {
        return Vec::new();
    }
    let swing = swing_of(problem.data);
    let asked = PAIRS.into_iter().filter(|pair| pair.iter().all(|e| asked_of(*e)));
    let hanging = asked.filter_map(|pair| hanging(problem, before, pair, swing.as_ref()));
    let with_alone = |both: Fit| {
        let alone = without(problem, &both, both.effects.len() - 1);
        std::iter::once(both).chain(alone)
    };
    hanging.flat_map(with_alone).collect()
}

/// Whether the user's model or `before` has gravity or a straight spring.
fn has_straight_spring(problem: &Problem<'_>, before: &Fit) -> bool {
    let known = problem.baseline.terms.iter().map(|term| term.effect);
    known.chain(before.effects.iter().copied()).any(|e| STRAIGHT.contains(&e.about().id))
}

/// `before` with gravity, or a spring that is too stiff for it, whichever is `asked_of`, where the motion swings by a regression
/// ([`swing_of`]) and hangs at zero: a pendulum that the air keeps swinging moves by itself more than by the command, and a
/// disturbance that has settled on its frequency leaves nothing for a spring to be found by.
pub fn about_zero(problem: &Problem<'_>, before: &Fit, asked_of: impl Fn(&dyn Effect) -> bool) -> Vec<Fit> {
    let holds = |id: &str| SPRINGS.contains(&id) || id == PositionDrive.about().id;
    let springs = before.effects.iter().any(|e| holds(e.about().id));
    if problem.hangs_aside || springs || has_straight_spring(problem, before) {
        return Vec::new();
    }
    let Some(swing) = swing_of(problem.data) else { return Vec::new() };
    let stiffness = problem.baseline.plant.inertia * swing.stiffness;
    let spring: &'static dyn Effect =
        if swing.stiffness < STIFFEST { &GravityStiffness } else { &LinearStiffness };
    // a drive at its limit goes at one speed, and stands still in between
    let fastest = 2.0 * problem.baseline.plant.inertia * swing.dm_dq.abs() * problem.sizes.q;
    let drive: &'static dyn Effect = &PositionDrive;
    let starts = [(spring, vec![stiffness]), (drive, vec![stiffness, fastest])];
    let asked = starts.into_iter().filter(|(effect, _)| asked_of(*effect));
    let found = asked.filter_map(|(effect, own)| {
        let effects = [&before.effects[..], &[effect]].concat();
        let sketch = |strength: f64| {
            let mut values = as_it_swings(problem, before, &swing);
            values[problem.noise_range()].copy_from_slice(&problem.noise_start(strength));
            values.extend(&own);
            fit(problem, &effects, &values, SKETCH)
        };
        best_of(problem, &effects, STRENGTHS.into_par_iter().filter_map(sketch).collect())
    });
    found.collect()
}

/// The values of `before`, with the plant that the regression has found.
fn as_it_swings(problem: &Problem<'_>, before: &Fit, swing: &Regression) -> Vec<f64> {
    let inertia = problem.baseline.plant.inertia;
    let mut values = before.minimum.values.clone();
    (values[0], values[1]) = (inertia * swing.dm_dq, inertia * swing.dm_du);
    if problem.baseline.delay_free {
        values[2] = swing.delay;
    }
    values
}

fn hanging(
    problem: &Problem<'_>,
    before: &Fit,
    pair: [&'static dyn Effect; 2],
    swing: Option<&Regression>,
) -> Option<Fit> {
    let angle = problem.data.mean_angle()?;
    let effects = [&before.effects[..], &pair].concat();
    let input = problem.data.mean_input();
    let inertia = problem.baseline.plant.inertia;
    let usual = problem.sizes.moment / problem.sizes.theta;
    let plants = SHARES.map(|share| (share * usual, before.minimum.values.clone())).into_iter();
    let swings = swing.map(|swing| (inertia * swing.stiffness, as_it_swings(problem, before, swing)));
    let of_gravity = pair[0].about().id == GravityStiffness.about().id;
    let (most, half) = (STIFFEST * inertia, 0.5 * STIFFEST * inertia);
    let mut plants: Vec<(f64, Vec<f64>)> = plants.chain(swings).collect();
    match of_gravity {
        true => plants.iter_mut().for_each(|(k, _)| *k = if *k < most { *k } else { half }),
        false => plants.retain(|(k, _)| *k >= most),
    }
    plants.dedup();
    let sketch = |((stiffness, values), strength): ((f64, Vec<f64>), f64)| {
        let mut values = values;
        let gain = problem.unpack(&before.effects, &values).plant.dm_du;
        values[problem.noise_range()].copy_from_slice(&problem.noise_start(strength));
        let turned = if of_gravity { angle.sin() } else { angle };
        let holds = stiffness * turned - gain * input;
        values.extend([stiffness, if is_trim(pair[1]) { holds } else { holds / stiffness }]);
        fit(problem, &effects, &values, SKETCH)
    };
    let starts: Vec<_> =
        plants.iter().flat_map(|plant| STRENGTHS.map(|strength| (plant.clone(), strength))).collect();
    best_of(problem, &effects, starts.into_par_iter().filter_map(sketch).collect())
}

/// The best of several sketches, fitted to the end.
fn best_of(problem: &Problem<'_>, effects: &[&'static dyn Effect], sketches: Vec<Fit>) -> Option<Fit> {
    let best = sketches.into_iter().min_by(|a, b| a.criterion().total_cmp(&b.criterion()))?;
    refit(problem, effects, &best.minimum.values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fixture::{asked, flight_with, flown_by};

    #[test]
    fn a_craft_that_hangs_aside_is_found_with_its_stiffness_and_a_level_one_is_not_asked() {
        let (stiffness, hangs_at) = (1.2, 0.35_f64);
        let aside = flight_with(3, |_, _, angle| stiffness * (hangs_at.sin() - angle.sin()));
        let fits = asked(&aside, |problem, plain| {
            let value =
                |fit: &Fit| fit.minimum.values[fit.range_of(problem, "gravity_stiffness").unwrap()][0];
            let fits = about_another_zero(problem, plain, |_| true);
            let gain = |fit: &Fit| plain.criterion() - fit.criterion();
            fits.iter().map(|fit| (fit.ids(), value(fit), gain(fit))).collect::<Vec<_>>()
        });
        let (ids, value, gain) = &fits[0];
        assert_eq!(ids, &["gravity_stiffness", "trim_offset"]);
        assert!((value / stiffness - 1.0).abs() < 0.1 && *gain > 30.0, "{fits:?}");
        assert_eq!(fits[1].0, ["gravity_stiffness"]);
        let level = flight_with(3, |_, _, angle| -stiffness * angle.sin());
        assert_eq!(asked(&level, |problem, plain| about_another_zero(problem, plain, |_| true).len()), 0);
    }

    #[test]
    fn what_is_stiffer_than_gravity_can_be_is_a_spring_aside_or_level() {
        let stiffness = |problem: &Problem<'_>| 1.5 * STIFFEST * problem.baseline.plant.inertia;
        let inertia = asked(&flight_with(3, |_, _, _| 0.0), |problem, _| problem.baseline.plant.inertia);
        for hangs_at in [0.35, 0.0] {
            let strong = flight_with(3, |_, _, _| 0.0).u.iter().map(|u| 30.0 * u).collect();
            let held = flown_by(3, strong, |_, rate, angle| {
                inertia * (1.5 * STIFFEST * (hangs_at - angle) - 15.0 * rate)
            });
            let found = asked(&held, |problem, plain| {
                let aside = about_another_zero(problem, plain, |_| true);
                let fits: Vec<Fit> = aside.into_iter().chain(about_zero(problem, plain, |_| true)).collect();
                let best = fits.into_iter().min_by(|a, b| a.criterion().total_cmp(&b.criterion())).unwrap();
                let value = best.minimum.values[best.range_of(problem, "linear_stiffness").unwrap()][0];
                (value / stiffness(problem), plain.criterion() - best.criterion())
            });
            // the flight goes by rows, of which a swing has twelve
            assert!((found.0 - 1.0).abs() < 0.2 && found.1 > 30.0, "{hangs_at}: {found:?}");
        }
    }

    #[test]
    fn a_pendulum_that_the_command_hardly_moves_is_found_by_its_swing() {
        let stiffness = 6.0;
        let swings = flight_with(3, |_, _, angle| -stiffness * angle.sin());
        asked(&swings, |problem, plain| {
            let fit = about_zero(problem, plain, |_| true).remove(0);
            let value = fit.minimum.values[fit.range_of(problem, "gravity_stiffness").unwrap()][0];
            assert!((value / stiffness - 1.0).abs() < 0.1, "{value}");
            assert!(plain.criterion() - fit.criterion() > 30.0);
            assert!(about_zero(problem, &fit, |_| true).is_empty(), "it has one");
        });
        let free = flight_with(3, |_, _, _| 0.0);
        asked(&free, |problem, plain| {
            assert!(about_zero(problem, plain, |_| true).is_empty(), "it does not swing");
        });
    }

    #[test]
    fn a_spring_may_be_as_stiff_as_the_motion_is_quick_however_weak_the_command() {
        let swings = flight_with(3, |_, _, angle| -6.0 * angle.sin());
        let sizes = |gain: f64| {
            asked(&swings, |problem, _| {
                let plant = &problem.baseline.plant;
                problem.data.amplitudes(plant.inertia, gain * plant.dm_du)
            })
        };
        let (strong, weak) = (sizes(1.0), sizes(1e-3));
        assert!(weak.moment < 2e-3 * strong.moment && weak.moves == strong.moves);
        assert_eq!((strong.acting(), weak.acting()), (strong.moment.max(strong.moves), weak.moves));
        let most = |sizes| GravityStiffness.parameters(&sizes)[0].upper;
        assert!(most(strong) > 6.0 && most(weak) > 6.0);
    }
}
