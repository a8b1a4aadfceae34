//! What is left one step ahead: its correlation with itself and with the input, with the bounds of chance.

use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use sysid::diagnosis::left_over::{LeftOver, OneStep};

/// Least and largest half-height of a plane.
const HEIGHTS: [f64; 2] = [0.1, 1.0];

/// Both correlations over the lag.
pub fn picture(left: &LeftOver) -> Chart {
    let own = |one: &OneStep| points(&one.own.correlation, 1, left.step);
    let with_input = |one: &OneStep| points(&one.with_input.correlation, 0, left.step);
    let last = left.before.own.correlation.len() as f64 * left.step;
    let panels = vec![
        panel(left, "with itself", &own, |one| one.own.band, last),
        panel(left, "with earlier input", &with_input, |one| one.with_input.band, last),
    ];
    Chart {
        label: "correlation of what is left one step ahead".into(),
        x: Axis::linear("lag, s", 0.0..last),
        panels,
        windows: Vec::new(),
    }
}

fn points(correlation: &[f64], first: usize, step: f64) -> Vec<[f64; 2]> {
    correlation.iter().enumerate().map(|(k, r)| [(k + first) as f64 * step, *r]).collect()
}

fn panel(
    left: &LeftOver,
    with: &str,
    of: &dyn Fn(&OneStep) -> Vec<[f64; 2]>,
    band: fn(&OneStep) -> f64,
    last: f64,
) -> Panel {
    let last_model = left.after.as_ref().unwrap_or(&left.before);
    let chance = band(last_model);
    let bounds = vec![[0.0, -chance, chance], [last, -chance, chance]];
    let mut series = vec![Series::new("what chance allows", Tone::Measured, Shape::Band(bounds))];
    let mut most = chance;
    let mut put = |name: &str, tone: Tone, one: &OneStep| {
        let line = of(one);
        most = line.iter().map(|[_, r]| r.abs()).fold(most, f64::max);
        series.push(Series::new(name, tone, Shape::Lines(vec![line])));
    };
    match &left.after {
        Some(after) => {
            put("before", Tone::Before, &left.before);
            put("after", Tone::After, after);
        }
        None => put("the model", Tone::After, &left.before),
    }
    let half = (1.1 * most).clamp(HEIGHTS[0], HEIGHTS[1]);
    Panel { height: 130, y: Axis::linear(format!("correlation {with}"), -half..half), series }
}
