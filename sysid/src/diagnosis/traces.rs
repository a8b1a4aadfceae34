//! Measured against simulated, each section by the models that were fitted without it, as a report draws them.

use super::rotation::{HeldOut, Rotation};
use crate::dataset::Place;
use crate::likelihood::free_run::{judged, judged_channel, simulate, starting_points};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;

/// Measured against simulated, one section.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Section.
    pub label: String,
    /// Time, s.
    pub t: Vec<f64>,
    /// Measured pitch rate in rad/s (or angle in rad where no rate was measured).
    pub measured: Vec<f64>,
    /// Free run of the baseline.
    pub baseline: Vec<f64>,
    /// Free run of the extended model.
    pub extended: Vec<f64>,
    /// Unit of what is shown.
    pub unit: &'static str,
}

/// Free runs over each place of each part that was held out, by the models that were fitted without it.
pub fn traces(problem: &Problem<'_>, baseline: &[&'static dyn Effect], rotation: &Rotation) -> Vec<Trace> {
    let free_run = |effects: &[&'static dyn Effect], values: &[f64], places: &[Place]| -> Vec<Vec<f64>> {
        let unpacked = problem.unpack(effects, values);
        let simulated = starting_points(problem, &unpacked, places)
            .and_then(|points| simulate(problem, &unpacked, places, &points));
        simulated.map_or_else(
            || vec![Vec::new(); places.len()],
            |s| s.iter().map(|s| judged_channel(problem, s)).collect(),
        )
    };
    let unit = if problem.data.has_rate { "rad/s" } else { "rad" };
    let of_part = |part: &HeldOut| -> Vec<Trace> {
        let before = free_run(baseline, &part.baseline_values, &part.places);
        let after = free_run(&part.model.0, &part.model.1, &part.places);
        let with_runs = part.places.iter().zip(before).zip(after);
        with_runs
            .map(|((place, baseline), extended)| Trace {
                label: part.label.clone(),
                t: place.rows.clone().map(|k| problem.data.runs[place.run].time(k)).collect(),
                measured: judged(problem, place).to_vec(),
                baseline,
                extended,
                unit,
            })
            .collect()
    };
    rotation.parts.iter().flat_map(of_part).collect()
}
