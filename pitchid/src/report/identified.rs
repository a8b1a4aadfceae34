//! The page of an identification: every method on data that it has not seen, responses, parameters.

use super::repeat::Repeat;
use crate::format;
use benchmark::html::Document;
use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use maud::{Markup, PreEscaped, html};
use std::f64::consts::LOG10_E;
use sysid::estimate::Estimate;
use sysid::identify::compare::Identification;
use sysid::recording::Recording;

const STYLE: &str = include_str!("report.css");
/// Two-sided 95 % of a normal distribution, in standard errors.
const NORMAL_95: f64 = 1.96;
/// Colours of the methods' curves, in their order.
const TONES: [Tone; 5] = [Tone::After, Tone::Before, Tone::Third, Tone::Fourth, Tone::Ink];

/// The file.
pub fn page(found: &Identification, recordings: &[Recording], repeat: &Repeat) -> String {
    let names: Vec<&str> = recordings.iter().map(|recording| recording.name.as_str()).collect();
    let best = found.methods.iter().filter_map(|method| {
        let held = found.held_out.iter().filter_map(|section| method.vaf_percent.get(section));
        held.copied().reduce(f64::min).map(|vaf| (method, vaf))
    });
    let best = best.max_by(|a, b| a.1.total_cmp(&b.1));
    let headline = match &best {
        Some((method, vaf)) => {
            format!("{} predicts what it has not seen with a VAF of {vaf:.1} % or more", method.name)
        }
        None => "Nothing was held out to judge a model by".to_owned(),
    };
    let body = html! {
        header style="--tone: var(--found)" {
            p .verdict { "identification" }
            h1 { (super::content::capitalised(&headline)) }
            p { "Fitted on " (found.training.join(", ")) "; held out " (found.held_out.join(", ")) "." }
        }
        @if !found.cautions.is_empty() {
            h2 { "Not the plant's values yet" }
            ul { @for caution in &found.cautions { li { (caution) } } }
        }
        (methods(found))
        @if let Some(chart) = responses(found, recordings) {
            h2 { "Response to the input over frequency" }
            figure {
                (PreEscaped(chart.html()))
                figcaption {
                    "The data without a model, with 95 % intervals, and every linear model. In a closed loop the data lean towards the inverse \
                     of the controller."
                }
            }
        }
        (parameters("Parameters of the grey box", &found.parameters))
        @if found.parameters_coloured != found.parameters {
            (parameters("The same, with the colour of the errors modelled", &found.parameters_coloured))
        }
        @if let Some(hinf) = &found.hinf {
            (parameters("The same, matched to the PI-MOESP model", &hinf.parameters))
        }
        @if !found.notes.is_empty() {
            h2 { "Noticed in the recordings" }
            ul { @for note in &found.notes { li { (note) } } }
        }
        (repeat.html())
        footer { (names.join(", ")) ". pitchid " (env!("CARGO_PKG_VERSION")) "." }
    };
    Document { title: &headline, style: STYLE, body, json: None }.html(true)
}

fn methods(found: &Identification) -> Markup {
    html! {
        h2 { "Every method on data that it has not seen" }
        div .table { table .figures {
            thead { tr {
                th { "Method" }
                @for section in &found.held_out { th .n { (section) ", VAF %" } }
            } }
            tbody {
                @for method in &found.methods { tr {
                    td {
                        (method.name) span .small { ", " (method.detail) }
                        @if !method.remark.is_empty() { span .soft.small.block { (method.remark) } }
                    }
                    @for section in &found.held_out {
                        td .n { (method.vaf_percent.get(section).map_or("–".into(), |vaf| format::percent(*vaf))) }
                    }
                } }
                tr {
                    td .soft { "ceiling" }
                    @for section in &found.held_out {
                        td .n.soft {
                            (found.ceiling_vaf_percent.get(section).map_or("–".into(), |vaf| format::percent(*vaf)))
                        }
                    }
                }
            }
        } }
        p .soft.small {
            "VAF = 100·max(0, 1 − var(y − ŷ)/var(y)), simulated freely. Ceiling: what a model without structure reaches that was fitted to \
             that very section."
        }
    }
}

