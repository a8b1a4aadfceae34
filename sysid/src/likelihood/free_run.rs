//! Free-run simulation of sections, and the refit that serves it.
//!
//! Each section starts from its own estimated state: the predictor's corrected state at the section's first sample.

use crate::dataset::Place;
use crate::likelihood::fit::Fit;
use crate::likelihood::problem::{Problem, Unpacked};
use crate::model::pitch::{Driven, Output, Point};
use crate::optim::levenberg_marquardt::{Coordinate, Effort, Minimum, Residuals, minimize};
use crate::validate::vaf::{vaf, variance};
use core::cell::OnceCell;

/// States of the predictor at the first sample of each of `places`.
pub fn starting_points(problem: &Problem<'_>, unpacked: &Unpacked, places: &[Place]) -> Option<Vec<Point>> {
    let mut points = vec![None; places.len()];
    let visit = |run: usize, k: usize, point: &Point| {
        for (place, slot) in places.iter().zip(points.iter_mut()) {
            if place.run == run && place.rows.start == k {
                *slot = Some(*point);
            }
        }
    };
    problem.track(unpacked, visit, &mut |_, _| {})?;
    points.into_iter().collect()
}

/// Simulates each of `places` from its starting point, without looking at the measurement.
pub fn simulate(
    problem: &Problem<'_>,
    unpacked: &Unpacked,
    places: &[Place],
    points: &[Point],
) -> Option<Vec<Vec<Output>>> {
    let models = problem.models(unpacked)?;
    let driven: Vec<OnceCell<Driven<'_, '_>>> = models.iter().map(|_| OnceCell::new()).collect();
    let free = |(place, point): (&Place, &Point)| {
        let under = || models[place.run].driven(&problem.data.runs[place.run]);
        driven[place.run].get_or_init(under).simulate(place.rows.clone(), *point)
    };
    places.iter().zip(points).map(free).collect()
}

/// The same channel of a simulation.
pub fn judged_channel(problem: &Problem<'_>, simulated: &[Output]) -> Vec<f64> {
    let channel = usize::from(!problem.data.has_rate);
    simulated.iter().map(|y| y[channel]).collect()
}

/// Free run of each of `places` from its own starting point, in the channel that it is judged by. `None` where it diverges.
pub fn free_run(problem: &Problem<'_>, unpacked: &Unpacked, places: &[Place]) -> Option<Vec<Vec<f64>>> {
    let points = starting_points(problem, unpacked, places)?;
    let simulated = simulate(problem, unpacked, places, &points)?;
    Some(simulated.iter().map(|s| judged_channel(problem, s)).collect())
}

/// Free-run VAF of each of `places`, per cent; zero where the simulation diverges.
pub fn vaf_by_place(problem: &Problem<'_>, unpacked: &Unpacked, places: &[Place]) -> Vec<f64> {
    let Some(simulated) = free_run(problem, unpacked, places) else { return vec![0.0; places.len()] };
    let measured = |place: &Place, values: &[f64]| problem.data.where_measured(place, values).into_owned();
    let of_place = |(place, s): (&Place, &Vec<f64>)| {
        vaf(&measured(place, problem.data.judged(place)), &measured(place, s))
    };
    places.iter().zip(&simulated).map(of_place).collect()
}

/// Free-run VAF over `places` together, errors and signals each about its mean in a place, per cent; zero where the
/// simulation diverges.
pub fn vaf_over(problem: &Problem<'_>, unpacked: &Unpacked, places: &[Place]) -> f64 {
    let Some(simulated) = free_run(problem, unpacked, places) else { return 0.0 };
    let mut left = 0.0;
    for (place, s) in places.iter().zip(&simulated) {
        let y = problem.data.judged(place);
        let errors: Vec<f64> = y.iter().zip(s).map(|(y, s)| y - s).collect();
        let errors = problem.data.where_measured(place, &errors);
        left += errors.len() as f64 * variance(&errors);
    }
    let whole = problem.data.motion(places);
    if whole > 0.0 { 100.0 * (1.0 - left / whole).max(0.0) } else { 0.0 }
}

/// Output-error maximum likelihood over `places`: the plant's and the effects' parameters that minimise the free-run
/// error about its mean, the noise model held at `fit`'s. Answers the minimum with its coordinates.
///
/// What the criterion cannot see (a sensor's offset) stays where `fit` has it.
pub fn refit_for_simulation(problem: &Problem<'_>, fit: &Fit, places: &[Place]) -> Option<Minimum> {
    const EFFORT: Effort = Effort { iterations: 15, tolerance: 0.05 };
    let values = &fit.minimum.values;
    let points = starting_points(problem, &problem.unpack(&fit.effects, values), places)?;
    let residuals = output_errors(problem, fit, places, &points);
    minimize(&*residuals, 1, &noise_held(problem, fit), values, EFFORT)
}

/// Free-run errors about their mean, section by section, as a function of the parameters.
pub fn output_errors<'p>(
    problem: &'p Problem<'_>,
    fit: &'p Fit,
    places: &'p [Place],
    points: &'p [Point],
) -> Box<Residuals<'p>> {
    Box::new(move |values: &[f64]| {
        let unpacked = problem.unpack(&fit.effects, values);
        let simulated = simulate(problem, &unpacked, places, points)?;
        let mut errors = Vec::new();
        for (place, s) in places.iter().zip(&simulated) {
            let measured = problem.data.judged(place);
            let channel = judged_channel(problem, s);
            let own: Vec<f64> = measured.iter().zip(&channel).map(|(y, s)| y - s).collect();
            let own = problem.data.where_measured(place, &own);
            let mean = own.iter().sum::<f64>() / own.len().max(1) as f64;
            errors.extend(own.iter().map(|error| [error - mean, 0.0]));
        }
        Some(errors)
    })
}

/// The coordinates of a fit with its noise model held.
pub fn noise_held(problem: &Problem<'_>, fit: &Fit) -> Vec<Coordinate> {
    let mut coordinates = problem.coordinates(&fit.effects);
    for i in problem.noise_range() {
        coordinates[i].bounds = [fit.minimum.values[i]; 2];
    }
    coordinates
}

#[cfg(test)]
mod tests;
