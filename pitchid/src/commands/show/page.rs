//! What is shown of a log, as one HTML file that needs nothing else.

use super::content::{Curve, Shown, ShownAxis, ShownFlight, ShownRecording, ShownTopic};
use crate::format::fixed;
use crate::logs::excitation::Span;
use crate::report::content::capitalised;
use benchmark::html::Document;
use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone, min_max_rows};
use maud::{Markup, PreEscaped, html};
use std::ops::Range;

/// Share of the points of a curve at either end of its range that may lie outside the picture, beyond so many times the range of
/// the others.
const SPARED: f64 = 0.03;
/// The same within the spans that move.
const SPARED_OF_MOTION: f64 = 0.005;
const ROOM: f64 = 1.0;
/// Points of each curve.
const POINTS: usize = 4000;
/// Width of a picture as a file, CSS pixels.
const FILE: u32 = 900;

const STYLE: &str = include_str!("page.css");

/// The page.
pub fn page(shown: &[Shown]) -> String {
    let title = match shown.first() {
        Some(Shown::Flight(flight)) => &flight.name,
        Some(Shown::Recording(recording)) => &recording.name,
        None => "nothing",
    };
    let body = html! {
        @for part in shown {
            @match part {
                Shown::Flight(shown) => (flight(shown)),
                Shown::Recording(shown) => (recording(shown)),
            }
        }
        footer { "pitchid " (env!("CARGO_PKG_VERSION")) ". Shaded: where input and rate move." }
    };
    Document { title: &format!("{title}: what is in it"), style: STYLE, body, json: None }.html(true)
}

fn flight(shown: &ShownFlight) -> Markup {
    html! {
        header {
            p .verdict { (shown.format) }
            h1 { (shown.name) }
            p {
                (shown.firmware.as_deref().unwrap_or("firmware unknown"))
                @if let Some(vehicle) = &shown.vehicle { ", " (vehicle) }
                (lasting(shown.time_s)) "."
            }
        }
        @for own in &shown.axes { (axis(own)) }
        h2 { "Topics" }
        div .table { table {
            thead { tr { th { "Topic" } th .n { "rows" } th .n { "Hz" } th .n { "gaps" } th .n { "from, s" } th .n { "to, s" } } }
            tbody { @for topic in &shown.topics { (row(topic)) } }
        } }
        (notes(&shown.notes))
    }
}

fn axis(shown: &ShownAxis) -> Markup {
    let (class, said) = if shown.can_serve { ("can", "can be asked") } else { ("cannot", "cannot serve") };
    html! {
        h2 { (capitalised(&shown.axis)) span class=(class) { (said) } }
        @if !(shown.hindrances.is_empty() && shown.cautions.is_empty()) {
            ul {
                @for line in &shown.hindrances { li { (line) } }
                @for line in &shown.cautions { li .soft { (line) } }
            }
        }
        @if !shown.settings.is_empty() {
            div .table { table {
                thead { tr { th { "Set before the next flight" } th { "to" } th { "now" } th { "which" } } }
                tbody { @for setting in &shown.settings { tr {
                    td { code { (setting.parameter) } }
                    td { (setting.value) }
                    td { (setting.now.map_or("–".into(), |now| format!("{}", (now * 1e6).round() / 1e6))) }
                    td { (setting.effect) }
                } } }
            } }
        }
        (figure(&shown.curves, &shown.excitation))
        @if !shown.channels.is_empty() {
            (spans(&shown.excitation))
            div .table { table {
                thead { tr { th { "Channel" } th { "of the log" } th .n { "Hz" } th { "why" } } }
                tbody { @for channel in &shown.channels { tr {
                    td { (channel.role) }
                    td { code { (channel.source) } }
                    td .n { (decimal(channel.rate_hz)) }
                    td { (channel.reason) }
                } } }
            } }
        }
    }
}

fn recording(shown: &ShownRecording) -> Markup {
    html! {
        header {
            p .verdict { (shown.format) @if let Some(axis) = &shown.axis { ", " (axis) } }
            h1 { (shown.name) }
            p {
                (shown.rows) " rows at " (format!("{:.1}", shown.rate_hz)) " Hz, "
                (shown.gaps) @if shown.gaps == 1 { " gap" } @else { " gaps" } (lasting(Some(shown.time_s))) "."
            }
        }
        (figure(&shown.curves, &shown.excitation))
        (spans(&shown.excitation))
        div .table { table {
            thead { tr { th { "Column" } th { "of the file" } } }
            tbody { @for [column, source] in &shown.columns { tr { td { code { (column) } } td { code { (source) } } } } }
        } }
        (notes(&shown.notes))
    }
}

