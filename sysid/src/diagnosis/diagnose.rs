//! The whole diagnosis: recordings and a baseline in, an answer out.

use super::answer::{Answer, FitAnswer, Location, Verdict};
use super::building::{account, ceilings};
use super::data_checks::{self, DullCause};
use super::evaluation::{Judged, Trace, traces};
use super::excitation;
use super::over_time::OverTime;
use super::selection::select;
use super::verdict::Judgement;
use crate::dataset::Dataset;
use crate::error::{Error, ErrorKind};
use crate::held_out::{Split, labels};
use crate::likelihood::problem::Problem;
use crate::model::baseline::Baseline;
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
    let dm_du = model.and_then(|m| m.plant.dm_du);
    let mut causes = data_checks::of_recordings(recordings, &data, dm_du);
    let told = |mut diagnosis: Diagnosis, causes: Vec<DullCause>| {
        data_checks::tell(&mut diagnosis.answer, causes);
        Ok(diagnosis)
    };
    if let Some(reason) = excitation::too_little(&problem, &split) {
        causes.extend(data_checks::without_fit("too little to ask"));
        return told(not_excited(&problem, &split, reason, notes), causes);
    }
    if data_checks::stop(&causes) {
        causes.extend(data_checks::without_fit("not asked before the others are put right"));
        let location = data_checks::everywhere(&causes, &data);
        return told(put_right_first(&problem, &split, None, location, notes), causes);
    }
    let selection = select(&problem, progress).ok_or_else(|| {
        Error::new(
            ErrorKind::Numerical,
            "the baseline has no finite likelihood on these data",
            "check the units of the columns and the values of the model file",
        )
    })?;
    if let Some(reason) = excitation::too_weak(&problem, &split, &selection.baseline) {
        causes.extend(data_checks::without_fit("too weak to ask"));
        return told(not_excited(&problem, &split, reason, notes), causes);
    }
    progress("ruling out dull causes");
    causes.extend(data_checks::of_fit(recordings, &problem, &split, &selection, dm_du));
    if data_checks::stop(&causes) {
        let location = data_checks::everywhere(&causes, &data);
        let baseline = Judged::new(&problem, &split, selection.baseline);
        return told(put_right_first(&problem, &split, Some(&baseline), location, notes), causes);
    }
    progress("judging on held-out data");
    told(account(&Judgement::new(&problem, &split, selection), notes), causes)
}

fn not_excited(problem: &Problem<'_>, split: &Split, reason: String, notes: Vec<String>) -> Diagnosis {
    unanswered(problem, split, None, Verdict::NotExcited, reason, None, notes)
}

/// No physics is named: a dull cause is to be put right first. The baseline's fit is told where there is one.
fn put_right_first(
    problem: &Problem<'_>,
    split: &Split,
    baseline: Option<&Judged>,
    location: Location,
    notes: Vec<String>,
) -> Diagnosis {
    unanswered(problem, split, baseline, Verdict::Unlisted, String::new(), Some(location), notes)
}

fn unanswered(
    problem: &Problem<'_>,
    split: &Split,
    baseline: Option<&Judged>,
    verdict: Verdict,
    summary: String,
    location: Option<Location>,
    notes: Vec<String>,
) -> Diagnosis {
    let nothing = || super::answer::ModelAnswer {
        vaf_percent: Default::default(),
        parameters: Vec::new(),
        simulation_parameters: Default::default(),
    };
    let told = || baseline.map_or_else(nothing, |judged| judged.answer(problem, split));
    let fit = FitAnswer {
        baseline: told(),
        extended: told(),
        held_out: labels(&split.held_out),
        ceiling_vaf_percent: baseline.map(|b| ceilings(problem, split, b)).unwrap_or_default(),
        placebo: None,
    };
    let traces = baseline.map(|b| traces(problem, split, b, b)).unwrap_or_default();
    let dull_causes = Vec::new();
    Diagnosis {
        answer: Answer {
            schema: "pitchid.diagnosis/1",
            verdict,
            summary,
            effects: Vec::new(),
            location,
            fit,
            next_experiment: None,
            dull_causes,
            notes,
        },
        traces,
        over_time: OverTime::default(),
        model: problem.baseline.to_model_file(),
    }
}
