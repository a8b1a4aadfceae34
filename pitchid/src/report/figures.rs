//! The pictures of a report, on the page and as files.

use super::content::{Content, is_everywhere, symbol};
use super::traces::View;
use super::{Report, component, correlations, dependence, map, over_time, recorded, spectrum, step};
use chart::Chart;
use maud::{Markup, PreEscaped, html};
use sysid::diagnosis::answer::{Answer, Dependence};
use sysid::diagnosis::component::Component;
use sysid::diagnosis::over_time::{OverTime, ResidualMoment};
use sysid::diagnosis::traces::Trace;
use sysid::recording::Recording;

/// Sections drawn besides the first that was held out; a report of more would be too long to read.
pub const MOST_SECTIONS: usize = 16;
/// Recordings that are drawn.
const MOST_RECORDINGS: usize = 4;
/// Width of a picture over time as a file, and of one of two that stand side by side, CSS pixels.
const WIDE: u32 = 900;
const HALF: u32 = 440;

/// A picture with its caption.
pub struct Figure {
    /// Name of its file.
    pub name: String,
    /// Its width as a file, CSS pixels.
    pub width: u32,
    /// What it shows.
    pub caption: String,
    /// The picture.
    pub chart: Chart,
}

impl Figure {
    fn new(name: impl Into<String>, width: u32, caption: impl Into<String>, chart: Chart) -> Self {
        Self { name: name.into(), width, caption: caption.into(), chart }
    }

    /// On a page.
    pub fn html(&self) -> Markup {
        html! { figure { (PreEscaped(self.chart.html())) figcaption { (self.caption) } } }
    }
}

/// All pictures of a report, by where they stand.
#[derive(Default)]
pub struct Figures {
    /// The recordings, where nothing is simulated beside them.
    pub recorded: Vec<Figure>,
    /// The section that shows most, and the others.
    pub first: Option<Figure>,
    pub others: Vec<Figure>,
    /// What the data say of each term that is missing.
    pub terms: Vec<Figure>,
    /// Where the model differs.
    pub maps: Vec<Figure>,
    pub dependence: Option<Figure>,
    pub moments: Vec<Figure>,
    /// How the models answer.
    pub step: Option<Figure>,
    pub response: Option<Figure>,
    /// What is left: terms that are no finding, and what no term has.
    pub left: Vec<Figure>,
    pub spectrum: Option<Figure>,
    pub correlations: Option<Figure>,
}

impl Figures {
    /// Draws them.
    pub fn new(report: &Report<'_>) -> Self {
        let (found, answer) = (report.found, &report.content.answer);
        let changed = is_changed(answer);
        let unit = found.traces.first().map_or("rad/s", |trace| trace.unit);
        let input_unit = report.recordings.first().map_or("unit", |recording| recording.u_unit.symbol());
        let (first, others) = sections(report);
        let recordings = report.recordings.iter().take(MOST_RECORDINGS).enumerate();
        let recorded = |(index, recording): (usize, &Recording)| {
            let windows = answer.location.as_ref().map_or(&[][..], |l| &l.time_s);
            let caption = format!("What {} holds.", recording.name);
            let windows = if windows_say_something(windows, recording) { windows } else { &[] };
            Figure::new(
                format!("recording-{}.svg", index + 1),
                WIDE,
                caption,
                recorded::picture(recording, windows),
            )
        };
        let whole = if changed { "The models" } else { "The model" };
        let [terms, left] = [false, true].map(|left| terms(&found.components, left));
        let step_figure = |steps| {
            let caption = format!(
                "{whole} after a step of the input by {}, with 95 % intervals of the parameters.",
                crate::format::in_unit(found.steps.as_ref().map_or(0.0, |s| s.size), input_unit),
            );
            Figure::new("step.svg", HALF, caption, step::picture(steps, unit))
        };
        Self {
            recorded: if first.is_none() { recordings.map(recorded).collect() } else { Vec::new() },
            first,
            others,
            maps: maps(report),
            // beside a term it would show again, in the residual of a model that has adapted to it, what the term's picture shows as it is
            dependence: found.components.is_empty().then(|| strongest(answer).map(of_dependence)).flatten(),
            terms,
            left,
            moments: moments(report.content, &found.traces, &found.over_time),
            step: found.steps.as_ref().map(step_figure),
            response: spectrum::response(&found.traces, input_unit, changed).map(|chart| {
                let caption = format!(
                    "Response to the input at the size of the test: of the data without a model, and of {} run along the same input. In a \
                     closed loop the data lean towards the inverse of the controller.",
                    whole.to_lowercase()
                );
                Figure::new("response.svg", HALF, caption, chart)
            }),
            spectrum: spectrum::picture(&found.spectra, unit, changed).map(|chart| {
                let caption = "How strong the motion is at each frequency, what the free runs leave of it, and what the disturbance and noise \
                               of the model would leave if nothing were missing.";
                Figure::new("spectra.svg", HALF, caption, chart)
            }),
            correlations: found.left_over.as_ref().map(|left| {
                let caption = "What is left of predictions one step ahead: a right model leaves nothing that depends on what was left before \
                               or on the input. The band is left by chance at any lag in one case of a hundred.";
                Figure::new("correlations.svg", HALF, caption, correlations::picture(left))
            }),
        }
    }

