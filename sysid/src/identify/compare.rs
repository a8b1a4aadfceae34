//! All methods on the same data, side by side: LMS taps as they would come from the autopilot, their realisation, and
//! the grey box by output-error maximum likelihood.

use super::fir::{Fir, Piece, pieces};
use super::kung::realise;
use super::levenberg_marquardt::covariance;
use super::lms::{LmsFit, replay};
use crate::dataset::{Dataset, Place};
use crate::diagnosis::baseline::{Baseline, model_file};
use crate::diagnosis::free_run::{
    noise_held, output_errors, refit_for_simulation, starting_points, vaf_by_place,
};
use crate::diagnosis::held_out::Split;
use crate::diagnosis::judge::labels;
use crate::diagnosis::problem::Problem;
use crate::diagnosis::search::{Fit, fit_baseline};
use crate::error::{Error, ErrorKind};
use crate::estimate::Estimate;
use crate::model::file::{Interval, ModelFile};
use crate::recording::Recording;
use crate::validate::vaf::vaf;
use estimator_core::convergence::{ConvergenceConfig, Verdict};
use estimator_core::lms::LmsConfig;
use serde::Serialize;
use std::collections::BTreeMap;

/// What the methods found, and how each simulates the sections it was fitted on and those it was not.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// One line for each method.
    pub methods: Vec<MethodResult>,
    /// The grey box's parameters (output error), with 95 % intervals.
    pub parameters: Vec<Estimate>,
    /// Sections that were fitted on.
    pub training: Vec<String>,
    /// Sections kept aside: an unused PRBS and the closed loop, as far as there are any.
    pub held_out: Vec<String>,
    /// What was noticed about the recordings.
    pub notes: Vec<String>,
    /// The grey box as a model file, with its intervals.
    #[serde(skip)]
    pub model: ModelFile,
}

/// One method's line.
#[derive(Clone, Debug, Serialize)]
pub struct MethodResult {
    /// Method.
    pub name: String,
    /// Order, number of taps, or what else was chosen.
    pub detail: String,
    /// Free-run VAF by section, per cent.
    pub vaf_percent: BTreeMap<String, f64>,
    /// What the user should know: converged or not, stable or not.
    pub remark: String,
}

