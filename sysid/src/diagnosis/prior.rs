//! What is believed of a model before the data are seen.
//!
//! ```text
//! prior(term) = ½ · ⅔ / named   or   ½ · ⅓ / shapes
//! ```
//!
//! A term that says no more than two others together, as friction with another value each way, is believed a tenth as readily as
//! they are: drives, sensors and weights have offsets on every rig. One that says all but the same as a single other, as a straight
//! spring over small angles, is believed a hundredth as readily: what hangs on a pivot has its weight, and few a spring. Beside
//! a spring that stiffens it is believed as readily: that one is straight before it stiffens. So it is where no body would be small
//! enough for the weight ([`log_prior_of_spring`]): a drive that holds a position pulls back as no weight does.
//!
//! What holds a craft aside is no further term: nine in ten such craft have it ([`super::another_zero`]).

use super::another_zero::{holder, log_prior_of_holder, pulls_aside};
use super::posterior::is_shape;
use super::selection::Candidates;
use crate::catalogue::gravity_stiffness::GravityStiffness;
use crate::catalogue::linear_stiffness::LinearStiffness;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use statrs::distribution::{ContinuousCDF, Normal};

/// Prior probability that a further term is missing: half for nothing.
pub const FURTHER_TERM: f64 = 0.5;
/// Prior share of the named terms among those that may be missing: two to one against the shapes without a name.
pub const NAMED: f64 = 2.0 / 3.0;
/// Prior odds of a term against others that say the same together.
const RESTATED: f64 = 0.1;
/// The same against a single one, that is more usual.
const UNUSUAL: f64 = 0.01;
/// Acceleration of gravity, m/s².
const G: f64 = 9.81;
/// The spring that stiffens.
const STIFFENS: &str = "cubic_stiffness";

/// ln of the prior odds of a model with the terms `effects`, where `candidates` can be asked for.
pub fn log_prior(problem: &Problem<'_>, effects: &[&'static dyn Effect], candidates: &Candidates) -> f64 {
    let (named, shapes) = (&candidates.named, candidates.shapes.len());
    let pulls = pulls_aside(problem, effects);
    let of = |effect: &&'static dyn Effect| {
        if effect.is_background() {
            return FURTHER_TERM.ln();
        }
        let share =
            if is_shape(*effect) { (1.0 - NAMED) / shapes as f64 } else { NAMED / named.len().max(1) as f64 };
        // A term that holds another as its special case says two things.
        let said = if named.iter().any(|simple| effect.generalises(*simple)) { 2.0 } else { 1.0 };
        let others = effect.restates();
        let askable = |id: &&str| named.iter().any(|other| other.about().id == *id);
        let restated = match others {
            [] => 1.0,
            _ if !others.iter().all(askable) => 1.0,
            [_] if effects.iter().any(|other| other.about().id == STIFFENS) => 1.0,
            [_] => UNUSUAL,
            _ => RESTATED,
        };
        said * (FURTHER_TERM * share).ln() + restated.ln()
    };
    let all = effects.iter().map(of).sum::<f64>();
    if !pulls {
        return all;
    }
    let held = holder(effects);
    all - held.iter().map(of).sum::<f64>() + log_prior_of_holder(effects)
}

/// Radius of gyration of the least that swings on a rig, m, the middle one, and the spread of its logarithm: a rod of 10 cm has 3 cm.
const RADIUS: [f64; 2] = [0.03, 0.7];

