//! Lines of the methods that know nothing of the vehicle.

use super::MethodResult;
use super::judging::Work;
use crate::error::Error;
use crate::identify::block_hankel::Instruments;
use crate::identify::cross_validation::{Chosen, cross_validated};
use crate::identify::fir::{Fir, FirOptions, Piece, fit};
use crate::identify::kung::realise_by_free_run;
use crate::identify::linear_model::LinearModel;
use crate::identify::lms::{LmsFit, OnBoard, replay};
use crate::identify::pi_moesp::Method;
use crate::recording::InputUnit;
use estimator_core::convergence::{ConvergenceConfig, Verdict};
use estimator_core::lms::LmsConfig;

/// Amplitude that the on-board estimator's defaults are made for.
const USUAL_AMPLITUDE: f64 = 0.015;
/// Room of the replayed estimator.
const MOST_TAPS: usize = 256;
/// Below this cross-validated VAF the grey box's delay is doubted.
const DOUBTFUL: f64 = 90.0;
/// A delay must gain this many points of cross-validated VAF against the grey box's to be taken instead.
const WORTH: f64 = 0.5;

/// Share of a sample that a delay may exceed a whole number by, and still is that.
const HAIR: f64 = 0.1;

/// The on-board estimator over the training sections, and its realisation.
pub(super) fn lms_and_kung(work: &Work, on_board: Option<&OnBoard>) -> Vec<MethodResult> {
    let flown =
        on_board.map(|flown| with_realisation(work, "LMS on board", &flown.fir, flown.verdict.clone()));
    let mut lines: Vec<MethodResult> = flown.into_iter().flatten().collect();
    let name = "LMS FIR";
    let fitted = match replayed(work, on_board) {
        Ok(fitted) => fitted,
        Err(error) => {
            lines.push(work.without_answer(name, &error));
            return lines;
        }
    };
    let verdict = match fitted.convergence.verdict {
        Verdict::Converged => "converged".to_owned(),
        other => format!(
            "{}: {:.1} time constants passed, {:.0} % of the power not predicted",
            if other == Verdict::NotExcited { "not excited" } else { "still converging" },
            fitted.convergence.settling,
            100.0 * fitted.convergence.innovation_ratio
        ),
    };
    lines.extend(with_realisation(work, name, &fitted.fir, verdict));
    lines
}

/// Taps, and their realisation.
fn with_realisation(work: &Work, name: &str, fir: &Fir, remark: String) -> [MethodResult; 2] {
    let of_realisation = format!("{name} + Kung");
    let realised = match realise_by_free_run(fir, &work.training) {
        Ok(found) => {
            let detail = format!("order {}", found.model.order());
            work.line(&of_realisation, detail, LinearModel::Sampled(found.model), found.reason)
        }
        Err(error) => work.without_answer(&of_realisation, &error),
    };
    let detail = format!("{} taps", fir.taps.len());
    [work.line(name, detail, LinearModel::Impulse(fir.clone()), remark), realised]
}

/// The core's estimator; inputs in other units are brought to the size of the excitation that its defaults are made
/// for, and the taps back. Set as it was in flight, where that is known.
fn replayed(work: &Work, on_board: Option<&OnBoard>) -> Result<LmsFit, Error> {
    let factor = match work.data.input_unit {
        InputUnit::Rad => 1.0,
        _ => USUAL_AMPLITUDE / work.data.amplitudes(1.0, 1.0).u,
    };
    let scaled: Vec<Vec<f64>> =
        work.data.runs.iter().map(|run| run.u.iter().map(|u| u * factor).collect()).collect();
    let pieces: Vec<Piece<'_>> =
        work.training.iter().map(|piece| Piece { u: &scaled[piece.run], ..piece.clone() }).collect();
    let usual = LmsConfig { taps: work.taps() as u16, ..LmsConfig::default() };
    let lms = on_board.map_or(usual, |flown| flown.lms);
    let mut fit = replay::<MOST_TAPS>(&pieces, &lms, &ConvergenceConfig::default())?;
    for tap in &mut fit.fir.taps {
        *tap *= factor;
    }
    Ok(fit)
}

/// Batch least squares on the same taps as the on-board estimator's.
pub(super) fn batch_fir(work: &Work) -> MethodResult {
    let options = FirOptions { taps: work.taps(), first_lag: 1, use_supervised: false };
    match fit(&work.training, &options) {
        Ok(found) => {
            let remark = format!("{} rows", found.rows);
            work.line("batch FIR", format!("{} taps", options.taps), LinearModel::Impulse(found.fir), remark)
        }
        Err(error) => work.without_answer("batch FIR", &error),
    }
}

/// A subspace method's line, with the choice that it rests on.
pub(super) struct Subspace {
    pub line: MethodResult,
    pub method: Method,
    pub chosen: Option<Chosen>,
}

/// PI-MOESP and PO-MOESP behind the grey box's delay; without any where PI-MOESP then predicts clearly better.
pub(super) fn subspace(work: &Work, delay: f64) -> [Subspace; 2] {
    let behind = |instruments, delay_samples| {
        // without a delay a direct term would learn the controller: u[k] answers to y[k]
        let (direct, held_input) = (delay_samples > 0, work.held_input);
        let method = Method { instruments, delay_samples, direct, held_input, ..Method::default() };
        (method, cross_validated(&work.training, 1..=5, 10..=50, &method))
    };
    let score = |chosen: &Result<Chosen, Error>| chosen.as_ref().map_or(0.0, |c| c.vaf_percent);
    // what the identified model has too much of it is known, and given back before the match
    let whole = (delay / work.step - HAIR).ceil().max(0.0) as usize;
    let mut pi = behind(Instruments::PastInputs, whole);
    if whole > 0 && score(&pi.1) < DOUBTFUL {
        let prompt = behind(Instruments::PastInputs, 0);
        if score(&prompt.1) > score(&pi.1) + WORTH {
            pi = prompt;
        }
    }
    let po = behind(Instruments::PastInputsAndOutputs, pi.0.delay_samples);
    [("PI-MOESP", pi), ("PO-MOESP", po)].map(|(name, (method, chosen))| match chosen {
        Ok(chosen) => {
            let detail = format!("n = {}, i = {}", chosen.order, chosen.block_size);
            let model = LinearModel::Sampled(chosen.model.clone());
            Subspace { line: work.line(name, detail, model, remark(&chosen)), method, chosen: Some(chosen) }
        }
        Err(error) => Subspace { line: work.without_answer(name, &error), method, chosen: None },
    })
}

fn remark(chosen: &Chosen) -> String {
    let usable = chosen.table.iter().filter(|cell| cell.vaf_percent.is_some()).count();
    let flat = if chosen.reason.ends_with("flat.") { "flat" } else { "clear" };
    format!("stable; {flat} choice among {usable} of {} models", chosen.table.len())
}
