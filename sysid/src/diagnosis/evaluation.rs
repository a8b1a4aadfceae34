//! Before and after: what the extended model gains on the sections that were fitted on and on those held out.

use super::answer::ModelAnswer;
use super::change_point;
use crate::estimate::Estimate;
use crate::held_out::Split;
use crate::likelihood::fit::Fit;
use crate::likelihood::fit::weights;
use crate::likelihood::free_run::{
    judged, judged_channel, refit_for_simulation, simulate, starting_points, vaf_by_place,
};
use crate::likelihood::problem::Problem;
use crate::optim::levenberg_marquardt::covariance;
use std::collections::BTreeMap;

/// Residuals may be correlated over this time when intervals are corrected for it, s.
const CORRELATION_S: f64 = 0.5;

/// A model as it is judged: its likelihood values, the values that serve simulation, its VAF.
pub struct Judged {
    /// The fit by likelihood.
    pub fit: Fit,
    /// Values refitted for free-run simulation.
    pub simulation: Vec<f64>,
    /// Free-run VAF of all places, in the order of [`Split::all`], with the simulation values.
    pub vaf: Vec<f64>,
}

impl Judged {
    /// Refits for simulation on the training sections and keeps what simulates those better.
    pub fn new(problem: &Problem<'_>, split: &Split, fit: Fit) -> Self {
        let all = split.all();
        let vaf_of = |values: &[f64]| vaf_by_place(problem, &problem.unpack(&fit.effects, values), &all);
        let training_mean = |vaf: &[f64]| vaf[..split.training.len()].iter().sum::<f64>();
        let mut simulation = fit.minimum.values.clone();
        let mut vaf = vaf_of(&simulation);
        if let Some(refitted) = refit_for_simulation(problem, &fit, &split.training) {
            let better = vaf_of(&refitted.values);
            if training_mean(&better) > training_mean(&vaf) {
                simulation = refitted.values;
                vaf = better;
            }
        }
        Self { fit, simulation, vaf }
    }

    /// Mean VAF of the held-out sections.
    pub fn held_out_vaf(&self, split: &Split) -> f64 {
        let held = &self.vaf[split.training.len()..];
        held.iter().sum::<f64>() / held.len().max(1) as f64
    }

    /// Free-run VAF by section.
    pub fn vaf_by_section(&self, split: &Split) -> BTreeMap<String, f64> {
        split.all().iter().zip(&self.vaf).map(|(p, v)| (p.label.clone(), *v)).collect()
    }

    /// Name of the i-th unknown: an effect's parameter with the effect's id before it, for two effects may share a name.
    fn full_name(&self, problem: &Problem<'_>, i: usize) -> String {
        for (index, effect) in self.fit.effects.iter().enumerate() {
            let own = self.fit.own_range(problem, index);
            if own.contains(&i) {
                return format!(
                    "{}.{}",
                    effect.about().id,
                    effect.parameters(&problem.sizes)[i - own.start].name
                );
            }
        }
        problem.coordinates(&[])[i].name.clone()
    }

    /// The model's part of the answer.
    pub fn answer(&self, problem: &Problem<'_>, split: &Split) -> ModelAnswer {
        let coordinates = problem.coordinates(&self.fit.effects);
        let physical = |i: usize| !problem.noise_range().contains(&i);
        let estimates = estimates(problem, &self.fit);
        let of_physics = || (0..coordinates.len()).filter(|&i| physical(i));
        ModelAnswer {
            vaf_percent: self.vaf_by_section(split),
            parameters: of_physics().map(|i| estimates[i].clone()).collect(),
            simulation_parameters: of_physics()
                .map(|i| (self.full_name(problem, i), self.simulation[i]))
                .collect(),
        }
    }
}

/// All unknowns of a fit with their 95 % intervals (corrected for correlated residuals).
pub fn estimates(problem: &Problem<'_>, fit: &Fit) -> Vec<Estimate> {
    let coordinates = problem.coordinates(&fit.effects);
    let residuals = |values: &[f64]| problem.prediction_errors(&fit.effects, values);
    let lag = (CORRELATION_S / problem.sizes.step).ceil() as usize;
    let found = covariance(&residuals, problem.channels(), &coordinates, &fit.minimum.values, lag);
    let mut all: Vec<Estimate> = coordinates
        .iter()
        .zip(&fit.minimum.values)
        .enumerate()
        .map(|(i, (c, &value))| {
            let deviation = found.as_ref().map_or(f64::INFINITY, |cov| cov[(i, i)].max(0.0).sqrt());
            Estimate::new(&c.name, &c.unit, value, deviation, c.bounds)
        })
        .collect();
    for (i, effect) in fit.effects.iter().enumerate() {
        if let (Some(own), Some(ci95)) = (effect.begins_at(), change_point::interval(problem, fit, i)) {
            all[fit.own_range(problem, i).start + own].ci95 = ci95;
        }
    }
    all
}

/// 2 log likelihood of the one-step prediction that the extended model gains over the baseline on the held-out
/// sections. The innovations' covariance is each model's own there: how strong the disturbance is differs from section
/// to section.
pub fn held_out_gain(problem: &Problem<'_>, split: &Split, baseline: &Fit, extended: &Fit) -> f64 {
    let deviance = |fit: &Fit| -> f64 {
        let mut held = Vec::new();
        let tracked =
            problem.predict(&problem.unpack(&fit.effects, &fit.minimum.values), |run, innovations| {
                for place in split.held_out.iter().filter(|p| p.run == run) {
                    held.extend(innovations[place.rows.clone()].iter().map(|e| problem.pack(*e)));
                }
            });
        let (_, log_determinant) = weights(&held);
        if tracked.is_some() { held.len() as f64 * log_determinant } else { f64::INFINITY }
    };
    let (before, after) = (deviance(baseline), deviance(extended));
    if after.is_finite() { before - after } else { f64::NEG_INFINITY }
}

/// Measured against simulated, one section.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Section.
    pub label: String,
    /// Whether it was held out.
    pub held_out: bool,
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

/// Traces of all sections.
pub fn traces(problem: &Problem<'_>, split: &Split, baseline: &Judged, extended: &Judged) -> Vec<Trace> {
    let all = split.all();
    let run_of = |judged: &Judged| -> Vec<Vec<f64>> {
        let unpacked = problem.unpack(&judged.fit.effects, &judged.simulation);
        let simulated =
            starting_points(problem, &unpacked, &all).and_then(|p| simulate(problem, &unpacked, &all, &p));
        match simulated {
            Some(s) => s.iter().map(|s| judged_channel(problem, s)).collect(),
            None => vec![Vec::new(); all.len()],
        }
    };
    let (before, after) = (run_of(baseline), run_of(extended));
    let unit = if problem.data.has_rate { "rad/s" } else { "rad" };
    let with_runs = all.iter().zip(before).zip(after).enumerate();
    with_runs
        .map(|(i, ((place, baseline), extended))| Trace {
            label: place.label.clone(),
            held_out: i >= split.training.len(),
            t: place.rows.clone().map(|k| problem.data.runs[place.run].time(k)).collect(),
            measured: judged(problem, place).to_vec(),
            baseline,
            extended,
            unit,
        })
        .collect()
}
