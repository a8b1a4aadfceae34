//! Significant is not material: how much of the motion a model closes, and whether a name is worth telling.

use super::levels::{HALVED, HORIZONS_S, LAST_THOUSANDTH};
use super::posterior::Selection;
use crate::dataset::Place;
use crate::likelihood::fit::Fit;
use crate::likelihood::horizon::horizon_vaf;
use crate::likelihood::problem::Problem;
use crate::model::effect::{Effect, Locus};

/// VAF of predictions at the longest horizon by the model at `place`, per cent; `None` where no such prediction is finite.
pub fn vaf_ahead(
    problem: &Problem<'_>,
    selection: &Selection,
    place: usize,
    sections: &[Place],
) -> Option<f64> {
    let Fit { effects, minimum } = &selection.visited[place].fit;
    let unpacked = problem.unpack(effects, &minimum.values);
    horizon_vaf(problem, &unpacked, sections, &HORIZONS_S)?.last().map(|(vaf, _)| *vaf)
}

/// Share of what a VAF of `before`, per cent, leaves of the motion, the noise included, that one of `after` closes; 0 where either
/// is none.
pub fn closed(before: Option<f64>, after: Option<f64>) -> f64 {
    match (before, after) {
        (Some(before), Some(after)) if before < 100.0 => ((after - before) / (100.0 - before)).max(0.0),
        _ => 0.0,
    }
}

/// Whether a further name is not material: all of the model closes `all` of the motion that the baseline leaves, and `rest` without
/// the name. What halves the error is material, however small that is.
pub fn is_immaterial(effect: &dyn Effect, all: f64, rest: f64) -> bool {
    // what a sensor adds moves nothing, and is true all the same
    let moves = effect.about().locus != Locus::Sensor;
    let small = rest > 1.0 - LAST_THOUSANDTH || moves && all - rest < LAST_THOUSANDTH;
    small && 1.0 - all > HALVED * (1.0 - rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::find;

    #[test]
    fn a_name_that_moves_the_prediction_by_less_than_a_thousandth_is_not_material() {
        let [friction, lag] = ["coulomb_friction", "gyro_lag"].map(|id| find(id).unwrap());
        assert!(is_immaterial(friction, 0.9, 0.8995) && !is_immaterial(friction, 0.9, 0.89));
        assert!(!is_immaterial(lag, 0.9, 0.8995) && is_immaterial(lag, 0.9997, 0.9995));
        assert!(!is_immaterial(friction, 0.9999, 0.9995), "a fifth of the error is left");
        assert_eq!((closed(Some(90.0), Some(97.5)), closed(Some(90.0), Some(80.0))), (0.75, 0.0));
        assert_eq!((closed(None, Some(97.5)), closed(Some(100.0), Some(100.0))), (0.0, 0.0));
    }
}
