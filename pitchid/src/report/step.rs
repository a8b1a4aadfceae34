//! The answer to a step of the input, before and after, with its interval.

use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use sysid::diagnosis::step_response::StepResponses;

/// Responses of both models.
pub fn picture(steps: &StepResponses, unit: &str) -> Chart {
    let mut series = Vec::new();
    let mut put = |name: &str, tone: Tone, points: &[[f64; 3]]| {
        let band = points.iter().map(|[t, y, half]| [*t, y - half, y + half]).collect();
        series.push(Series::new(name, tone, Shape::Band(band)));
        let line = points.iter().map(|[t, y, _]| [*t, *y]).collect();
        series.push(Series::new(name, tone, Shape::Lines(vec![line])));
    };
    match &steps.after {
        Some(after) => {
            put("before", Tone::Before, &steps.before);
            put("after", Tone::After, after);
        }
        None => put("the model", Tone::After, &steps.before),
    }
    let all = || steps.before.iter().chain(steps.after.iter().flatten());
    // an interval that is wide must not hide the response
    let most = 2.0 * all().map(|[_, y, _]| y.abs()).fold(0.0, f64::max);
    let range = padded(all().flat_map(|[_, y, half]| [y - half, y + half]).map(|y| y.clamp(-most, most)));
    let last = all().map(|[t, ..]| *t).fold(0.0, f64::max);
    let motion = if unit == "rad" { "pitch angle" } else { "pitch rate" };
    Chart {
        label: "response to a step of the input".into(),
        x: Axis::linear("time after the step, s", 0.0..last),
        panels: vec![Panel { height: 210, y: Axis::linear(format!("{motion}, {unit}"), range), series }],
        windows: Vec::new(),
    }
}
