//! The report: one HTML file that needs nothing else, readable in light and dark and on paper.

mod component;
pub mod content;
mod dependence;
mod over_time;
pub mod traces;

use crate::failure::Failure;
use benchmark::page::STYLE;
use chart::Chart;
use content::{Content, is_everywhere, symbol};
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;
use sysid::diagnosis::answer::{Answer, Dependence};
use sysid::diagnosis::component::Component;
use sysid::diagnosis::over_time::{OverTime, ResidualMoment};
use sysid::diagnosis::traces::Trace;
use sysid::estimate::per_inertia;
use traces::View;

/// Sections drawn besides the first that was held out; a report of more would be too long to read.
const MOST_SECTIONS: usize = 16;
/// Recordings whose residual moment is drawn over time.
const MOST_RECORDINGS: usize = 4;
/// Width of a picture over time as a file, and of one of two that stand side by side, CSS pixels.
const WIDE: u32 = 900;
const HALF: u32 = 440;

/// A picture with its caption.
struct Figure {
    caption: String,
    chart: Chart,
}

/// The same, ready for the page.
#[derive(Serialize)]
struct Drawn {
    caption: String,
    svg: String,
}

impl Figure {
    fn on_page(self) -> Drawn {
        Drawn { caption: self.caption, svg: self.chart.html() }
    }
}

/// What the template is given.
#[derive(Serialize)]
struct Page<'a> {
    content: &'a Content,
    first: Option<Drawn>,
    others: Vec<Drawn>,
    /// Number of sections that are in the table only.
    undrawn: usize,
    components: Vec<Drawn>,
    dependence: Option<Drawn>,
    over_time: Vec<Drawn>,
    style: &'static str,
    chart_style: &'static str,
    script: &'static str,
    json: String,
}

/// The pictures of the report as files of their own, for light and dark pages: name and SVG.
pub fn pictures(
    content: &Content,
    traces: &[Trace],
    over_time: &OverTime,
    components: &[Component],
) -> Vec<(String, String)> {
    let answer = &content.answer;
    let mut pictures = Vec::new();
    let mut put = |name: String, width: u32, figure: Figure| pictures.push((name, figure.chart.file(width)));
    let (first, others) = figures(content, traces);
    for (index, figure) in first.into_iter().chain(others).enumerate() {
        put(format!("section-{}.svg", index + 1), WIDE, figure);
    }
    for (index, component) in components.iter().enumerate() {
        let id = component.about.id;
        let earlier = components[..index].iter().filter(|c| c.about.id == id).count();
        let again = if earlier > 0 { format!("-{}", earlier + 1) } else { String::new() };
        put(format!("term-{id}{again}.svg"), HALF, of_term(component));
    }
    if let Some(dependence) = answer.location.as_ref().and_then(|l| l.dependence.first()) {
        put("dependence.svg".into(), HALF, drawn(dependence));
    }
    for (index, figure) in moments(content, traces, over_time).into_iter().enumerate() {
        put(format!("moment-{}.svg", index + 1), WIDE, figure);
    }
    if answer.per_unit_inertia {
        pictures.iter_mut().for_each(|(_, svg)| *svg = per_inertia(svg));
    }
    pictures
}

/// Renders the report.
///
/// # Errors
/// A page that could not be made.
pub fn html(
    content: &Content,
    traces: &[Trace],
    over_time: &OverTime,
    components: &[Component],
) -> Result<String, Failure> {
    let answer = &content.answer;
    let (first, others) = figures(content, traces);
    let dependence = answer.location.as_ref().and_then(|l| l.dependence.first());
    let page = Page {
        content,
        first: first.map(Figure::on_page),
        others: on_page(others),
        undrawn: traces.len().saturating_sub(MOST_SECTIONS + 1),
        components: on_page(components.iter().map(of_term)),
        dependence: dependence.map(|d| drawn(d).on_page()),
        over_time: on_page(moments(content, traces, over_time)),
        style: STYLE,
        chart_style: chart::STYLE,
        script: chart::SCRIPT,
        json: embedded_json(content)?,
    };
    let page = rendered(include_str!("report.html"), page)?;
    Ok(if answer.per_unit_inertia { per_inertia(&page) } else { page })
}

