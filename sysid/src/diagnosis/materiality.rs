//! Significant is not material: how much of the motion a model closes, and whether a name is worth telling.

use super::levels::{
    HALVED, HELD_OUT_ERRORS, HORIZONS_S, LAST_THOUSANDTH, LONGEST_HORIZON_S, MATERIAL, SEEN_AT_ALL,
};
use crate::dataset::Place;
use crate::likelihood::fit::Fit;
use crate::likelihood::horizon::{Vaf, horizon_vaf};
use crate::likelihood::problem::Problem;
use crate::model::effect::{Effect, Locus};

/// VAF of predictions `horizon` s ahead by a fitted model, per cent; `None` where no such prediction is finite.
pub fn vaf_ahead(
    problem: &Problem<'_>,
    Fit { effects, minimum }: &Fit,
    sections: &[Place],
    horizon: f64,
) -> Option<f64> {
    let unpacked = problem.unpack(effects, &minimum.values);
    horizon_vaf(problem, &unpacked, sections, &[horizon])?.pop().flatten().map(|(vaf, _)| vaf)
}

/// The horizon at which models are compared, s: the longest at which `fullest` tells anything of the motion. In a loop and in gusts
/// nothing tells a second ahead, with any term or without it.
pub fn telling_horizon(problem: &Problem<'_>, fullest: &Fit, sections: &[Place]) -> f64 {
    let unpacked = problem.unpack(&fullest.effects, &fullest.minimum.values);
    let all = horizon_vaf(problem, &unpacked, sections, &HORIZONS_S).unwrap_or_default();
    let tells = |vaf: &Option<Vaf>| vaf.is_some_and(|(vaf, _)| vaf >= SEEN_AT_ALL);
    all.iter().rposition(tells).map_or(LONGEST_HORIZON_S, |i| HORIZONS_S[i])
}

/// Share of what a VAF of `before`, per cent, leaves of the motion, the noise included, that one of `after` closes; 0 where either
/// is none.
pub fn closed(before: Option<f64>, after: Option<f64>) -> f64 {
    match (before, after) {
        (Some(before), Some(after)) if before < 100.0 => ((after - before) / (100.0 - before)).max(0.0),
        _ => 0.0,
    }
}

/// Share of what the past of the motion does not tell that a model predicts, `by_part` (its share of the motion; VAF of the past
/// alone, of the model, and its standard error, per cent): as much as it is but for one chance in a hundred.
pub fn beyond_the_past(by_part: impl Iterator<Item = (f64, [f64; 3])>) -> f64 {
    let parts: Vec<(f64, [f64; 3])> = by_part.collect();
    let all = parts.iter().map(|(share, _)| share).sum::<f64>().max(f64::MIN_POSITIVE);
    let [past, model] = [0, 1].map(|i| parts.iter().map(|(share, part)| share * part[i]).sum::<f64>() / all);
    let error = parts.iter().map(|(share, part)| (share * part[2]).powi(2)).sum::<f64>().sqrt() / all;
    closed(Some(past), Some(model - HELD_OUT_ERRORS * error))
}

/// Whether a further name is not material: all of the model closes `all` of the motion that the baseline leaves, and `rest` without
/// the name. What halves the error is material, however small that is.
pub fn is_immaterial(effect: &dyn Effect, all: f64, rest: f64) -> bool {
    // what a sensor adds moves nothing, and is true all the same
    let moves = effect.about().locus != Locus::Sensor;
    let small = rest > 1.0 - LAST_THOUSANDTH || moves && all - rest < LAST_THOUSANDTH;
    small && 1.0 - all > HALVED * (1.0 - rest)
}