    /// All of them, in the order of the page.
    pub fn all(self) -> impl Iterator<Item = Figure> {
        let all =
            self.recorded.into_iter().chain(self.first).chain(self.others).chain(self.terms).chain(self.left);
        let all = all
            .chain(self.maps)
            .chain(self.dependence)
            .chain(self.moments)
            .chain(self.step)
            .chain(self.response);
        all.chain(self.spectrum).chain(self.correlations)
    }
}

/// Whether windows are less than the whole recording.
fn windows_say_something(windows: &[[f64; 2]], recording: &Recording) -> bool {
    let whole = recording.t.last().copied().unwrap_or(0.0) - recording.t.first().copied().unwrap_or(0.0);
    windows.iter().map(|[from, to]| to - from).sum::<f64>() < 0.9 * whole
}

/// What the data say of each term that is missing, or of each that is told as what is left; a second one of the same effect is numbered.
fn terms(components: &[Component], left: bool) -> Vec<Figure> {
    let figure = |(index, component): (usize, &Component)| {
        let id = component.about.id;
        let earlier = components[..index].iter().filter(|c| c.about.id == id).count();
        let again = if earlier > 0 { format!("-{}", earlier + 1) } else { String::new() };
        let caption = format!("{}.", component::caption(component));
        Figure::new(format!("term-{id}{again}.svg"), HALF, caption, component::picture(component))
    };
    components.iter().enumerate().filter(|(_, component)| component.left == left).map(figure).collect()
}

/// Time and frequency of what is left, recording by recording.
fn maps(report: &Report<'_>) -> Vec<Figure> {
    let maps = &report.found.spectra.maps;
    let mut recordings: Vec<usize> = maps.iter().flatten().map(|cell| cell.recording).collect();
    recordings.sort_unstable();
    recordings.dedup();
    let several = recordings.len() > 1;
    let figure = |&recording: &usize| {
        let of = if several { format!(" of recording {}", recording + 1) } else { String::new() };
        let windows = marked_windows(&report.content.answer, &report.found.traces);
        let shaded = if windows.is_empty() { "" } else { "; shaded: when the model differs" };
        let caption = format!(
            "Where and when the free runs{of} leave more than disturbance and noise would: coloured from what chance leaves in one cell of a \
             hundred, darkest at thirty times the background{shaded}."
        );
        let chart = map::picture(maps, recording, is_changed(&report.content.answer), windows);
        Figure::new(format!("map-{}.svg", recording + 1), WIDE, caption, chart)
    };
    recordings.iter().take(MOST_RECORDINGS).map(figure).collect()
}

/// The signal that the residual moment depends on most.
fn strongest(answer: &Answer) -> Option<&Dependence> {
    answer.location.as_ref()?.dependence.first()
}

