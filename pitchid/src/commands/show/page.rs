//! What is shown of a log, as one HTML file that needs nothing else.

use super::content::{Curve, Shown};
use crate::failure::Failure;
use crate::logs::excitation::Span;
use crate::report::rendered;
use benchmark::page::STYLE;
use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone, min_max_rows};
use serde::Serialize;
use std::ops::Range;

/// Share of the points of a curve at either end of its range that may lie outside the picture, beyond so many times the range of
/// the others.
const SPARED: f64 = 0.03;
/// The same within the spans that move.
const SPARED_OF_MOTION: f64 = 0.005;
const ROOM: f64 = 1.0;
/// Points of each curve.
const POINTS: usize = 4000;

/// What the template is given.
#[derive(Serialize)]
struct Page<'a> {
    parts: Vec<Part<'a>>,
    style: &'static str,
    chart_style: &'static str,
    script: &'static str,
    version: &'static str,
}

/// A flight or a recording with its pictures, axis by axis.
#[derive(Serialize)]
struct Part<'a> {
    is_flight: bool,
    shown: &'a Shown,
    pictures: Vec<Option<String>>,
}

/// The page.
///
/// # Errors
/// A picture or the page that could not be drawn.
pub fn html(shown: &[Shown]) -> Result<String, Failure> {
    let page = Page {
        parts: shown.iter().map(part).collect(),
        style: STYLE,
        chart_style: chart::STYLE,
        script: chart::SCRIPT,
        version: env!("CARGO_PKG_VERSION"),
    };
    rendered(include_str!("page.html"), page)
}

fn part(shown: &Shown) -> Part<'_> {
    let pictures = match shown {
        Shown::Flight(flight) => {
            flight.axes.iter().map(|axis| picture(&axis.curves, &axis.excitation)).collect()
        }
        Shown::Recording(recording) => vec![picture(&recording.curves, &recording.excitation)],
    };
    Part { is_flight: matches!(shown, Shown::Flight(_)), shown, pictures }
}

/// Input, rate with its set-point, angle; shaded where input and rate move.
fn picture(curves: &[Curve], excitation: &[Span]) -> Option<String> {
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
    (!panels.is_empty())
        .then(|| Chart { label, x: Axis::linear("time, s", from..to), panels, windows }.html())
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
        let page = html(&[Shown::Recording(of_recording(&recording, None))]).unwrap();
        assert_eq!(page.matches("class=\"plot\"").count(), 2, "input and rate");
        assert_eq!(page.matches("class=\"window\"").count(), 2, "one span in each");
        assert!(page.contains("a &amp; b.csv") && !page.contains("http:"), "nothing is fetched");
    }
}
