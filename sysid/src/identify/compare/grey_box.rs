//! Lines of the grey box by maximum likelihood.

use super::cautions::{delay_on_bound, undetermined};
use super::judging::Work;
use super::{MethodResult, with_input_unit};
use crate::catalogue::model_file::model_file;
use crate::error::{Error, ErrorKind};
use crate::estimate::Estimate;
use crate::identify::hinf_match::MountRange;
use crate::identify::linear_model::LinearModel;
use crate::identify::output_error::delay_profile::{DelayProfile, delay_profile};
use crate::identify::output_error::identifiability::{Identifiability, identifiability};
use crate::identify::output_error::{Noise, Options, OutputErrorFit, fit};
use crate::likelihood::blow_up::no_likelihood;
use crate::likelihood::fit::{Fit, fit_baseline};
use crate::likelihood::free_run::{
    noise_held, output_errors, refit_for_simulation, starting_points, vaf_by_place,
};
use crate::likelihood::problem::{Problem, mode_of};
use crate::model::baseline::Baseline;
use crate::model::file::{Interval, ModelFile};
use crate::model::plant::Plant;
use crate::optim::levenberg_marquardt::covariance;
use std::collections::BTreeMap;

/// How far the mount's mode may lie from the start, as factors, and damping ratios that an elastomer mount has.
const MOUNT_MODE_RANGE: [f64; 2] = [0.5, 2.2];
const MOUNT_DAMPING_RANGE: [f64; 2] = [0.03, 1.0];

/// What the grey box gives.
pub(super) struct GreyBox {
    pub lines: Vec<MethodResult>,
    pub plant: Plant,
    pub parameters: Vec<Estimate>,
    pub parameters_coloured: Vec<Estimate>,
    pub correlation: Vec<Vec<f64>>,
    pub identifiability: Option<Identifiability>,
    pub delay: Option<DelayProfile>,
    pub model: ModelFile,
    /// What speaks against its values.
    pub cautions: Vec<String>,
}

/// Fits the grey box with white and with coloured errors; one that holds effects of the user's own by the general
/// model.
pub(super) fn fit_all(work: &Work, baseline: &Baseline, thorough: bool) -> Result<GreyBox, Error> {
    if !baseline.terms.is_empty() {
        return with_effects(work, baseline);
    }
    let mount = baseline.plant.mount.map(|mount| MountRange {
        mode_hz: MOUNT_MODE_RANGE.map(|factor| factor * mode_of(&mount).0),
        damping_ratio: MOUNT_DAMPING_RANGE,
    });
    let options = Options {
        output: work.output,
        held_input: work.held_input,
        free_delay: baseline.delay_free,
        mount,
        ..Options::default()
    };
    let coloured = Options { noise: Noise::Coloured, ..options };
    let start = &baseline.plant;
    let found = fit(&work.training, start, &options)?;
    let modelled = fit(&work.training, &found.plant, &Options { several_starts: false, ..coloured })?;
    let line = |found: &OutputErrorFit, detail: String| {
        work.line("grey-box ML", detail, LinearModel::GreyBox(found.plant, options), remark(found))
    };
    let order = modelled.autoregression.len();
    let colour =
        if order == 0 { "errors are white".into() } else { format!("coloured noise, order {order}") };
    let unit = work.data.input_unit;
    let parameters = with_input_unit(found.parameters.clone(), unit);
    let mut model = model_file(&found.plant, &[], 0.0);
    let undetermined = undetermined(&found);
    match undetermined {
        Some(_) => (model.plant.delay_s, model.plant.dm_dq, model.plant.dm_du) = (None, None, None),
        None => add_intervals(&mut model, &parameters),
    }
    // from the best end: there is no need for further starts
    let (again, once_more) =
        (Options { several_starts: false, ..options }, Options { several_starts: false, ..coloured });
    let profile = || delay_profile(&work.training, &found.plant, &again).ok();
    let cannot_tell = || identifiability(&work.training, &modelled.plant, &once_more).ok().flatten();
    Ok(GreyBox {
        lines: vec![line(&found, "output error".into()), line(&modelled, colour)],
        plant: found.plant,
        parameters,
        parameters_coloured: with_input_unit(modelled.parameters.clone(), unit),
        correlation: found.correlation.row_iter().map(|row| row.iter().copied().collect()).collect(),
        identifiability: if thorough { cannot_tell() } else { None },
        delay: if thorough { profile() } else { None },
        model,
        cautions: undetermined.into_iter().chain(delay_on_bound(&[&found, &modelled])).collect(),
    })
}

