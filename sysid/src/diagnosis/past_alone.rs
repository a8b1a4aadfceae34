//! Predictions from the outputs' past alone: what a model that knows the input has to beat.
//!
//! ```text
//! ŷ(t + h) = c + Σ_i a_i y(t − τ_i) + Σ_i b_i y'(t − τ_i),      τ_i = 0, Ts, 2 Ts, 3 Ts, 0.04 s .. 0.48 s
//! ```
//!
//! by least squares, y the channel that models are judged by and y' the other where both are measured. What a controller will do
//! follows from the past of the motion, and is in ŷ; what a model predicts beyond it is the input's own doing (Granger,
//! Econometrica 37, 1969).

use crate::dataset::Place;
use crate::likelihood::problem::Problem;
use crate::linalg::least_squares::least_squares;
use nalgebra::DVector;

/// Rows between two lags, beyond the first few of them, s, and their number.
const APART_S: f64 = 0.04;
const FAR_LAGS: usize = 12;
/// Lags of neighbouring rows.
const NEAR_LAGS: usize = 3;
/// Rows for each regressor with fewer than which there are no far lags.
const FEWEST_PER_COLUMN: usize = 3;
/// Predictions start this far apart, s.
const STRIDE_S: f64 = 0.02;

/// VAF over `judged_on`, per cent and at least 0, of predictions `horizon` s ahead that were fitted on `fitted_on`; 0 where these
/// are too short.
pub fn vaf_of_the_past_alone(
    problem: &Problem<'_>,
    fitted_on: &[Place],
    judged_on: &[Place],
    horizon: f64,
) -> f64 {
    let of = |places, far| all_pairs(problem, places, horizon, far);
    let with = |far: usize| {
        let columns = of(fitted_on, far).next()?.0.len();
        let enough =
            of(fitted_on, far).take(FEWEST_PER_COLUMN * columns).count() == FEWEST_PER_COLUMN * columns;
        Some((far, least_squares(columns, of(fitted_on, far)).filter(|_| enough)?))
    };
    let Some((far, weights)) = with(FAR_LAGS).or_else(|| with(0)) else { return 0.0 };
    let judged = of(judged_on, far);
    let asked: Vec<[f64; 2]> = judged.map(|(x, y)| [y, y - weights.dot(&x)]).collect();
    let mean = asked.iter().map(|[y, _]| y).sum::<f64>() / asked.len().max(1) as f64;
    let left: f64 = asked.iter().map(|[_, error]| error * error).sum();
    let total: f64 = asked.iter().map(|[y, _]| (y - mean).powi(2)).sum();
    if total > 0.0 { 100.0 * (1.0 - left / total).max(0.0) } else { 0.0 }
}

/// [`pairs`] of all `places`.
fn all_pairs(
    problem: &Problem<'_>,
    places: &[Place],
    horizon: f64,
    far: usize,
) -> impl Iterator<Item = (DVector<f64>, f64)> {
    places.iter().flat_map(move |place| pairs(problem, place, horizon, far))
}

/// Regressors with so many `far` lags and what they predict, all over `place`, from one reading to another.
fn pairs<'d, 'p>(
    problem: &'d Problem<'p>,
    place: &Place,
    horizon: f64,
    far: usize,
) -> impl Iterator<Item = (DVector<f64>, f64)> + use<'d, 'p> {
    let run = &problem.data.runs[place.run];
    let rows = |seconds: f64| (seconds / run.step).round().max(1.0) as usize;
    let every = run.measured_every();
    let (ahead, apart, stride) = (rows(horizon), rows(APART_S).max(every), rows(STRIDE_S));
    let near = (0..=NEAR_LAGS).map(|i| i * every);
    let lags: Vec<usize> = near.chain((1..=far).map(|i| i * apart)).collect();
    let y = problem.data.judged(place);
    let other = run.rate.as_ref().and(run.angle.as_ref()).map(|angle| &angle[place.rows.clone()]);
    let first = (NEAR_LAGS * every).max(far * apart);
    let from = place.rows.start;
    let rows = (first..y.len().saturating_sub(ahead)).step_by(if every > 1 { 1 } else { stride });
    let last = y.len();
    rows.filter_map(move |k| {
        // from one reading to the next one after the horizon
        let then = (k + ahead..last).find(|then| run.is_measured(from + then))?;
        let of = |signal: &'d [f64]| lags.iter().map(move |lag| signal[k - lag]).collect::<Vec<f64>>();
        let known = [vec![1.0], of(y), other.map_or_else(Vec::new, of)].concat();
        run.is_measured(from + k).then(|| (DVector::from_vec(known), y[then]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::flight;
    use crate::diagnosis::fixture::{asked, quarters};
    use crate::likelihood::horizon::horizon_vaf;

    /// VAF 0.1 and 1 s ahead of the model and of the past alone, per cent.
    fn both() -> [[f64; 2]; 2] {
        asked(&flight(1, 0.0), |problem, fit| {
            let parts = quarters(problem);
            let (fitted, held): (Vec<Place>, Vec<Place>) =
                (parts[..3].iter().flat_map(|p| p.places.clone()).collect(), parts[3].places.clone());
            let unpacked = problem.unpack(&fit.effects, &fit.minimum.values);
            let horizons = [0.1, 1.0];
            let model = horizon_vaf(problem, &unpacked, &held, &horizons).unwrap();
            let past = horizons.map(|h| vaf_of_the_past_alone(problem, &fitted, &held, h));
            [[0, 1].map(|i| model[i].unwrap().0), past]
        })
    }

    #[test]
    fn an_excitation_is_not_known_from_the_past_however_smooth_the_motion() {
        let [model, past] = both();
        assert!((80.0..95.0).contains(&past[0]) && model[0] > 97.0, "{model:?} {past:?}");
        assert!(past[1] < 10.0 && model[1] > 60.0, "{model:?} {past:?}");
    }

    #[test]
    fn data_that_are_too_short_say_nothing() {
        asked(&flight(1, 0.0), |problem, _| {
            let place = quarters(problem).remove(0).places.remove(0);
            let short = Place { rows: 0..20, ..place };
            let (short, all) = ([short], problem.data.places());
            assert_eq!(vaf_of_the_past_alone(problem, &short, &short, 0.1), 0.0);
            assert_eq!(vaf_of_the_past_alone(problem, &short, &all, 0.1), 0.0);
            assert_eq!(vaf_of_the_past_alone(problem, &[], &all, 0.1), 0.0);
        });
    }
}
