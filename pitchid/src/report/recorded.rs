//! What was recorded, where nothing could be simulated beside it.

use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone, min_max_rows};
use sysid::recording::Recording;

/// Points of each curve.
const POINTS: usize = 3000;

/// Input, rate and angle of a recording; `windows` in s by its clock.
pub fn picture(recording: &Recording, windows: &[[f64; 2]]) -> Chart {
    let input = format!("input, {}", recording.u_unit.symbol());
    let mut panels = vec![panel(&input, recording, &[("input", Tone::After, &recording.u)])];
    if let Some(rate) = &recording.q {
        panels.push(panel("rate, rad/s", recording, &[("rate", Tone::Measured, rate)]));
    }
    let reference = recording.theta_ref.iter().map(|values| ("set-point", Tone::Before, values));
    let angle = recording.theta.iter().map(|values| ("angle", Tone::Third, values));
    let of_angle: Vec<(&str, Tone, &Vec<f64>)> = reference.chain(angle).collect();
    if !of_angle.is_empty() {
        panels.push(panel("angle, rad", recording, &of_angle));
    }
    let span = recording.t.first().copied().unwrap_or(0.0)..recording.t.last().copied().unwrap_or(1.0);
    Chart {
        label: format!("what {} holds", recording.name),
        x: Axis::linear("time, s", span),
        panels,
        windows: windows.to_vec(),
    }
}

fn panel(title: &str, recording: &Recording, curves: &[(&str, Tone, &Vec<f64>)]) -> Panel {
    let series = curves.iter().map(|(name, tone, values)| {
        let pieces = recording.segments.iter().map(|segment| {
            let rows = min_max_rows(&values[segment.clone()], POINTS);
            rows.iter().map(|k| [recording.t[segment.start + k], values[segment.start + k]]).collect()
        });
        Series::new(*name, *tone, Shape::Lines(pieces.collect()))
    });
    let finite = curves.iter().flat_map(|(_, _, values)| values.iter()).copied().filter(|v| v.is_finite());
    Panel { height: 110, y: Axis::linear(title, padded(finite)), series: series.collect() }
}
