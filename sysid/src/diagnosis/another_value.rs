//! Whether two fits say another thing of one vehicle: of its gain, of a name's size, of a sign.

use super::levels::{ANOTHER_GAIN, HELD_OUT_ERRORS};
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;

/// Whether ∂M/∂u of `other` is another one than that of `fit`.
pub fn is_another_gain(problem: &Problem<'_>, fit: &Fit, other: &Fit) -> bool {
    let gain = |fit: &Fit| problem.unpack(&fit.effects, &fit.minimum.values).plant.dm_du;
    let factor = gain(other) / gain(fit);
    !(1.0 / ANOTHER_GAIN..ANOTHER_GAIN).contains(&factor)
}

/// Whether the first unknown of `effect`, mostly its size, is surely another one in `other` than in `fit`.
pub fn is_another_size(
    problem: &Problem<'_>,
    (fit, information): (&Fit, &Information),
    other: &Fit,
    effect: &dyn Effect,
) -> bool {
    let place = |fit: &Fit| fit.range_of(problem, effect.about().id).map(|own| own.start);
    let (Some(own), Some(of_other)) = (place(fit), place(other)) else { return false };
    let [value, other] = [fit.minimum.values[own], other.minimum.values[of_other]];
    let error = information.deviations(&fit.minimum.values)[own];
    let beyond = value != 0.0 && !(1.0 / ANOTHER_GAIN..ANOTHER_GAIN).contains(&(other / value));
    beyond && (other - value).abs() > HELD_OUT_ERRORS * error && effect.acts_at() != Some(0)
}

/// Whether an unknown of `effect` that may have either sign has the other one in `alone`, where the rest is left out: one of the
/// two makes good for the other, and the data do not say which.
pub fn turns_about(problem: &Problem<'_>, fit: &Fit, alone: &Fit, effect: &dyn Effect) -> bool {
    let id = effect.about().id;
    let (Some(own), Some(other)) = (fit.range_of(problem, id), alone.range_of(problem, id)) else {
        return false;
    };
    let coordinates = problem.coordinates(&fit.effects);
    own.zip(other).enumerate().any(|(place, (i, j))| {
        let [low, high] = coordinates[i].bounds;
        low < 0.0
            && high > 0.0
            && effect.acts_at() != Some(place)
            && fit.minimum.values[i] * alone.minimum.values[j] < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{asked, effects, extended, flight_with, selection};
    use super::*;

    #[test]
    fn the_first_name_is_of_another_size_beyond_a_fifth() {
        asked(&flight_with(1, |_, _, angle| -1.5 * angle.sin()), |problem, baseline| {
            let models = selection(problem, baseline, &[], &[effects(&["gravity_stiffness"])]);
            let (fit, information) = (&models.visited[1].fit, &models.visited[1].information);
            let times = |factor: f64| {
                let mut other = fit.clone();
                let place = fit.range_of(problem, "gravity_stiffness").unwrap().start;
                other.minimum.values[place] *= factor;
                is_another_size(problem, (fit, information), &other, fit.effects[0])
            };
            assert_eq!([0.6, 0.9, 1.1, 1.5, -1.0].map(times), [true, false, false, true, true]);
            assert!(
                !is_another_size(problem, (fit, information), baseline, fit.effects[0]),
                "it is not there"
            );
        });
    }

    #[test]
    fn a_gain_is_another_one_a_fifth_away_or_with_the_other_sign() {
        asked(&flight_with(1, |_, _, _| 0.0), |problem, fit| {
            let other = |factor: f64| {
                let mut other = fit.clone();
                other.minimum.values[1] *= factor;
                is_another_gain(problem, fit, &other)
            };
            assert_eq!([0.82, 0.85, 1.15, 1.25, -1.0].map(other), [true, false, false, true, true]);
        });
    }

    #[test]
    fn a_name_turns_about_where_its_sign_may_be_either_and_is_the_other_one_alone() {
        let place = |problem: &Problem<'_>, fit: &Fit, id: &str| fit.range_of(problem, id).unwrap().start;
        asked(&flight_with(1, |_, _, theta| -theta.sin()), |problem, baseline| {
            let all = effects(&["trim_offset", "servo_lag", "quadratic_drag", "coulomb_friction"]);
            let [moment, lag, drag, friction] = [0, 1, 2, 3].map(|i| &all[i]);
            let mut fit = extended(problem, baseline, &[*moment, *lag, *drag]);
            let mut alone = extended(problem, baseline, &[*drag, *lag, *moment]);
            let mut turns = |id: &str, values: [f64; 2], effect: &dyn Effect| {
                let (own, other) = (place(problem, &fit, id), place(problem, &alone, id));
                (fit.minimum.values[own], alone.minimum.values[other]) = (values[0], values[1]);
                turns_about(problem, &fit, &alone, effect)
            };
            assert!(
                turns("trim_offset", [0.1, -0.05], *moment) && turns("trim_offset", [-0.1, 0.05], *moment)
            );
            assert!(
                !turns("trim_offset", [0.1, 0.05], *moment) && !turns("trim_offset", [-0.1, -0.05], *moment)
            );
            assert!(!turns("trim_offset", [0.1, 0.0], *moment), "none is no other sign");
            assert!(!turns("trim_offset", [-0.1, 0.0], *moment), "nor of what pulls the other way");
            assert!(!turns("servo_lag", [0.1, -0.1], *lag), "a time constant has one sign");
            assert!(!turns("quadratic_drag", [0.1, -0.1], *drag), "a drag begins at none");
            assert!(!turns("trim_offset", [0.1, -0.05], *friction), "what neither has");
        });
    }
}
