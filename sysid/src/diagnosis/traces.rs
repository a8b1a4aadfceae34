//! Measured against simulated, each section by the models that were fitted without it, as a report draws them.

use super::rotation::{HeldOut, Rotation};
use crate::dataset::Place;
use crate::likelihood::free_run::{judged_channel, simulate, starting_points};
use crate::likelihood::problem::Problem;
use crate::model::effect::Effect;
use crate::model::pitch::Output;

/// Measured against simulated, one section.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Section.
    pub label: String,
    /// Index of the recording.
    pub recording: usize,
    /// Time, s.
    pub t: Vec<f64>,
    /// Input, in its unit.
    pub input: Vec<f64>,
    /// Measured pitch rate in rad/s (or angle in rad where no rate was measured).
    pub measured: Vec<f64>,
    /// Free run of the baseline.
    pub baseline: Vec<f64>,
    /// Free run of the extended model.
    pub extended: Vec<f64>,
    /// Unit of what is shown.
    pub unit: &'static str,
    /// The angle, where both were measured.
    pub angle: Option<Angle>,
}

/// Pitch angle of a section, rad.
#[derive(Clone, Debug)]
pub struct Angle {
    /// Measured.
    pub measured: Vec<f64>,
    /// Free run of the baseline; empty where it diverges.
    pub baseline: Vec<f64>,
    /// Free run of the extended model; empty where it diverges.
    pub extended: Vec<f64>,
}

/// Free runs over each place of each part that was held out, by the models that were fitted without it.
pub fn traces(problem: &Problem<'_>, baseline: &[&'static dyn Effect], rotation: &Rotation) -> Vec<Trace> {
    let free_run = |effects: &[&'static dyn Effect], values: &[f64], places: &[Place]| -> Vec<Vec<Output>> {
        let unpacked = problem.unpack(effects, values);
        let simulated = starting_points(problem, &unpacked, places)
            .and_then(|points| simulate(problem, &unpacked, places, &points));
        simulated.unwrap_or_else(|| vec![Vec::new(); places.len()])
    };
    let unit = if problem.data.has_rate { "rad/s" } else { "rad" };
    let angles = |simulated: &[Output]| simulated.iter().map(|y| y[1]).collect();
    let of_part = |part: &HeldOut| -> Vec<Trace> {
        let before = free_run(baseline, &part.baseline_values, &part.places);
        let after = free_run(&part.model.0, &part.model.1, &part.places);
        let with_runs = part.places.iter().zip(before).zip(after);
        with_runs
            .map(|((place, baseline), extended)| {
                let run = &problem.data.runs[place.run];
                let measured_angle = run.angle.as_ref().filter(|_| problem.data.has_rate);
                Trace {
                    label: part.label.clone(),
                    recording: run.recording,
                    t: place.rows.clone().map(|k| run.time(k)).collect(),
                    input: run.u[place.rows.clone()].to_vec(),
                    measured: problem.data.judged(place).to_vec(),
                    angle: measured_angle.map(|angle| Angle {
                        measured: angle[place.rows.clone()].to_vec(),
                        baseline: angles(&baseline),
                        extended: angles(&extended),
                    }),
                    baseline: judged_channel(problem, &baseline),
                    extended: judged_channel(problem, &extended),
                    unit,
                }
            })
            .collect()
    };
    rotation.parts.iter().flat_map(of_part).collect()
}
