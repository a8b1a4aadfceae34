//! The line of the H∞ match, with its certificate and its intervals.

use super::black_box::Subspace;
use super::judging::Work;
use super::{MethodResult, Settings, with_input_unit};
use crate::error::{Error, ErrorKind};
use crate::estimate::Estimate;
use crate::identify::bootstrap::{Recipe, Replicates, bootstrap};
use crate::identify::butterworth::Butterworth;
use crate::identify::hinf_match::{HinfMatch, hinf_match};
use crate::identify::linear_model::LinearModel;
use crate::identify::output_error::Options;
use crate::identify::pi_moesp::identify;
use crate::model::plant::Plant;
use crate::progress::Progress;
use crate::validate::vaf::vaf;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rows that the bootstrap works through at most, but never fewer records than give an interval.
const BOOTSTRAP_ROWS: usize = 4_000_000;
const ENOUGH: usize = 50;
/// A weighted error above this share of the response is no match.
const UNLIKE: f64 = 0.3;

/// What the match is worth.
#[derive(Clone, Debug, Serialize)]
pub struct HinfReport {
    /// n and i of the PI-MOESP model that was matched.
    pub matched_to: [usize; 2],
    /// Order and cutoff (rad/s) of the weight.
    pub weight_order: usize,
    /// See `weight_order`.
    pub weight_cutoff_rad_s: f64,
    /// ∂M/∂q and ∂M/∂u with 95 % intervals; the mount is held.
    pub parameters: Vec<Estimate>,
    /// Norm of the weighted error, rad/s per unit of the input, exact to its relative tolerance.
    pub norm: f64,
    /// Where it is attained, rad/s.
    pub norm_omega_rad_s: f64,
    /// The largest weighted error over a dense grid.
    pub dense_grid: f64,
    /// The norm relative to that of the weighted PI-MOESP model.
    pub relative: f64,
    /// Frequencies that hold the optimum, rad/s.
    pub active_rad_s: Vec<f64>,
    /// By held-out section, VAF between both models' free runs, per cent.
    pub agreement_percent: BTreeMap<String, f64>,
    /// Records of the bootstrap that gave an answer, of those tried.
    pub replicates: [usize; 2],
    /// ω (rad/s) and the 95 % interval of the PI-MOESP model's gain.
    pub gain_band: Vec<[f64; 3]>,
}

/// Matches the grey box to the PI-MOESP model.
pub(super) fn matched(
    work: &Work,
    pi: &Subspace,
    start: &Plant,
    weight: &Butterworth,
    settings: &Settings,
    progress: &Progress<'_>,
) -> (MethodResult, Option<HinfReport>) {
    let name = "H∞ match";
    match try_match(work, pi, start, weight, settings, progress) {
        Ok((found, report)) => {
            let [n, i] = report.matched_to;
            let detail = format!("to n = {n}, i = {i}");
            let unlike =
                if found.relative > UNLIKE { "; no grey box resembles the PI-MOESP model" } else { "" };
            let remark = format!(
                "weighted error {:.1} % of the response, at {:.2} rad/s; {} of {} starts agree{unlike}",
                100.0 * found.relative,
                found.norm.omega,
                found.agreeing_starts[0],
                found.agreeing_starts[1],
            );
            (work.line(name, detail, grey_box(work, &found.plant), remark), Some(report))
        }
        Err(error) => (work.without_answer(name, &error), None),
    }
}

fn grey_box(work: &Work, plant: &Plant) -> LinearModel {
    LinearModel::GreyBox(*plant, Options { held_input: work.held_input, ..Options::default() })
}

fn try_match(
    work: &Work,
    pi: &Subspace,
    start: &Plant,
    weight: &Butterworth,
    settings: &Settings,
    progress: &Progress<'_>,
) -> Result<(HinfMatch, HinfReport), Error> {
    let none = |what| Error::new(ErrorKind::Numerical, what, "give longer sections");
    let chosen = pi.chosen.as_ref().ok_or_else(|| none("there is no PI-MOESP model to match"))?;
    let (target, order, block_size) = chosen
        .continuous
        .as_ref()
        .ok_or_else(|| none("no PI-MOESP model has a continuous-time equivalent"))?;
    let found = hinf_match(&target.with_delay(start.delay)?, start, weight, None)?;
    let model = identify(&work.training, *order, *block_size, &pi.method)?.model;
    let omegas: Vec<f64> = work.response().iter().map(|line| line.omega_rad_s).collect();
    let recipe = Recipe {
        pieces: &work.training,
        model: &model,
        block_size: *block_size,
        method: pi.method,
        matched: Some((*start, *weight)),
        omegas: &omegas,
    };
    let rows: usize = work.training.iter().map(|piece| piece.rows.len()).sum();
    let affordable = (BOOTSTRAP_ROWS / rows.max(1)).max(ENOUGH);
    let all = if settings.replicates > 0 {
        bootstrap(&recipe, settings.replicates.min(affordable), settings.seed, progress)?
    } else {
        Replicates::default()
    };
    let (grey, black) = (grey_box(work, &found.plant), LinearModel::Sampled(model.clone()));
    let mut free_runs: BTreeMap<&str, [Vec<f64>; 2]> = BTreeMap::new();
    for (place, piece) in &work.held_out {
        if let (Some(black), Some(grey)) = (black.simulate(piece), grey.simulate(piece)) {
            let [all_black, all_grey] = free_runs.entry(place.label.as_str()).or_default();
            all_black.extend(black);
            all_grey.extend(grey);
        }
    }
    let agreement = |(label, [black, grey]): (&str, [Vec<f64>; 2])| (label.to_owned(), vaf(&black, &grey));
    let unit = work.data.input_unit;
    let estimate = |name: &str, unit: &str, value: f64, ci95| Estimate {
        name: name.into(),
        unit: unit.into(),
        value,
        ci95,
    };
    let parameters = vec![
        estimate("dM_dq", "N m s/rad", found.plant.dm_dq, all.interval(&found.plant, |p| p.dm_dq)),
        estimate("dM_du", "N m/rad", found.plant.dm_du, all.interval(&found.plant, |p| p.dm_du)),
    ];
    let band = |(k, omega): (usize, &f64)| {
        let [low, high] = all.gain_interval(model.frequency_response(*omega)?.norm(), k);
        Some([*omega, low.max(0.0), high]).filter(|_| high.is_finite())
    };
    let gain_band = omegas.iter().enumerate().filter_map(band).collect();
    let report = HinfReport {
        matched_to: [*order, *block_size],
        weight_order: weight.order,
        weight_cutoff_rad_s: weight.cutoff,
        parameters: with_input_unit(parameters, unit),
        norm: found.norm.value,
        norm_omega_rad_s: found.norm.omega,
        dense_grid: found.dense_grid,
        relative: found.relative,
        active_rad_s: found.active.clone(),
        agreement_percent: free_runs.into_iter().map(agreement).collect(),
        replicates: [all.plants.len(), settings.replicates.min(affordable)],
        gain_band,
    };
    Ok((found, report))
}