fn lasting(time_s: Option<[f64; 2]>) -> String {
    time_s.map_or(String::new(), |[from, to]| {
        format!("; {:.1} s, from {} to {} s of its clock", to - from, fixed(from, 3), fixed(to, 3))
    })
}

fn figure(curves: &[Curve], excitation: &[Span]) -> Markup {
    html! { @if let Some(chart) = picture(curves, excitation) { figure { (PreEscaped(chart.html())) } } }
}

/// One picture as a file: of what moves longest. `None` where there is nothing to draw.
pub fn plot(shown: &[Shown]) -> Option<String> {
    let mut all: Vec<(&[Curve], &[Span])> = Vec::new();
    for part in shown {
        match part {
            Shown::Flight(flight) => {
                all.extend(flight.axes.iter().map(|a| (&a.curves[..], &a.excitation[..])));
            }
            Shown::Recording(recording) => all.push((&recording.curves, &recording.excitation)),
        }
    }
    let moving = |spans: &[Span]| spans.iter().map(|span| span.time_s[1] - span.time_s[0]).sum::<f64>();
    all.sort_by(|(_, a), (_, b)| moving(b).total_cmp(&moving(a)));
    all.into_iter().find_map(|(curves, spans)| picture(curves, spans)).map(|chart| chart.file(FILE))
}

fn row(topic: &ShownTopic) -> Markup {
    let [from, to] = topic.time_s;
    html! {
        tr {
            td { code { (topic.name) } }
            td .n { (topic.rows) }
            td .n { (decimal(topic.rate_hz)) }
            td .n { (topic.gaps) }
            td .n { (fixed(from, 1)) }
            td .n { (fixed(to, 1)) }
        }
    }
}

fn spans(all: &[Span]) -> Markup {
    html! {
        @if all.is_empty() { p { "The input moves nowhere long enough." } } @else {
            div .table { table {
                thead { tr {
                    th { "Where it moves, s" }
                    th .n { "input, std" }
                    th .n { "rate, std, rad/s" }
                    th .n { "80 % of the input's power, rad/s" }
                } }
                tbody { @for span in all { tr {
                    td { (fixed(span.time_s[0], 1)) " to " (fixed(span.time_s[1], 1)) }
                    td .n { (format!("{:.4}", span.input_deviation)) }
                    td .n { (span.rate_deviation.map_or("–".into(), |rate| format!("{rate:.3}"))) }
                    td .n { (span.band_rad_s.map_or("–".into(), |[low, high]| format!("{low:.1} to {high:.1}"))) }
                } } }
            } }
        }
    }
}

fn notes(notes: &[String]) -> Markup {
    html! { @if !notes.is_empty() { h2 { "Notes" } ul { @for note in notes { li { (note) } } } } }
}

/// One decimal, where there is a value.
fn decimal(value: Option<f64>) -> String {
    value.map_or("–".into(), |value| format!("{value:.1}"))
}

/// Input, rate with its set-point, angle; shaded where input and rate move.
fn picture(curves: &[Curve], excitation: &[Span]) -> Option<Chart> {
    let times = || curves.iter().filter_map(|c| Some([*c.series.time_s.first()?, *c.series.time_s.last()?]));
    let from = times().map(|[from, _]| from).fold(f64::INFINITY, f64::min);
    let to = times().map(|[_, to]| to).fold(f64::NEG_INFINITY, f64::max);
    if from >= to || !(to - from).is_finite() {
        return None;
    }
    let windows: Vec<[f64; 2]> = excitation.iter().map(|span| span.time_s).collect();
    // the last on top
    let panels: [&[(&str, Tone)]; 3] = [
        &[("input", Tone::After)],
        &[("set-point", Tone::Before), ("rate", Tone::Measured)],
        &[("angle", Tone::Third)],
    ];
    let drawn = panels.iter().filter_map(|panel| {
        let own: Vec<(&Curve, Tone)> = panel
            .iter()
            .filter_map(|(role, tone)| Some((curves.iter().find(|curve| curve.role == *role)?, *tone)))
            .collect();
        (!own.is_empty()).then(|| panel_of(&own, &windows))
    });
    let panels: Vec<Panel> = drawn.collect();
    let label = "input, rate and angle over time".to_owned();
    (!panels.is_empty()).then(|| Chart { label, x: Axis::linear("time, s", from..to), panels, windows })
}

