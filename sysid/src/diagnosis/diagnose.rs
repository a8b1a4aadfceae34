//! The whole diagnosis: recordings and a baseline in, an answer out.

use super::answer::{Answer, FitAnswer, Location, Predicted, Verdict};
use super::balance::Balance;
use super::between_rows;
use super::building::build;
use super::candidates::Candidate;
use super::component::Component;
use super::data_checks::{self, DataCheck, Loops};
use super::describe::{figures, predicts};
use super::estimates::estimates_of;
use super::excitation;
use super::judgement::Judgement;
use super::left_over::LeftOver;
use super::levels::PARTS;
use super::over_time::OverTime;
use super::parts::parts;
use super::predicted::{tells_nothing, tells_what_was_under_way};
use super::selection::select;
use super::spectra::Spectra;
use super::step_response::StepResponses;
use super::traces::Trace;
use crate::catalogue::CATALOGUE;
use crate::dataset::Dataset;
use crate::error::Error;
use crate::likelihood::blow_up::no_likelihood;
use crate::likelihood::evidence::Information;
use crate::likelihood::fit::fit_baseline;
use crate::likelihood::problem::Problem;
use crate::likelihood::sensor_noise::sensor_noise;
use crate::model::baseline::{ASSUMED, Baseline};
use crate::model::effect::Effect;
use crate::model::file::ModelFile;
use crate::progress::Progress;
use crate::recording::Recording;

/// An answer with what a report shows beside it.
pub struct Diagnosis {
    /// The answer.
    pub answer: Answer,
    /// Measured against simulated, section by section.
    pub traces: Vec<Trace>,
    /// What the models leave, over time.
    pub over_time: OverTime,
    /// What the data say of each term that was added, largest share first.
    pub components: Vec<Component>,
    /// What is left one step ahead; `None` where nothing could be judged.
    pub left_over: Option<LeftOver>,
    /// Spectra of the motion and of what free runs leave.
    pub spectra: Spectra,
    /// Responses to a step of the input; `None` where nothing could be judged or a simulation diverges.
    pub steps: Option<StepResponses>,
    /// Every candidate that was tried, the most probable first.
    pub candidates: Vec<Candidate>,
    /// The extended model, with the values of the answer.
    pub model: ModelFile,
}

/// Diagnoses recordings of one vehicle against `model` (the user's simulation), or against the grey-box pitch model
/// where there is none. `progress` is told what is being done.
///
/// # Errors
/// Recordings that do not go together, or for which not even the baseline has a finite likelihood.
///
/// ```
/// # let mut text = String::from("t_s,u_N_m,q_rad_s\n");
/// # let mut q = 0.0;
/// # for k in 0..1500 {
/// #     let u = if (k / 17 + k / 41) % 2 == 0 { 0.1 } else { -0.1 };
/// #     let noise = f64::from((k * 7919 + 13) % 1009) / 1009.0 - 0.5;
/// #     text.push_str(&format!("{:.2},{u},{}\n", 0.02 * f64::from(k), q + 0.01 * noise));
/// #     q += 0.02 * (10.0 * u - 2.0 * q);
/// # }
/// use sysid::{diagnosis::diagnose, recording::parse};
/// let recording = parse("flight.csv", text.as_bytes(), &Default::default())?;
/// let diagnosis = diagnose(&[recording], None, &|_step| {})?;
/// println!("{}", diagnosis.answer.summary);
/// # Ok::<(), sysid::error::Error>(())
/// ```
pub fn diagnose(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    progress: &Progress<'_>,
) -> Result<Diagnosis, Error> {
    diagnose_with(recordings, model, CATALOGUE, progress)
}

/// The same with a catalogue of the caller's own: [`CATALOGUE`], less or more.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_with(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    catalogue: &[&'static dyn Effect],
    progress: &Progress<'_>,
) -> Result<Diagnosis, Error> {
    diagnose_knowing(recordings, model, &[], catalogue, progress)
}

/// The same with effects of the model that are `held` at its values.
pub fn diagnose_knowing(
    recordings: &[Recording],
    model: Option<&ModelFile>,
    held: &[&'static str],
    catalogue: &[&'static dyn Effect],
    progress: &Progress<'_>,
) -> Result<Diagnosis, Error> {
    let data = Dataset::new(recordings)?;
    let baseline = Baseline { held: held.to_vec(), ..Baseline::new(model, &data)? };
    let mut diagnosis = answered(&Asked { recordings, data: &data, model, catalogue, progress }, &baseline)?;
    if model.is_none_or(ModelFile::is_per_inertia) {
        diagnosis.answer.tell_per_inertia();
    }
    Ok(diagnosis)
}

/// What is asked, whatever the baseline.
struct Asked<'a> {
    recordings: &'a [Recording],
    data: &'a Dataset,
    model: Option<&'a ModelFile>,
    catalogue: &'a [&'static dyn Effect],
    progress: &'a Progress<'a>,
}