/// The residual moment against a signal.
fn of_dependence(dependence: &Dependence) -> Figure {
    let signal = symbol(&dependence.variable);
    let caption = format!(
        "Moment that the model before cannot explain: means by class of {signal}, with 95 % intervals."
    );
    Figure::new("dependence.svg", HALF, caption, dependence::picture(dependence))
}

/// The section that shows most, large, and the others.
fn sections(report: &Report<'_>) -> (Option<Figure>, Vec<Figure>) {
    let (content, traces) = (report.content, &report.found.traces);
    let Some(first) = headline_trace(traces) else { return (None, Vec::new()) };
    let windows = marked_windows(&content.answer, traces);
    let view = |trace: &'_ Trace| -> Chart {
        let recording = report.recordings.get(trace.recording);
        let view = View { trace, recording, changed: is_changed(&content.answer), windows: &windows };
        if trace.label == first.label { view.large() } else { view.small() }
    };
    let large = Figure::new("section-1.svg", WIDE, caption(content, first), view(first));
    let others = traces.iter().filter(|t| t.label != first.label).take(MOST_SECTIONS).enumerate();
    let others = others
        .map(|(k, t)| Figure::new(format!("section-{}.svg", k + 2), WIDE, caption(content, t), view(t)));
    (Some(large), others.collect())
}

/// The residual moment over time, recording by recording, where the time says something.
pub fn moments(content: &Content, traces: &[Trace], over_time: &OverTime) -> Vec<Figure> {
    let windows = marked_windows(&content.answer, traces);
    if windows.is_empty() && !over_time.of_time {
        return Vec::new();
    }
    let count = over_time.runs.iter().map(|run| run.recording + 1).max().unwrap_or(0);
    let figure = |recording: usize| {
        let runs: Vec<&ResidualMoment> =
            over_time.runs.iter().filter(|run| run.recording == recording).collect();
        let of = if count > 1 { format!(", recording {}", recording + 1) } else { String::new() };
        let shaded = if windows.is_empty() { "" } else { "; shaded: when the model differs" };
        let caption = format!("Moment that the model cannot explain over time{of}{shaded}.");
        Figure::new(
            format!("moment-{}.svg", recording + 1),
            WIDE,
            caption,
            over_time::picture(&runs, &windows),
        )
    };
    (0..count.min(MOST_RECORDINGS)).map(figure).collect()
}

/// The section in which the model after gains most on the one before; the last, which is the closed loop where a test has one,
/// where nothing is gained.
pub fn headline_trace(traces: &[Trace]) -> Option<&Trace> {
    let left = |trace: &Trace, simulated: &[f64]| -> f64 {
        trace.measured.iter().zip(simulated).map(|(m, s)| (m - s).powi(2)).sum()
    };
    let gain = |trace: &Trace| {
        let whole: f64 = trace.measured.iter().map(|m| m * m).sum();
        (left(trace, &trace.baseline).min(whole) - left(trace, &trace.extended).min(whole)) / whole
    };
    let most = traces.iter().map(|trace| (trace, gain(trace))).filter(|(_, gain)| *gain > 0.0);
    most.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(trace, _)| trace).or(traces.last())
}

/// Whether anything was added to the model.
pub fn is_changed(answer: &Answer) -> bool {
    !answer.effects.is_empty()
}

fn caption(content: &Content, trace: &Trace) -> String {
    let row = content.fit.iter().find(|row| row.section == trace.label);
    let vaf = match row {
        Some(row) if is_changed(&content.answer) => format!(" VAF {} % → {} %.", row.baseline, row.extended),
        Some(row) => format!(" VAF {} %.", row.baseline),
        None => String::new(),
    };
    format!("Section {}, held out: the models were selected and fitted without it.{vaf}", trace.label)
}

/// The windows of the answer, unless they are nearly everything.
pub fn marked_windows(answer: &Answer, traces: &[Trace]) -> Vec<[f64; 2]> {
    let windows = answer.location.as_ref().map_or(&[][..], |l| &l.time_s);
    if is_everywhere(windows, traces) { Vec::new() } else { windows.to_vec() }
}
