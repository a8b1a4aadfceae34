//! The whole diagnosis: recordings and a baseline in, an answer out.

use super::account::account;
use super::answer::{Answer, FitAnswer, Verdict};
use super::baseline::Baseline;
use super::excitation;
use super::held_out::Split;
use super::judge::{Trace, labels};
use super::judgement::Judgement;
use super::over_time::OverTime;
use super::problem::Problem;
use super::rank::select;
use crate::dataset::Dataset;
use crate::error::{Error, ErrorKind};
use crate::model::file::ModelFile;
use crate::recording::Recording;

/// An answer with what a report shows beside it.
pub struct Diagnosis {
    /// The answer.
    pub answer: Answer,
    /// Measured against simulated, section by section.
    pub traces: Vec<Trace>,
    /// What the models leave, over time.
    pub over_time: OverTime,
    /// The extended model, its parameters fitted for simulation.
    pub model: ModelFile,
}

/// Diagnoses recordings of one vehicle against `model` (the user's simulation), or against the grey-box pitch model
/// where there is none. `progress` is told what is being done.
///
/// # Errors
/// Recordings that do not go together, or for which not even the baseline has a finite likelihood.
pub fn diagnose(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, Error> {
    let data = Dataset::new(recordings)?;
    let baseline = match model {
        Some(model) => Baseline::from_model(model, &data)?,
        None => Baseline::from_data(&data),
    };
    let split = Split::new(&data);
    let problem = Problem::new(&data, &baseline, &split.held_out);
    let notes = data.notes(recordings);
    if let Some(reason) = excitation::too_little(&problem, &split) {
        return Ok(not_excited(&problem, &split, reason, notes));
    }
    let selection = select(&problem, progress).ok_or_else(|| {
        Error::new(
            ErrorKind::Numerical,
            "the baseline has no finite likelihood on these data",
            "check the units of the columns and the values of the model file",
        )
    })?;
    if let Some(reason) = excitation::too_weak(&problem, &split, &selection.baseline) {
        return Ok(not_excited(&problem, &split, reason, notes));
    }
    progress("judging on held-out data");
    Ok(account(&Judgement::new(&problem, &split, selection), notes))
}

fn not_excited(problem: &Problem<'_>, split: &Split, reason: String, notes: Vec<String>) -> Diagnosis {
    let nothing = || super::answer::ModelAnswer {
        vaf_percent: Default::default(),
        parameters: Vec::new(),
        simulation_parameters: Default::default(),
    };
    let fit = FitAnswer {
        baseline: nothing(),
        extended: nothing(),
        held_out: labels(&split.held_out),
        ceiling_vaf_percent: Default::default(),
    };
    Diagnosis {
        answer: Answer {
            schema: "pitchid.diagnosis/1",
            verdict: Verdict::NotExcited,
            summary: reason,
            effects: Vec::new(),
            location: None,
            fit,
            next_experiment: None,
            notes,
        },
        traces: Vec::new(),
        over_time: OverTime::default(),
        model: problem.baseline.to_model_file(),
    }
}