/// ln of the odds by which the straight spring in `fit` is believed more readily than [`log_prior`] has it, that it is none of a weight:
/// no more of the weights is that stiff than of bodies is as small, m g l/Iyy ≤ g/2r. Both are compared over the range of a weight.
/// 0 without a straight spring, and where that is believed as readily as others anyway.
pub fn log_prior_of_spring(problem: &Problem<'_>, fit: &Fit, candidates: &Candidates) -> f64 {
    let Some(own) = fit.range_of(problem, LinearStiffness.about().id) else { return 0.0 };
    let has = |id: &str, all: &[&'static dyn Effect]| all.iter().any(|effect| effect.about().id == id);
    if has(STIFFENS, &fit.effects) || !has(GravityStiffness.about().id, &candidates.named) {
        return 0.0;
    }
    let stiffness = fit.minimum.values[own.start].abs() / problem.baseline.plant.inertia;
    let largest = 0.5 * G / stiffness.max(f64::MIN_POSITIVE);
    let [middle, spread] = RADIUS;
    let smaller = Normal::standard().cdf((largest / middle).ln() / spread);
    let width = |effect: &dyn Effect| {
        effect.parameters(&problem.sizes).iter().map(|p| p.upper - p.lower).sum::<f64>()
    };
    let more = 1.0 / smaller.max(UNUSUAL);
    (more * width(&LinearStiffness) / width(&GravityStiffness)).ln()
}

#[cfg(test)]
mod tests {
    use super::super::data_checks::fixture::{GAIN, flight, flown, model};
    use super::super::fixture::{asked, effects, flown_by};
    use super::*;
    use crate::catalogue::shapes::SHAPES;
    use crate::catalogue::slow_moment::SlowMoment;
    use crate::diagnosis::diagnose;
    use crate::optim::levenberg_marquardt::Minimum;

    fn shapes() -> Vec<&'static dyn Effect> {
        SHAPES.iter().map(|&shape| shape as _).collect()
    }

    fn of(ids: &[&str], candidates: &Candidates) -> f64 {
        asked(&flight(1, 0.0), |problem, _| log_prior(problem, &effects(ids), candidates))
    }

    #[test]
    fn names_have_two_thirds_of_a_half_and_shapes_the_last_third() {
        let named = effects(&["coulomb_friction", "gravity_stiffness", "servo_lag", "quadratic_drag"]);
        let candidates = Candidates { named, shapes: shapes() };
        let name = (0.5_f64 * 2.0 / 3.0 / 4.0).ln();
        assert_eq!(of(&[], &candidates), 0.0);
        assert!((of(&["gravity_stiffness"], &candidates) - name).abs() < 1e-12);
        assert!((of(&["gravity_stiffness", "servo_lag"], &candidates) - 2.0 * name).abs() < 1e-12);
        let shape = asked(&flight(1, 0.0), |problem, _| log_prior(problem, &shapes()[..1], &candidates));
        assert!((shape - (0.5 / 3.0 / SHAPES.len() as f64).ln()).abs() < 1e-12, "{shape}");
        let background = asked(&flight(1, 0.0), |problem, _| log_prior(problem, &[&SlowMoment], &candidates));
        assert!((background - 0.5_f64.ln()).abs() < 1e-12, "the background");
        let alone = Candidates { named: Vec::new(), shapes: shapes() };
        assert!((of(&["gravity_stiffness"], &alone) - (1.0_f64 / 3.0).ln()).abs() < 1e-12);
    }

    #[test]
    fn a_term_that_holds_another_as_its_special_case_says_two_things() {
        let named = effects(&["coulomb_friction", "stribeck_friction"]);
        let candidates = Candidates { named, shapes: shapes() };
        let one = (0.5_f64 * 2.0 / 3.0 / 2.0).ln();
        assert!((of(&["coulomb_friction"], &candidates) - one).abs() < 1e-12);
        assert!((of(&["stribeck_friction"], &candidates) - 2.0 * one).abs() < 1e-12);
    }

    #[test]
    fn a_term_that_restates_two_others_is_believed_a_tenth_as_readily() {
        let all = Candidates {
            named: effects(&["coulomb_friction", "trim_offset", "asymmetric_friction"]),
            shapes: shapes(),
        };
        let two = of(&["coulomb_friction", "trim_offset"], &all);
        assert!((of(&["asymmetric_friction"], &all) - two - 0.1_f64.ln()).abs() < 1e-12);
        let alone =
            Candidates { named: effects(&["coulomb_friction", "asymmetric_friction"]), shapes: shapes() };
        let one = (0.5_f64 * 2.0 / 3.0 / 2.0).ln();
        assert!((of(&["asymmetric_friction"], &alone) - 2.0 * one).abs() < 1e-12);
    }

    #[test]
    fn a_straight_spring_is_believed_less_readily_than_the_weight_it_may_be() {
        let both =
            Candidates { named: effects(&["gravity_stiffness", "linear_stiffness"]), shapes: shapes() };
        let weight = of(&["gravity_stiffness"], &both);
        assert!((of(&["linear_stiffness"], &both) - weight - 0.01_f64.ln()).abs() < 1e-12);
        let beside = |id| of(&[id, "cubic_stiffness"], &both);
        assert!((beside("linear_stiffness") - beside("gravity_stiffness")).abs() < 1e-12);
        let alone = Candidates { named: effects(&["linear_stiffness"]), shapes: shapes() };
        assert!((of(&["linear_stiffness"], &alone) - (1.0_f64 / 3.0).ln()).abs() < 1e-12);
    }

    #[test]
    fn a_spring_is_believed_as_no_body_is_small_enough_for_the_weight() {
        let of = |ids: &[&str], stiffness: f64, named: &[&str]| {
            asked(&flight(1, 0.0), |problem, fit| {
                let own = vec![stiffness * problem.baseline.plant.inertia; ids.len()];
                let values = [fit.minimum.values.clone(), own].concat();
                let fit = Fit { effects: effects(ids), minimum: Minimum { values, ..fit.minimum.clone() } };
                let candidates = Candidates { named: effects(named), shapes: Vec::new() };
                log_prior_of_spring(problem, &fit, &candidates)
            })
        };
        let both = ["gravity_stiffness", "linear_stiffness"];
        let spring = |stiffness| of(&["linear_stiffness"], stiffness, &both);
        let soft = spring(1e-9);
        assert!(soft >= 0.0, "over the narrower range of a weight: {soft}");
        // g/2r is 163.5 1/s² at 3 cm, the middle of them
        assert!((spring(163.5) - soft - 2.0_f64.ln()).abs() < 1e-6);
        assert_eq!(spring(-163.5), spring(163.5));
        assert!((spring(1e4) - soft - 100.0_f64.ln()).abs() < 1e-6, "as readily, and no more");
        assert_eq!(of(&["gravity_stiffness"], 400.0, &both), 0.0);
        assert_eq!(of(&["linear_stiffness", "cubic_stiffness"], 400.0, &both), 0.0);
        assert_eq!(of(&["linear_stiffness"], 400.0, &["linear_stiffness"]), 0.0);
    }

    #[test]
    fn a_drive_that_holds_a_position_is_a_spring_and_a_pendulum_a_weight() {
        let inertia = model(GAIN, 0.06).plant.inertia_kg_m2;
        let named = |stiffness: f64, damping: f64| {
            let u = flight(1, 0.0).u.iter().map(|u| 10.0 * u).collect();
            let pulled =
                |_: usize, rate: f64, angle: f64| -inertia * (stiffness * angle.sin() + damping * rate);
            let flown = flown_by(1, u, pulled);
            let answer = diagnose(&[flown.recording()], None, &|_| {}).unwrap().answer;
            let first = answer.effects.first().map(|effect| (effect.id.clone(), effect.parameters[0].value));
            first.unwrap_or_default()
        };
        for (name, stiffness, damping) in
            [("linear_stiffness", 400.0, 36.0), ("gravity_stiffness", 40.0, 4.0)]
        {
            let (found, value) = named(stiffness, damping);
            // the fixture's steps of 20 ms are coarse for the drive
            assert!(found == name && (0.5..2.0).contains(&(value / stiffness)), "{found} {value}");
        }
    }

    #[test]
    fn what_holds_a_craft_aside_costs_less_than_its_absence() {
        let candidates =
            Candidates { named: effects(&["gravity_stiffness", "trim_offset"]), shapes: Vec::new() };
        let mut aside = flown(1, 0.0, [0.0, 1.0]);
        aside.theta.iter_mut().for_each(|theta| *theta += 3.0);
        let [held, zeroed, hanging, both] = asked(&aside, |problem, _| {
            let also = [&["trim_offset"][..], &["rest_angle"], &[], &["rest_angle", "trim_offset"]];
            also.map(|ids| log_prior(problem, &effects(&[&["gravity_stiffness"], ids].concat()), &candidates))
        });
        let name = (0.5_f64 * 2.0 / 3.0 / 2.0).ln();
        assert!((held - name - 0.8_f64.ln()).abs() < 1e-12, "{held}");
        assert!((zeroed - name - 0.1_f64.ln()).abs() < 1e-12, "{zeroed}");
        assert!((both - 2.0 * name - 0.8_f64.ln()).abs() < 1e-12, "the second is a further term: {both}");
        assert!((hanging - name - 0.1_f64.ln()).abs() < 1e-12, "{hanging}");
    }
}
