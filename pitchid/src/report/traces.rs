//! Measured against simulated, before and after.

use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone, min_max_rows};
use std::ops::Range;
use sysid::diagnosis::traces::Trace;
use sysid::recording::Recording;

/// Points of each curve in the large picture.
const POINTS_LARGE: usize = 3000;
/// Points of each curve in a small one.
const POINTS_SMALL: usize = 900;
/// A simulation that runs away is cut off at this many times the measured range.
const CUT_OFF: f64 = 2.0;

/// What is drawn in a trace.
pub struct View<'a> {
    /// The section.
    pub trace: &'a Trace,
    /// The recording that it is of, for its set-point and the unit of its input.
    pub recording: Option<&'a Recording>,
    /// Whether the model after differs from the one before.
    pub changed: bool,
    /// Time windows to be marked, s.
    pub windows: &'a [[f64; 2]],
}

struct Curve<'a> {
    name: &'static str,
    values: &'a [f64],
    tone: Tone,
}

impl View<'_> {
    /// The large picture: the signals, below them what each model leaves over, and what was commanded beside them.
    pub fn large(&self) -> Chart {
        let signals = self.curves();
        let signal = if self.trace.unit == "rad" { "pitch angle, rad" } else { "pitch rate, rad/s" };
        let left = self.left_over();
        let models = signals[1..].iter().zip(&left);
        let over: Vec<Curve<'_>> = models.map(|(c, values)| Curve { values, ..*c }).collect();
        let over_title = format!("left over, {}", self.trace.unit);
        let mut panels = vec![
            self.panel(230, &signals, signal, POINTS_LARGE),
            self.panel(100, &over, &over_title, POINTS_LARGE),
        ];
        panels.extend(self.angle());
        if !self.trace.input.is_empty() {
            let unit = self.recording.map_or("its unit", |recording| recording.u_unit.symbol());
            let input = Curve { name: "input", values: &self.trace.input, tone: Tone::Fourth };
            let range = padded(self.trace.input.iter().copied());
            panels.push(self.panel_of(90, &[input], &format!("input, {unit}"), POINTS_LARGE, range));
        }
        self.chart(panels)
    }

    /// The angle beside the rate, with its set-point where there is one.
    fn angle(&self) -> Option<Panel> {
        let angle = self.trace.angle.as_ref()?;
        let [measured, before, after] = match self.curves().as_slice() {
            [measured, after] => [measured.name, "", after.name],
            [measured, before, after] => [measured.name, before.name, after.name],
            _ => return None,
        };
        let last = if self.changed { &angle.extended } else { &angle.baseline };
        let mut curves = vec![Curve { name: measured, values: &angle.measured, tone: Tone::Measured }];
        if self.changed {
            curves.push(Curve { name: before, values: &angle.baseline, tone: Tone::Before });
        }
        curves.push(Curve { name: after, values: last, tone: Tone::After });
        let most = CUT_OFF * angle.measured.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let mut all: Vec<f64> = curves.iter().flat_map(|c| c.values).map(|v| v.clamp(-most, most)).collect();
        let set_point = self.set_point();
        all.extend(set_point.iter().map(|[_, v]| *v));
        let mut panel = self.panel_of(110, &curves, "pitch angle, rad", POINTS_LARGE, padded(all));
        if !set_point.is_empty() {
            panel.series.insert(0, Series::new("set-point", Tone::Third, Shape::Lines(vec![set_point])));
        }
        Some(panel)
    }

    /// The set-point within the section, where it moves.
    fn set_point(&self) -> Vec<[f64; 2]> {
        let Some((recording, values)) = self.recording.and_then(|r| Some((r, r.theta_ref.as_ref()?))) else {
            return Vec::new();
        };
        let (Some(from), Some(to)) = (self.trace.t.first(), self.trace.t.last()) else { return Vec::new() };
        let rows = recording.t.iter().zip(values).filter(|(t, v)| (from..=to).contains(t) && v.is_finite());
        let (t, values): (Vec<f64>, Vec<f64>) = rows.unzip();
        if values.iter().all(|v| *v == values[0]) {
            return Vec::new();
        }
        min_max_rows(&values, POINTS_LARGE).into_iter().map(|k| [t[k], values[k]]).collect()
    }

    /// A small picture: the signals alone.
    pub fn small(&self) -> Chart {
        let signal = if self.trace.unit == "rad" { "angle, rad" } else { "rate, rad/s" };
        self.chart(vec![self.panel(140, &self.curves(), signal, POINTS_SMALL)])
    }

    fn curves(&self) -> Vec<Curve<'_>> {
        let trace = self.trace;
        let model = |name, values, tone| Curve { name, values, tone };
        let measured = model("measured", &trace.measured, Tone::Measured);
        if !self.changed {
            return vec![measured, model("the model, estimated again", &trace.baseline, Tone::After)];
        }
        let before = model("before: the model, estimated again", &trace.baseline, Tone::Before);
        vec![measured, before, model("after: with what was missing", &trace.extended, Tone::After)]
    }

    /// Measured less simulated, for the models in the order of the curves.
    fn left_over(&self) -> Vec<Vec<f64>> {
        let trace = self.trace;
        let less = |simulated: &[f64]| trace.measured.iter().zip(simulated).map(|(m, s)| m - s).collect();
        vec![less(&trace.baseline), less(&trace.extended)]
    }

    /// The range of curves, of which none that runs away may hide the others.
    fn range_of(&self, curves: &[Curve<'_>]) -> Range<f64> {
        let most = CUT_OFF * self.trace.measured.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        padded(curves.iter().flat_map(|c| c.values).map(|v| v.clamp(-most, most)))
    }

    fn panel(&self, height: u32, curves: &[Curve<'_>], what: &str, points: usize) -> Panel {
        self.panel_of(height, curves, what, points, self.range_of(curves))
    }

    fn panel_of(
        &self,
        height: u32,
        curves: &[Curve<'_>],
        what: &str,
        points: usize,
        range: Range<f64>,
    ) -> Panel {
        let t = &self.trace.t;
        let series = |curve: &Curve<'_>| {
            let rows = min_max_rows(curve.values, points);
            let line = rows.iter().filter(|&&k| k < t.len()).map(|&k| [t[k], curve.values[k]]);
            Series::new(curve.name, curve.tone, Shape::Lines(vec![line.collect()]))
        };
        Panel { height, y: Axis::linear(what, range), series: curves.iter().map(series).collect() }
    }

    fn chart(&self, panels: Vec<Panel>) -> Chart {
        let t = &self.trace.t;
        let span = t.first().copied().unwrap_or(0.0)..t.last().copied().unwrap_or(1.0);
        Chart {
            label: format!("section {}: measured and simulated", self.trace.label),
            x: Axis::linear("time, s", span),
            panels,
            windows: self.windows.to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(n: usize) -> Trace {
        let t: Vec<f64> = (0..n).map(|k| 0.02 * k as f64).collect();
        let wave = |gain: f64| t.iter().map(|t| gain * t.sin()).collect();
        Trace {
            label: "IV<x>".into(),
            recording: 0,
            input: wave(0.1),
            angle: None,
            measured: wave(1.0),
            baseline: wave(0.7),
            extended: wave(0.95),
            t,
            unit: "rad/s",
        }
    }

    #[test]
    fn pictures_stay_small_however_long_the_recording() {
        let trace = trace(200_000);
        let view = View { trace: &trace, recording: None, changed: true, windows: &[[10.0, 20.0]] };
        let (large, small) = (view.large().html(), view.small().html());
        assert!(large.len() < 200_000 && small.len() < 60_000, "{} {}", large.len(), small.len());
        let before = |picture: &str| picture.matches("class=\"line before\"").count();
        assert_eq!((before(&large), before(&small)), (2, 1), "signal and what is left over; signal");
        assert!(!large.contains("IV<x>"));
    }

    #[test]
    fn a_simulation_that_runs_away_does_not_hide_the_rest() {
        let mut trace = trace(100);
        trace.baseline[50] = 1e12;
        trace.baseline[51] = f64::NAN;
        let view = View { trace: &trace, recording: None, changed: false, windows: &[] };
        assert!(view.range_of(&view.curves()).end < 2.5);
        assert!(!view.large().html().contains("after: "));
    }

    #[test]
    fn a_section_without_simulation_is_drawn_all_the_same() {
        let empty = Trace { baseline: Vec::new(), extended: Vec::new(), ..trace(50) };
        let view = View { trace: &empty, recording: None, changed: true, windows: &[] };
        assert!(view.large().html().contains("class=\"line measured\""));
        assert!(view.large().file(900).contains("prefers-color-scheme"));
    }
}