/// Gain and phase of the data and of every linear model.
pub fn responses(found: &Identification, recordings: &[Recording]) -> Option<Chart> {
    let step = recordings.first()?.step;
    let lines = &found.response;
    let [first, last] = [lines.first()?.omega_rad_s, lines.last()?.omega_rad_s];
    let models = found.methods.iter().filter_map(|method| Some((method, method.model.as_ref()?)));
    let curves: Vec<(String, Tone, Vec<[f64; 3]>)> = models
        .zip(TONES)
        .map(|((method, model), tone)| {
            let mut turned = 0.0;
            let mut before: Option<f64> = None;
            let points = lines.iter().filter_map(|line| {
                let response = model.frequency_response(line.omega_rad_s, step)?;
                let mut phase = response.arg() + turned;
                if let Some(before) = before {
                    let turns = ((phase - before) / std::f64::consts::TAU).round() * std::f64::consts::TAU;
                    (phase, turned) = (phase - turns, turned - turns);
                }
                before = Some(phase);
                Some([line.omega_rad_s.log10(), response.norm().log10(), phase.to_degrees()])
            });
            (method.name.clone(), tone, points.collect())
        })
        .collect();
    let gain: Vec<[f64; 3]> = lines
        .iter()
        .map(|line| [line.omega_rad_s.log10(), line.gain.log10(), NORMAL_95 * line.deviation * LOG10_E])
        .collect();
    let coherence = lines.iter().map(|line| [line.omega_rad_s.log10(), line.coherence]).collect();
    let of = |column: usize| -> Vec<Series> {
        let line =
            |points: &[[f64; 3]]| Shape::Lines(vec![points.iter().map(|p| [p[0], p[column]]).collect()]);
        curves.iter().map(|(name, tone, points)| Series::new(name.clone(), *tone, line(points))).collect()
    };
    let range = padded(gain.iter().flat_map(|[_, g, half]| [g - half.min(1.0), g + half.min(1.0)]));
    let phases = padded(curves.iter().flat_map(|(.., points)| points.iter().map(|p| p[2])));
    let mut of_gain = vec![Series::new("data, 95 %", Tone::Measured, Shape::Dots(gain))];
    of_gain.extend(of(1));
    let unit = recordings.first()?.u_unit.symbol();
    let mut panels = vec![
        Panel {
            height: 190,
            y: Axis::logarithmic(format!("gain, rad/s per {unit}"), range),
            series: of_gain,
        },
        Panel {
            height: 80,
            y: Axis::linear("coherence", 0.0..1.05),
            series: vec![Series::new("data, 95 %", Tone::Measured, Shape::Lines(vec![coherence]))],
        },
    ];
    if !curves.is_empty() {
        panels.insert(1, Panel { height: 130, y: Axis::linear("phase, degrees", phases), series: of(2) });
    }
    Some(Chart {
        label: "response of data and models over frequency".into(),
        x: Axis::logarithmic("frequency, rad/s", first.log10()..last.log10()),
        panels,
        windows: Vec::new(),
    })
}

fn parameters(title: &str, estimates: &[Estimate]) -> Markup {
    html! {
        @if !estimates.is_empty() {
            h2 { (title) }
            div .table { table .figures {
                thead { tr { th { "Parameter" } th .n { "estimated, 95 %" } } }
                tbody { @for estimate in estimates { tr {
                    @let shown = format::estimate(estimate);
                    td {
                        code { (estimate.name) }
                        @if !format::unit(&estimate.unit).is_empty() { span .small { ", " (format::unit(&estimate.unit)) } }
                        span .soft.small.block { (super::content::plant_meaning(&estimate.name)) }
                    }
                    td .n { (shown.value) span .ci { (shown.interval) } }
                } } }
            } }
        }
    }
}