/// Identifies the pitch dynamics from recordings of one vehicle, starting from `model` where the user has one.
/// `progress` is told what is being done.
///
/// # Errors
/// Recordings that do not go together, or on which the grey box has no finite likelihood.
pub fn identify(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Identification, Error> {
    let data = Dataset::new(recordings)?;
    let baseline = match model {
        Some(model) => Baseline::from_model(model, &data)?,
        None => Baseline::from_data(&data),
    };
    let split = Split::for_validation(&data);
    let mut methods = Vec::new();
    progress("replaying the on-board LMS");
    if data.has_rate {
        methods.extend(lms_and_kung(&data, &split)?);
    }
    progress("fitting the grey box");
    let problem = Problem::new(&data, &baseline, &split.held_out);
    let grey_box = grey_box(&problem, &split)?;
    methods.push(grey_box.line);
    Ok(Identification {
        methods,
        parameters: grey_box.parameters,
        training: labels(&split.training),
        held_out: labels(&split.held_out),
        notes: data.notes(recordings),
        model: grey_box.model,
    })
}

fn lms_and_kung(data: &Dataset, split: &Split) -> Result<Vec<MethodResult>, Error> {
    let all = split.all();
    let on_board = on_board_lms(data, &split.training)?;
    let simulate = |fir: &Fir| -> BTreeMap<String, f64> {
        all.iter()
            .map(|place| {
                let run = &data.runs[place.run];
                let simulated = fir.simulate(&run.u[..place.rows.end]);
                let measured = run.rate.as_deref().unwrap_or_default();
                (place.label.clone(), vaf(&measured[place.rows.clone()], &simulated[place.rows.clone()]))
            })
            .collect()
    };
    let verdict = match on_board.convergence.verdict {
        Verdict::Converged => "converged".to_owned(),
        other => format!(
            "{other:?}: {:.1} time constants passed, {:.0} % of the power not predicted",
            on_board.convergence.settling,
            100.0 * on_board.convergence.innovation_ratio
        ),
    };
    let mut lines = vec![MethodResult {
        name: "LMS FIR".into(),
        detail: format!("{} taps", on_board.fir.taps.len()),
        vaf_percent: simulate(&on_board.fir),
        remark: verdict,
    }];
    let realised = realise(&on_board.fir, None)?;
    let place_vaf = |place: &Place| {
        let run = &data.runs[place.run];
        let (u, y) =
            (&run.u[place.rows.clone()], &run.rate.as_deref().unwrap_or_default()[place.rows.clone()]);
        let simulated =
            realised.model.initial_state(u, y).ok().map(|x0| realised.model.simulate(u, Some(&x0)));
        (place.label.clone(), simulated.map_or(0.0, |s| vaf(y, &s)))
    };
    lines.push(MethodResult {
        name: "LMS FIR + Kung".into(),
        detail: format!("order {}", realised.model.order()),
        vaf_percent: all.iter().map(place_vaf).collect(),
        remark: realised.reason.clone(),
    });
    Ok(lines)
}

/// The core's estimator over the training sections; inputs in other units are brought to the size of the excitation
/// that its defaults are made for, and the taps back.
fn on_board_lms(data: &Dataset, training: &[Place]) -> Result<LmsFit, Error> {
    const USUAL_AMPLITUDE: f64 = 0.015;
    let factor = match data.input_unit {
        crate::recording::InputUnit::Rad => 1.0,
        _ => USUAL_AMPLITUDE / data.amplitudes(1.0).u,
    };
    let scaled: Vec<Vec<f64>> =
        data.runs.iter().map(|run| run.u.iter().map(|u| u * factor).collect()).collect();
    let pieces: Vec<Piece<'_>> =
        pieces(data, training)?.into_iter().map(|piece| Piece { u: &scaled[piece.run], ..piece }).collect();
    let step = data.runs.first().map_or(0.02, |run| run.step);
    let (lms, convergence) = (LmsConfig::default(), ConvergenceConfig::default());
    let mut fit = if step < 0.01 {
        replay::<256>(&pieces, &lms, &convergence)?
    } else {
        replay::<60>(&pieces, &lms, &convergence)?
    };
    for tap in &mut fit.fir.taps {
        *tap *= factor;
    }
    Ok(fit)
}

struct GreyBox {
    line: MethodResult,
    parameters: Vec<Estimate>,
    model: ModelFile,
}

fn grey_box(problem: &Problem<'_>, split: &Split) -> Result<GreyBox, Error> {
    let failed = |what: &str| {
        Error::new(
            ErrorKind::Numerical,
            what,
            "check the units of the columns and the values of the model file",
        )
    };
    let fit =
        fit_baseline(problem).ok_or_else(|| failed("the grey box has no finite likelihood on these data"))?;
    let minimum = refit_for_simulation(problem, &fit, &split.training)
        .ok_or_else(|| failed("the free run of the grey box diverges on these data"))?;
    let unpacked = problem.unpack(&[], &minimum.values);
    let all = split.all();
    let vaf = vaf_by_place(problem, &unpacked, &all);
    let parameters = output_error_estimates(problem, split, &fit, &minimum.values);
    let mut model = model_file(&unpacked.plant, &unpacked.terms);
    for estimate in &parameters {
        let key = match estimate.name.as_str() {
            "dM_dq" => "dM_dq_N_m_s",
            "dM_du" => "dM_du_N_m",
            "delay" => "delay_s",
            _ => continue,
        };
        model.intervals.insert(key.into(), Interval { ci95: estimate.ci95 });
    }
    let remark = if minimum.converged { "converged" } else { "stopped before it converged" };
    let line = MethodResult {
        name: "grey-box ML".into(),
        detail: "output error".into(),
        vaf_percent: all.iter().map(|p| p.label.clone()).zip(vaf).collect(),
        remark: remark.into(),
    };
    Ok(GreyBox { line, parameters, model })
}

/// The plant's parameters with intervals that allow for output errors correlated over a second.
fn output_error_estimates(problem: &Problem<'_>, split: &Split, fit: &Fit, values: &[f64]) -> Vec<Estimate> {
    const CORRELATION_S: f64 = 1.0;
    let coordinates = noise_held(problem, fit);
    let lag = (CORRELATION_S / problem.sizes.step).ceil() as usize;
    let found = starting_points(problem, &problem.unpack(&[], values), &split.training).and_then(|points| {
        covariance(&*output_errors(problem, fit, &split.training, &points), 1, &coordinates, values, lag)
    });
    (0..problem.plant_unknowns())
        .map(|i| {
            let c = &coordinates[i];
            let deviation = found.as_ref().map_or(f64::INFINITY, |cov| cov[(i, i)].max(0.0).sqrt());
            Estimate::new(&c.name, &c.unit, values[i], deviation, c.bounds)
        })
        .collect()
}
