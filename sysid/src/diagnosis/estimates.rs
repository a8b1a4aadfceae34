//! The unknowns of a fit with their 95 % intervals.

use super::change_point;
use crate::estimate::Estimate;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::Problem;

/// All unknowns of `fit`, in their order; the intervals from the blocks' scores where these are more uneven than the
/// information says. A parameter that is no unknown may be anything in its range. A moment in time is by the clock of the file.
pub fn estimates(problem: &Problem<'_>, fit: &Fit, information: Option<&Information>) -> Vec<Estimate> {
    let coordinates = problem.coordinates(&fit.effects);
    let values = &fit.minimum.values;
    let unknown = vec![f64::INFINITY; values.len()];
    let deviations = information.map_or(unknown, |information| information.deviations(values));
    let with_deviation = coordinates.iter().zip(values).zip(deviations);
    let mut all: Vec<Estimate> = with_deviation
        .map(|((c, &value), deviation)| Estimate::new(&c.name, &c.unit, value, deviation, c.bounds))
        .collect();
    for (i, effect) in fit.effects.iter().enumerate() {
        let own = fit.own_range(problem, i);
        let first = own.start;
        let origin = problem.data.origin();
        let beyond = effect.beyond_data(&values[own.clone()], &problem.sizes);
        if let Some(beyond) = beyond {
            all[first + beyond].ci95 = coordinates[first + beyond].bounds;
        }
        for moment in effect.moments() {
            let Estimate { value, ci95, .. } = &mut all[first + moment];
            if Some(moment) != beyond {
                let divisor = information.map_or(1.0, |information| information.divisor(own.clone()));
                *ci95 = change_point::interval(problem, fit, first + moment, divisor);
            }
            *value += origin;
            *ci95 = ci95.map(|end| end + origin);
        }
        if let Some(angle) = effect.turns() {
            let Estimate { value, ci95, .. } = &mut all[first + angle];
            let turns = (*value / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            *value -= turns;
            *ci95 = ci95.map(|end| end - turns);
        }
    }
    all
}

/// The intervals of `all`, those of `fit`, stretched to hold them about the values of `alone`, a fit with some of its terms: what the
/// others are told as, a curve or a further name, takes a share of these that no spread of the data shows.
pub fn reach(problem: &Problem<'_>, all: &mut [Estimate], fit: &Fit, alone: &Fit) {
    let coordinates = problem.coordinates(&fit.effects);
    let shared = problem.noise_range().end;
    let of_terms = alone.effects.iter().enumerate().flat_map(|(i, effect)| {
        let own = fit.position(effect.about().id).map(|place| fit.own_range(problem, place));
        own.into_iter().flatten().zip(alone.own_range(problem, i))
    });
    for (i, other) in (0..shared).map(|i| (i, i)).chain(of_terms) {
        let (own, by) = (fit.minimum.values[i], alone.minimum.values[other] - fit.minimum.values[i]);
        let Estimate { value, ci95: [low, high], .. } = &mut all[i];
        // A moment in time is told by the clock of the file.
        let bounds = coordinates[i].bounds.map(|bound| bound + (*value - own));
        (*low, *high) = (low.min((*low + by).max(bounds[0])), high.max((*high + by).min(bounds[1])));
    }
}

/// The same for a fit of which nothing else is known.
pub fn estimates_of(problem: &Problem<'_>, fit: &Fit) -> Vec<Estimate> {
    estimates(problem, fit, Information::new(problem, fit, &[]).as_ref())
}