/// Whether a name that closes `all` of the motion says no more than its special case, which closes `rest`: nearly all of it, and as
/// much. Where noise leaves most of the motion open, the evidence alone tells the two apart; and what says the same as several
/// others together is told beside these, by what each of them closes.
pub fn says_the_same(general: &dyn Effect, all: f64, rest: f64) -> bool {
    rest >= MATERIAL && is_immaterial(general, all, rest) && general.restates().is_empty()
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{asked, effects, flight_with, selection};
    use super::*;
    use crate::catalogue::find;

    #[test]
    fn a_model_is_judged_by_the_longest_horizon() {
        asked(&flight_with(1, |_, _, theta| -4.0 * theta.sin()), |problem, baseline| {
            let models = selection(problem, baseline, &[], &[effects(&["gravity_stiffness"])]);
            let places = problem.data.places();
            let Fit { effects, minimum } = &models.visited[1].fit;
            let all = horizon_vaf(problem, &problem.unpack(effects, &minimum.values), &places, &HORIZONS_S);
            let [before, after] = [0, 1]
                .map(|place| vaf_ahead(problem, &models.visited[place].fit, &places, LONGEST_HORIZON_S));
            assert_eq!(telling_horizon(problem, &models.visited[1].fit, &places), LONGEST_HORIZON_S);
            assert_eq!(after, all.unwrap().last().unwrap().map(|(vaf, _)| vaf));
            assert!(after > before.map(|vaf| vaf + 3.0), "{before:?} {after:?}");
        });
    }

    #[test]
    fn what_a_model_tells_beyond_the_past_is_what_it_surely_tells() {
        let halves = |parts: [[f64; 3]; 2]| beyond_the_past(parts.into_iter().map(|part| (0.5, part)));
        let sure = halves([[80.0, 96.0, 0.1], [60.0, 92.0, 0.1]]);
        assert!((sure - 0.8).abs() < 0.01, "{sure}");
        assert!(halves([[12.0, 63.0, 24.0], [19.0, 78.0, 7.0]]) < 0.35);
        let beside_a_quiet_part = [(0.965, [80.0, 96.0, 0.1]), (0.035, [2.0, 0.0, 35.0])];
        assert!(beyond_the_past(beside_a_quiet_part.into_iter()) > 0.5);
        assert_eq!(beyond_the_past([(1.0, [80.0, 70.0, 1.0])].into_iter()), 0.0);
        assert_eq!(beyond_the_past(std::iter::empty()), 0.0);
    }

    #[test]
    fn a_name_that_moves_the_prediction_by_less_than_a_thousandth_is_not_material() {
        let [friction, lag] = ["coulomb_friction", "gyro_lag"].map(|id| find(id).unwrap());
        assert!(is_immaterial(friction, 0.9, 0.8995) && !is_immaterial(friction, 0.9, 0.89));
        assert!(!is_immaterial(lag, 0.9, 0.8995) && is_immaterial(lag, 0.9997, 0.9995));
        assert!(!is_immaterial(friction, 0.9999, 0.9995), "a fifth of the error is left");
        assert_eq!((closed(Some(90.0), Some(97.5)), closed(Some(90.0), Some(80.0))), (0.75, 0.0));
        assert_eq!((closed(None, Some(97.5)), closed(Some(100.0), Some(100.0))), (0.0, 0.0));
    }

    #[test]
    fn a_special_case_says_the_same_where_it_closes_nearly_all() {
        let hysteresis = find("hysteresis").unwrap();
        assert!(says_the_same(hysteresis, 0.95, 0.95) && says_the_same(hysteresis, MATERIAL, MATERIAL));
        assert!(!says_the_same(hysteresis, 0.95, 0.94), "more is closed");
        assert!(!says_the_same(find("asymmetric_friction").unwrap(), 0.95, 0.95), "another moment beside it");
        assert!(!says_the_same(hysteresis, 0.0, 0.0) && !says_the_same(hysteresis, 0.5, 0.5), "noise");
    }

    #[test]
    fn a_name_at_a_limit_is_told() {
        let [friction, lag] = ["coulomb_friction", "gyro_lag"].map(|id| find(id).unwrap());
        assert!(!is_immaterial(friction, LAST_THOUSANDTH, 0.0), "a thousandth of the motion");
        let rest = 1.0 - LAST_THOUSANDTH;
        assert!(!is_immaterial(lag, rest + 1e-4, rest), "a thousandth is left without it");
        let of_error = f64::exp2(-11.0);
        assert!(!is_immaterial(friction, 1.0 - HALVED * of_error, 1.0 - of_error), "half of the error");
        assert!(is_immaterial(friction, 1.0 - 0.75 * of_error, 1.0 - of_error));
    }
}
