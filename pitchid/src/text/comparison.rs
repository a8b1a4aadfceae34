//! A comparison of two recordings as it stands on a terminal.

use super::{heading, notes, paragraph, table};
use crate::format::{self, Shown};
use chart::ticks::padded;
use chart::{Chart, Panel, Series, Shape, Tone};
use flight_logs::axes::Axis;
use serde::Serialize;
use sysid::compare::statistics::{Difference, Verdict};
use sysid::compare::{Change, Comparison, Quantity};
use sysid::estimate::Estimate;

/// The answer for one axis.
#[derive(Serialize)]
pub struct AxisAnswer {
    /// roll, pitch, yaw; pitch where the recording names none.
    axis: String,
    /// What changed, in words.
    summary: String,
    #[serde(flatten)]
    comparison: Comparison,
}

impl AxisAnswer {
    /// Puts `comparison` in words.
    pub fn new(axis: Option<Axis>, comparison: Comparison) -> Self {
        let summary = summary(axis, &comparison);
        Self { axis: axis.unwrap_or(Axis::Pitch).to_string(), summary, comparison }
    }
}

/// All axes.
pub fn text(answers: &[AxisAnswer]) -> String {
    let mut text = String::new();
    let mut told: Vec<String> = Vec::new();
    for answer in answers {
        let comparison = &answer.comparison;
        if !text.is_empty() {
            text.push('\n');
        }
        text.push_str(&paragraph(&format!("{}: {}", answer.axis.to_uppercase(), answer.summary)));
        let rows = comparison.changes.iter().map(|change| {
            let [before, after, difference] = [&change.before, &change.after, &change.difference].map(both);
            let unit = format::unit(&change.before.unit);
            vec![
                word(change.quantity).to_owned(),
                unit.to_owned(),
                before,
                after,
                difference,
                format!("{:.1}", change.judged.z),
                format!("{:.2}", change.judged.probability),
                verdict(&change.judged).to_owned(),
            ]
        });
        let header = ["", "unit", "before", "after", "difference", "z", "P(changed)", ""];
        text.push_str(&heading(&format!(
            "{:.1} s before, {:.1} s after; ± is the half-width of a 95 % interval",
            comparison.seconds[0], comparison.seconds[1]
        )));
        text.push_str(&table(&header, rows, 2));
        for note in &comparison.notes {
            if !told.contains(note) {
                told.push(note.clone());
            }
        }
    }
    text + &notes(&told)
}

/// How far each quantity moved, in half-widths of its 95 % interval: beyond one it is more than chance.
pub fn picture(answers: &[AxisAnswer]) -> String {
    let changes = || answers.iter().flat_map(|answer| &answer.comparison.changes);
    let most = changes().map(|change| place(change.quantity)).max().unwrap_or(0);
    let panel = |answer: &AxisAnswer| {
        let dot = |change: &Change| {
            let half = 0.5 * (change.difference.ci95[1] - change.difference.ci95[0]);
            let moved =
                Some(change.difference.value / half).filter(|moved| moved.is_finite() && half.is_finite())?;
            Some((change.judged.verdict, [place(change.quantity) as f64, moved, 1.0]))
        };
        let dots: Vec<(Verdict, [f64; 3])> = answer.comparison.changes.iter().filter_map(dot).collect();
        let of = |changed: bool| {
            let own = dots.iter().filter(|(verdict, _)| (*verdict == Verdict::Changed) == changed);
            Shape::Dots(own.map(|(_, dot)| *dot).collect())
        };
        let ends = [0.4, most as f64 + 0.6];
        let level = |y: f64| ends.map(|x| [x, y]).to_vec();
        Panel {
            height: 150,
            y: chart::Axis::linear(
                format!("{}: change over the half-width of its 95 % interval", answer.axis),
                padded(
                    dots.iter()
                        .flat_map(|(_, [_, moved, half])| [moved - half, moved + half])
                        .chain([-1.5, 1.5]),
                ),
            ),
            series: vec![
                Series::new("no change", Tone::Measured, Shape::Lines(vec![level(0.0)])),
                Series::new("changed", Tone::Before, of(true)),
                Series::new("not known to have changed", Tone::Ink, of(false)),
            ],
        }
    };
    let names: Vec<String> =
        ORDER[..most].iter().zip(1..).map(|(q, k)| format!("{k} {}", word(*q))).collect();
    let chart = Chart {
        label: "changes of each quantity, in half-widths of their 95 % intervals".into(),
        x: chart::Axis::linear(names.join(", "), 0.4..most as f64 + 0.6),
        panels: answers.iter().map(panel).collect(),
        windows: Vec::new(),
    };
    chart.file(900)
}

/// Quantities in the order of the picture.
const ORDER: [Quantity; 6] = [
    Quantity::Trim,
    Quantity::Effectiveness,
    Quantity::Damping,
    Quantity::LagAndDelay,
    Quantity::Background,
    Quantity::Friction,
];

/// Where a quantity stands in the picture, from 1.
fn place(quantity: Quantity) -> usize {
    ORDER.iter().position(|known| *known == quantity).map_or(0, |place| place + 1)
}