fn panel_of(curves: &[(&Curve, Tone)], windows: &[[f64; 2]]) -> Panel {
    let range = shown_range(curves, windows);
    let is_cut =
        |curve: &Curve| curve.series.values.iter().any(|value| !(range.start..=range.end).contains(value));
    let name = |curve: &Curve| {
        if is_cut(curve) { format!("{} (cut off at the edges)", curve.role) } else { curve.role.to_owned() }
    };
    let drawn = |(curve, tone): &(&Curve, Tone)| {
        let series = &curve.series;
        let rows = min_max_rows(&series.values, POINTS);
        let line = rows.iter().filter(|&&k| k < series.time_s.len());
        let line = line.map(|&k| [series.time_s[k], series.values[k]]).collect();
        Series::new(name(curve), *tone, Shape::Lines(vec![line]))
    };
    let (first, _) = curves[curves.len() - 1];
    let unit = if first.unit.is_empty() { "no unit" } else { first.unit };
    Panel {
        height: 110,
        y: Axis::linear(format!("{}, {unit}", first.role), range.clone()),
        series: curves.iter().map(drawn).collect(),
    }
}

/// Where nearly all values lie, those in `windows` and the others: a crash at the end of a flight must not hide the flight, nor
/// a long hover the test.
fn shown_range(curves: &[(&Curve, Tone)], windows: &[[f64; 2]]) -> Range<f64> {
    let values = |wanted: &dyn Fn(f64) -> bool| -> Vec<f64> {
        let rows = curves.iter().flat_map(|(curve, _)| curve.series.time_s.iter().zip(&curve.series.values));
        rows.filter(|(t, _)| wanted(**t)).map(|(_, value)| *value).collect()
    };
    let within = |t: f64| windows.iter().any(|[from, to]| (*from..=*to).contains(&t));
    let [inside, all] = [usual(values(&within), SPARED_OF_MOTION), usual(values(&|_| true), SPARED)];
    if windows.is_empty() { all } else { inside.start.min(all.start)..inside.end.max(all.end) }
}

/// Where all values but a share of `spared` at either end lie, with room beside.
fn usual(mut values: Vec<f64>, spared: f64) -> Range<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or_default();
    let [low, high] = [at(spared), at(1.0 - spared)];
    let room = ROOM * (high - low);
    padded(values.iter().map(|value| value.clamp(low - room, high + room)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::show::content::of_recording;
    use sysid::recording::{ReadOptions, parse};

    #[test]
    fn a_spike_does_not_hide_what_was_before() {
        let flight = (0..1000).map(|k| if k > 990 { 500.0 } else { f64::from(k).sin() });
        let range = usual(flight.collect(), SPARED);
        assert!(range.end < 6.0 && range.start < -0.9, "{range:?}");
        assert!(usual(Vec::new(), SPARED).end > usual(Vec::new(), SPARED).start);
    }

    #[test]
    fn a_recording_is_drawn_with_the_spans_that_move() {
        let mut text = "t_s,u_rad,q_rad_s\n".to_owned();
        for k in 0..3000 {
            let t = 0.02 * f64::from(k);
            let moves = if (20.0..40.0).contains(&t) { 1.0 } else { 0.0 };
            text += &format!("{t:.2},{:.5},{:.5}\n", moves * (5.0 * t).sin(), moves * (5.0 * t).cos());
        }
        let recording = parse("a & b.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let page = page(&[Shown::Recording(of_recording(&recording, None))]);
        assert_eq!(page.matches("class=\"plot\"").count(), 2, "input and rate");
        assert_eq!(page.matches("class=\"window\"").count(), 2, "one span in each");
        assert!(page.contains("a &amp; b.csv") && !page.contains("http:"), "nothing is fetched");
    }
}
