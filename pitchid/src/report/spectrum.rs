//! Over frequency: how strong the motion and what is left of it are, and the response of data and models.

use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use std::f64::consts::{LOG10_E, TAU};
use std::ops::Range;
use sysid::diagnosis::spectra::Spectra;
use sysid::diagnosis::traces::Trace;
use sysid::validate::coherence::{Line, coherence};

/// Two-sided 95 % of a normal distribution, in standard errors.
const NORMAL_95: f64 = 1.96;
/// Frequencies at which the input moves the output less than this (γ²) show nothing of the response.
const LEAST_COHERENCE: f64 = 0.3;
/// Room beside the outermost points, by which none is cut, as a share of the axis.
const EDGE: f64 = 0.02;
/// What lies this many decades below the largest is not drawn.
const DECADES: f64 = 6.0;

/// Spectra of the motion, of what the free runs leave, and of what the model's own background leaves.
pub fn picture(spectra: &Spectra, unit: &str, changed: bool) -> Option<Chart> {
    let logarithms = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        points.iter().filter(|[_, p]| *p > 0.0).map(|[omega, p]| [omega.log10(), p.log10()]).collect()
    };
    let mut curves = vec![("the motion", Tone::Measured, &spectra.measured)];
    match changed {
        true => curves.extend([
            ("left before", Tone::Before, &spectra.before),
            ("left after", Tone::After, &spectra.after),
        ]),
        false => curves.push(("left by the model", Tone::After, &spectra.before)),
    }
    let curves: Vec<(&str, Tone, Vec<[f64; 2]>)> =
        curves.into_iter().map(|(name, tone, points)| (name, tone, logarithms(points))).collect();
    let background = logarithms(&spectra.background);
    let all = || curves.iter().flat_map(|(_, _, points)| points);
    let high = all().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    if !high.is_finite() {
        return None;
    }
    let low = all().chain(&background).map(|p| p[1]).fold(high, f64::min).max(high - DECADES);
    let mut series: Vec<Series> = curves
        .iter()
        .map(|(name, tone, points)| Series::new(*name, *tone, Shape::Lines(vec![points.clone()])))
        .collect();
    series.push(Series::new(
        "what disturbance and noise explain",
        Tone::Ink,
        Shape::Dashes(vec![background.clone()]),
    ));
    Some(Chart {
        label: "spectra of the motion and of what is left".into(),
        x: Axis::logarithmic("frequency, rad/s", ends(all().map(|p| p[0]))),
        panels: vec![Panel {
            height: 210,
            y: Axis::logarithmic(format!("power, ({unit})² per rad/s"), low - 0.1..high + 0.1),
            series,
        }],
        windows: Vec::new(),
    })
}

/// Gain and phase from the input: of the data with their 95 % intervals, and of the models run along the same input.
pub fn response(traces: &[Trace], input_unit: &str, changed: bool) -> Option<Chart> {
    let step = traces.iter().find_map(|trace| Some(trace.t.get(1)? - trace.t.first()?))?;
    let lines = |of: fn(&Trace) -> &Vec<f64>| {
        let sections: Vec<[&[f64]; 2]> = traces.iter().map(|t| [t.input.as_slice(), of(t)]).collect();
        let mut lines = coherence(&sections, step);
        lines.retain(|line| line.coherence >= LEAST_COHERENCE);
        unwrap(&mut lines);
        lines
    };
    let measured = lines(|trace| &trace.measured);
    let [first, last] = [measured.first()?.omega_rad_s, measured.last()?.omega_rad_s];
    let mut models = vec![(lines(|trace| &trace.baseline), "before", Tone::Before)];
    match changed {
        true => models.push((lines(|trace| &trace.extended), "after", Tone::After)),
        false => (models[0].1, models[0].2) = ("the model", Tone::After),
    }
    models.iter_mut().for_each(|(of, ..)| of.retain(|line| (first..=last).contains(&line.omega_rad_s)));
    let panel =
        |height: u32, y: fn(&Line) -> f64, half: fn(&Line) -> f64, axis: &dyn Fn(Range<f64>) -> Axis| {
            let dots: Vec<[f64; 3]> =
                measured.iter().map(|line| [line.omega_rad_s.log10(), y(line), half(line)]).collect();
            let range = padded(dots.iter().flat_map(|[_, y, half]| [y - half, y + half]));
            let mut series = vec![Series::new("data, 95 %", Tone::Measured, Shape::Dots(dots))];
            for (lines, name, tone) in &models {
                let line = lines.iter().map(|line| [line.omega_rad_s.log10(), y(line)]).collect();
                series.push(Series::new(*name, *tone, Shape::Lines(vec![line])));
            }
            Panel { height, y: axis(range), series }
        };
    let unit = traces[0].unit;
    let gain = |range| Axis::logarithmic(format!("gain, {unit} per {input_unit}"), range);
    let phase = |range| Axis::linear("phase, degrees", range);
    Some(Chart {
        label: "response to the input over frequency".into(),
        x: Axis::logarithmic("frequency, rad/s", ends(measured.iter().map(|l| l.omega_rad_s.log10()))),
        panels: vec![
            panel(150, |l| l.gain.log10(), |l| NORMAL_95 * l.deviation * LOG10_E, &gain),
            panel(110, |l| l.phase_rad.to_degrees(), |l| (NORMAL_95 * l.deviation).to_degrees(), &phase),
        ],
        windows: Vec::new(),
    })
}

/// Phases without jumps of a whole turn.
fn unwrap(lines: &mut [Line]) {
    for k in 1..lines.len() {
        let turns = ((lines[k].phase_rad - lines[k - 1].phase_rad) / TAU).round();
        lines[k].phase_rad -= turns * TAU;
    }
}

fn ends(values: impl Iterator<Item = f64> + Clone) -> Range<f64> {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(low + 1e-3, f64::max);
    let room = EDGE * (high - low);
    low - room..high + room
}