/// Value and half width of the interval.
fn both(estimate: &Estimate) -> String {
    let half = 0.5 * (estimate.ci95[1] - estimate.ci95[0]);
    if half.is_finite() {
        let around = Estimate { value: half, ci95: [0.0, 2.0 * half], ..estimate.clone() };
        format!("{} ± {}", format::estimate(estimate).value, format::estimate(&around).value)
    } else {
        "not determined".to_owned()
    }
}

fn verdict(judged: &Difference) -> &'static str {
    match judged.verdict {
        Verdict::Changed => "changed",
        Verdict::Same if judged.is_certain() => "too little to matter",
        Verdict::Same => "no change seen",
        Verdict::CannotTell => "cannot tell",
    }
}

fn word(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Trim => "trim",
        Quantity::Effectiveness => "effectiveness",
        Quantity::Damping => "damping",
        Quantity::LagAndDelay => "lag and delay",
        Quantity::Friction => "friction",
        Quantity::Background => "background",
    }
}

/// What changed, what did not, and what the data cannot tell.
fn summary(axis: Option<Axis>, comparison: &Comparison) -> String {
    let mut parts: Vec<String> = comparison
        .with(Verdict::Changed)
        .map(|change| changed(axis, change, comparison.inertia_known))
        .collect();
    let same: Vec<&Change> = comparison.with(Verdict::Same).collect();
    if !same.is_empty() {
        let names: Vec<&str> = same.iter().map(|change| word(change.quantity)).collect();
        let sizes: Vec<String> = same.iter().filter_map(|change| seen(change)).collect();
        let sizes = format!("more than {} would have been seen", sizes.join(", "));
        parts.push(format!("{}: no change seen ({sizes})", names.join(", ")));
    }
    let open: Vec<&str> = comparison.with(Verdict::CannotTell).map(|change| word(change.quantity)).collect();
    if !open.is_empty() {
        parts.push(format!("{}: these data cannot tell: the input moves too little, or more acts than the model has (--model gives another)", open.join(", ")));
    }
    parts.join("; ") + "."
}

/// The size that would have been seen, in the unit that people think in.
fn seen(change: &Change) -> Option<String> {
    let size = change.judged.would_be_seen?;
    Some(match change.quantity {
        Quantity::Effectiveness | Quantity::Background => {
            format!("{} %", format::plain(100.0 * size / change.before.value.abs()))
        }
        Quantity::LagAndDelay => format!("{} ms", format::plain(1e3 * size)),
        _ => with_unit(&format::plain(size), &change.before),
    })
}

fn with_unit(number: &str, of: &Estimate) -> String {
    match (of.name.as_str(), of.unit.as_str()) {
        ("trim_command", "1") => format!("{number} of full command"),
        (_, "1") => number.to_owned(),
        (_, unit) => format!("{number} {unit}"),
    }
}

/// One change in words.
fn changed(axis: Option<Axis>, change: &Change, inertia_known: bool) -> String {
    let difference = &change.difference;
    let grew = difference.value > 0.0;
    let size = |scale: f64| {
        let sign = scale.copysign(scale * difference.value);
        let ends = difference.ci95.map(|end| sign * end);
        let scaled = Estimate {
            value: sign * difference.value,
            ci95: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            ..difference.clone()
        };
        format::estimate(&scaled)
    };
    let from_to = || {
        let [before, after] = [&change.before, &change.after].map(|e| format::estimate(e).value);
        with_unit(&format!("from {before} to {after}"), &change.before)
    };
    match change.quantity {
        Quantity::Trim => {
            let Shown { value, interval } = size(1.0);
            let of = axis.map(|axis| format!(" of {axis}")).unwrap_or_default();
            let size = with_unit(&format!("{value} ({interval})"), difference);
            format!("trim{of} moved by {size} {}", direction(axis, grew))
        }
        Quantity::Effectiveness => {
            let Shown { value, interval } = size(100.0 / change.before.value.abs());
            let what = if inertia_known {
                "effectiveness"
            } else {
                "effectiveness (relative to the inertia, which may be what changed)"
            };
            let fell = if change.before.value * difference.value > 0.0 { "grew" } else { "fell" };
            format!("{what} {fell} by {value} % ({interval})")
        }
        Quantity::LagAndDelay => {
            let Shown { value, interval } = size(1e3);
            format!("lag and delay {} by {value} ms ({interval})", if grew { "grew" } else { "fell" })
        }
        Quantity::Damping | Quantity::Friction => format!("{} changed {}", word(change.quantity), from_to()),
        Quantity::Background => {
            format!(
                "the background is {}, {}: the air, or vibration",
                if grew { "stronger" } else { "weaker" },
                from_to()
            )
        }
    }
}

/// Which way a positive or a negative moment turns the craft.
fn direction(axis: Option<Axis>, positive: bool) -> &'static str {
    match (axis, positive) {
        (Some(Axis::Roll), true) => "to the right",
        (Some(Axis::Roll), false) => "to the left",
        (Some(Axis::Pitch), true) => "nose up",
        (Some(Axis::Pitch), false) => "nose down",
        (Some(Axis::Yaw), true) => "nose to the right",
        (Some(Axis::Yaw), false) => "nose to the left",
        (None, true) => "in the positive sense",
        (None, false) => "in the negative sense",
    }
}