fn answered(asked: &Asked<'_>, baseline: &Baseline) -> Result<Diagnosis, Error> {
    let &Asked { recordings, data, model, catalogue, progress } = asked;
    let notes = || {
        let mut notes = data.notes(recordings);
        notes.extend(excitation::is_short(data));
        if model.is_none() {
            notes.push(ASSUMED.into());
        }
        notes
    };
    let parts = parts(data, PARTS);
    let problem = Problem::new(data, baseline, &[]);
    let unanswered = |verdict, summary, location| {
        let known = model.cloned().unwrap_or_else(ModelFile::unknown);
        unanswered(verdict, summary, location, notes(), known)
    };
    let dm_du = model.and_then(|m| m.plant.dm_du);
    let mut checks = data_checks::of_recordings(recordings, data, dm_du);
    let input_first = || {
        progress("fitting again with the input first: the loop is closed".into());
        answered(asked, &Baseline { input_first: true, ..baseline.clone() })
    };
    let balance = Balance::new(data, baseline, model);
    let with_checks = |mut diagnosis: Diagnosis, checks: Vec<DataCheck>, balance: Option<&Balance>| {
        if let Some(balance) = balance {
            balance.write(&mut diagnosis.answer, &mut diagnosis.model);
        }
        data_checks::write(&mut diagnosis.answer, checks);
        Ok(diagnosis)
    };
    if let Some(reason) = excitation::too_little(&problem) {
        checks.extend(data_checks::without_fit("too little to ask"));
        return with_checks(unanswered(Verdict::NotExcited, reason, None), checks, None);
    }
    if data_checks::stop(&checks) {
        checks.extend(data_checks::without_fit("not asked before the others are put right"));
        let location = data_checks::everywhere(&checks, data);
        return with_checks(unanswered(Verdict::CheckData, String::new(), Some(location)), checks, None);
    }
    let places: Vec<_> = parts.iter().map(|part| part.places.clone()).collect();
    progress("fitting the baseline".into());
    let no_likelihood = || no_likelihood(&problem);
    let first = fit_baseline(&problem).ok_or_else(no_likelihood)?;
    if data_checks::is_of_the_controller(recordings, &problem, &first) {
        return input_first();
    }
    if let Some(data) = between_rows::known_between(&problem, &first, progress) {
        progress("fitting again with the input as it was between the rows: what it moves comes later".into());
        return answered(&Asked { recordings, data: &data, model, catalogue, progress }, baseline);
    }
    if !data.has_command_news() && Loops::new(recordings, &problem, &first).closed() {
        let noise = sensor_noise(&problem, &first).ok_or_else(no_likelihood)?;
        if let Some(data) = data.with_command_news(noise) {
            progress("fitting again with what is new in the command: a controller makes it".into());
            return answered(&Asked { recordings, data: &data, model, catalogue, progress }, baseline);
        }
    }
    let information = Information::new(&problem, &first, &places).ok_or_else(no_likelihood)?;
    if let Some(reason) = excitation::too_weak(&problem, &first, &information) {
        checks.extend(data_checks::without_fit("too weak to ask"));
        return with_checks(unanswered(Verdict::NotExcited, reason, None), checks, balance.as_ref());
    }
    let selection = select(&problem, first, catalogue, &places, progress).ok_or_else(no_likelihood)?;
    let fitted = &selection.visited[selection.baseline];
    let richest = &selection.visited[selection.extended];
    progress("checking the data".into());
    let extended = &richest.fit;
    if data_checks::is_of_the_controller(recordings, &problem, extended)
        || data_checks::turns_cause_about(&problem, &fitted.fit, extended)
    {
        return input_first();
    }
    let loops = Loops::new(recordings, &problem, extended);
    if data_checks::is_the_controller_alone(&problem, extended, &loops) {
        let remedy = if recordings.iter().any(|recording| recording.theta_ref.is_some()) {
            "Log as fast as the controller runs, or excite the axis beside its set-point"
        } else {
            "Excite the axis, or move its set-point; and log as fast as the controller runs"
        };
        let reason = format!(
            "The data cannot tell: the loop is closed, and with the input first the motion still follows without any delay. That is the \
             controller's answer to the motion, not the craft's to the input, which moves too little by itself between two rows. {remedy}."
        );
        let told = estimates_of(&problem, extended);
        checks.extend(data_checks::of_fit(recordings, &problem, extended, told, dm_du, &loops));
        return with_checks(unanswered(Verdict::NotExcited, reason, None), checks, balance.as_ref());
    }
    let closed = loops.closed();
    let unknown = || {
        let unseen = || {
            excitation::input_unseen(&problem, &fitted.fit, &fitted.information).is_some()
                && !excitation::tells_a_second(&problem, extended)
        };
        excitation::gain_unknown(&problem, extended, &richest.information, closed)
            .filter(|_| closed || unseen())
    };
    let most = excitation::most_ahead(&problem, extended);
    let nothing = || excitation::nothing_follows(most?);
    let itself = || excitation::is_the_input(&problem, most?);
    if let Some(reason) = nothing().or_else(unknown).or_else(itself) {
        checks.extend(data_checks::without_fit("too weak to ask"));
        if closed {
            data_checks::tell_loop(&mut checks, &loops);
        }
        return with_checks(unanswered(Verdict::NotExcited, reason, None), checks, balance.as_ref());
    }
    let judgement = Judgement::new(&problem, &parts, selection, loops.any_closed_unsaid(), progress);
    let found = build(&judgement, notes());
    let answers = &judgement.selection.visited[judgement.place];
    let told = found.answer.told().parameters.clone();
    checks.extend(data_checks::of_fit(recordings, &problem, &answers.fit, told, dm_du, &loops));
    if data_checks::stop(&checks) {
        let location = data_checks::everywhere(&checks, data);
        return with_checks(unanswered(Verdict::CheckData, String::new(), Some(location)), checks, None);
    }
    let gain = || found.answer.told().parameters.iter().find(|p| p.name == "dM_du");
    let may_be_zero = data.input_changes() && gain().is_some_and(|gain| gain.ci95[0] * gain.ci95[1] <= 0.0);
    if found.answer.verdict == Verdict::NoMismatch && may_be_zero {
        let known = excitation::gain_unknown(&problem, &answers.fit, &answers.information, closed);
        let reason = known.unwrap_or_else(|| {
            "The data cannot tell: the interval of dM/du holds zero. Use a larger amplitude or a longer test.".into()
        });
        return with_checks(unanswered(Verdict::NotExcited, reason, None), checks, balance.as_ref());
    }
    let little = closed && !predicts(&found.answer);
    let undriven = !data.input_changes();
    let adrift = undriven && !tells_what_was_under_way(&judgement.rotation);
    if found.answer.verdict == Verdict::NoMismatch && (little || adrift || tells_nothing(&judgement.rotation))
    {
        let [why, remedy] = if undriven {
            ["the input never changes, and of parts of them that were held out", "Excite the vehicle"]
        } else if closed {
            [
                "the loop is closed, and",
                "Move the set-point, or put in a signal of your own behind the controller",
            ]
        } else {
            ["of parts of them that were held out", "Use a larger amplitude"]
        };
        let reason = format!(
            "The data cannot tell: {why} the model tells too little ({}) for it to say anything that nothing is missing from it. {remedy}.",
            figures(&found.answer, false)
        );
        return with_checks(unanswered(Verdict::NotExcited, reason, None), checks, balance.as_ref());
    }
    if closed || !predicts(&found.answer) {
        return with_checks(found, checks, balance.as_ref());
    }
    let tells = model.is_none() && found.answer.fit.predicted == Some(Predicted::Far);
    let lost = if tells { Balance::of_fit(&problem, &answers.fit, &answers.information) } else { None };
    with_checks(found, checks, lost.as_ref())
}

/// No physics is named, and no value of a fit is told: it would be taken for one.
fn unanswered(
    verdict: Verdict,
    summary: String,
    location: Option<Location>,
    notes: Vec<String>,
    known: ModelFile,
) -> Diagnosis {
    Diagnosis {
        answer: Answer {
            schema: "pitchid.diagnosis/1",
            verdict,
            summary,
            questions: Vec::new(),
            balance: None,
            effects: Vec::new(),
            in_model: Vec::new(),
            remainder: None,
            location,
            fit: FitAnswer::default(),
            next_experiment: None,
            data_checks: Vec::new(),
            per_unit_inertia: false,
            notes,
        },
        traces: Vec::new(),
        over_time: OverTime::default(),
        components: Vec::new(),
        left_over: None,
        spectra: Spectra::default(),
        steps: None,
        candidates: Vec::new(),
        model: known,
    }
}