/// A template filled with `page`.
///
/// # Errors
/// A page that does not fit the template.
pub fn rendered(template: &str, page: impl Serialize) -> Result<String, Failure> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment
        .render_str(template, Serde(page))
        .map_err(|error| Failure::new(format!("the report could not be made: {error}"), "leave out --report"))
}

fn on_page(figures: impl IntoIterator<Item = Figure>) -> Vec<Drawn> {
    figures.into_iter().map(Figure::on_page).collect()
}

/// What the data say of a term.
fn of_term(component: &Component) -> Figure {
    Figure { caption: component::caption(component), chart: component::picture(component) }
}

/// The residual moment against a signal.
fn drawn(dependence: &Dependence) -> Figure {
    let signal = symbol(&dependence.variable);
    let caption = format!(
        "Moment that the model before cannot explain: means by class of {signal}, with 95 % intervals"
    );
    Figure { caption, chart: dependence::picture(dependence) }
}

/// The section that shows most, large, and the others.
fn figures(content: &Content, traces: &[Trace]) -> (Option<Figure>, Vec<Figure>) {
    let Some(first) = headline_trace(traces) else { return (None, Vec::new()) };
    let windows = marked_windows(&content.answer, traces);
    let view = |trace| View { trace, changed: is_changed(&content.answer), windows: &windows };
    let caption = |trace: &Trace| caption(content, trace);
    let large = Figure { caption: caption(first), chart: view(first).large() };
    let others = traces.iter().filter(|t| t.label != first.label).take(MOST_SECTIONS);
    let others = others.map(|t| Figure { caption: caption(t), chart: view(t).small() });
    (Some(large), others.collect())
}

/// The residual moment over time, recording by recording, where the time says something.
fn moments(content: &Content, traces: &[Trace], over_time: &OverTime) -> Vec<Figure> {
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
        let caption = format!("Moment that the model cannot explain over time{of}{shaded}");
        Figure { caption, chart: over_time::picture(&runs, &windows) }
    };
    (0..count.min(MOST_RECORDINGS)).map(figure).collect()
}

/// The last section: the closed loop, where a test has one.
pub fn headline_trace(traces: &[Trace]) -> Option<&Trace> {
    traces.last()
}

/// Whether anything was added to the model.
pub fn is_changed(answer: &Answer) -> bool {
    !answer.effects.is_empty()
}

fn caption(content: &Content, trace: &Trace) -> String {
    let row = content.fit.iter().find(|row| row.section == trace.label);
    let vaf = match row {
        Some(row) if is_changed(&content.answer) => format!(". VAF {} % → {} %", row.baseline, row.extended),
        Some(row) => format!(". VAF {} %", row.baseline),
        None => String::new(),
    };
    format!("Section {}, held out: the models were selected and fitted without it{vaf}", trace.label)
}

/// The windows of the answer, unless they are nearly everything.
fn marked_windows(answer: &Answer, traces: &[Trace]) -> Vec<[f64; 2]> {
    let windows = answer.location.as_ref().map_or(&[][..], |l| &l.time_s);
    if is_everywhere(windows, traces) { Vec::new() } else { windows.to_vec() }
}

/// JSON that may stand inside a script element: no text in it can end the element.
fn embedded_json(content: &Content) -> Result<String, Failure> {
    let text = serde_json::to_string(content).map_err(|e| {
        Failure::new(format!("the report's JSON could not be made: {e}"), "leave out --report")
    })?;
    Ok(text.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026"))
}

#[cfg(test)]
pub mod fixture;
#[cfg(test)]
mod tests;