fn remark(found: &OutputErrorFit) -> String {
    let [agreeing, starts] = found.agreeing_starts;
    let mut remark =
        if found.converged { "converged".to_owned() } else { "stopped before it converged".to_owned() };
    if starts > 1 {
        remark.push_str(&format!("; {agreeing} of {starts} starts agree"));
    }
    if !found.on_bound.is_empty() {
        remark.push_str(&format!("; on its bound, so not identified: {}", found.on_bound.join(", ")));
    }
    remark
}

fn add_intervals(model: &mut ModelFile, parameters: &[Estimate]) {
    for estimate in parameters {
        let key = match estimate.name.as_str() {
            "dM_dq" => "dM_dq_N_m_s",
            "dM_du" => "dM_du_N_m",
            "delay" => "delay_s",
            _ => continue,
        };
        model.intervals.insert(key.into(), Interval { ci95: estimate.ci95 });
    }
}

/// A grey box with effects, by the general model's numerical derivatives.
fn with_effects(work: &Work, baseline: &Baseline) -> Result<GreyBox, Error> {
    let (data, split) = (work.data, work.split);
    let problem = Problem::new(data, baseline, &split.held_out);
    let fit = fit_baseline(&problem).ok_or_else(|| no_likelihood(&problem))?;
    let minimum = refit_for_simulation(&problem, &fit, &split.training).ok_or_else(|| {
        let advice = "check the units of the columns and the values of the model file";
        Error::new(ErrorKind::Numerical, "the free run of the grey box diverges on these data", advice)
    })?;
    let unpacked = problem.unpack(&[], &minimum.values);
    let all = split.all();
    let vaf = vaf_by_place(&problem, &unpacked, &all);
    let parameters = output_error_estimates(work, &problem, &fit, &minimum.values);
    let mut model = model_file(&unpacked.plant, &unpacked.terms, data.origin());
    add_intervals(&mut model, &parameters);
    let remark = if minimum.converged { "converged" } else { "stopped before it converged" };
    let line = MethodResult {
        name: "grey-box ML".into(),
        detail: "output error, with the model's effects".into(),
        vaf_percent: all.iter().map(|p| p.label.clone()).zip(vaf).collect(),
        remark: remark.into(),
        tests: BTreeMap::new(),
        simulated: BTreeMap::new(),
        model: None,
    };
    Ok(GreyBox {
        lines: vec![line],
        plant: unpacked.plant,
        parameters,
        parameters_coloured: Vec::new(),
        correlation: Vec::new(),
        identifiability: None,
        delay: None,
        model,
        cautions: Vec::new(),
    })
}

/// The plant's parameters with intervals that allow for output errors correlated over a second.
fn output_error_estimates(work: &Work, problem: &Problem<'_>, fit: &Fit, values: &[f64]) -> Vec<Estimate> {
    const CORRELATION_S: f64 = 1.0;
    let coordinates = noise_held(problem, fit);
    let lag = (CORRELATION_S / problem.sizes.step).ceil() as usize;
    let training = &work.split.training;
    let found = starting_points(problem, &problem.unpack(&[], values), training).and_then(|points| {
        covariance(&*output_errors(problem, fit, training, &points), 1, &coordinates, values, lag)
    });
    (0..problem.plant_unknowns())
        .map(|i| {
            let c = &coordinates[i];
            let deviation = found.as_ref().map_or(f64::INFINITY, |cov| cov[(i, i)].max(0.0).sqrt());
            Estimate::new(&c.name, &c.unit, values[i], deviation, c.bounds)
        })
        .collect()
}
