//! Measured against simulated, before and after.

use super::decimate::min_max_rows;
use benchmark::Error;
use benchmark::canvas::{
    Area, Axes, BASELINE, EXTENDED, MEASURED, legend, mesh, padded, px, shade, standalone, svg, tick,
};
use plotters::prelude::*;
use std::ops::Range;
use sysid::diagnosis::traces::Trace;

/// Points of each curve in the large picture.
const POINTS_LARGE: usize = 2000;
/// Points of each curve in a small one.
const POINTS_SMALL: usize = 700;
/// A simulation that runs away is cut off at this many times the measured range.
const CUT_OFF: f64 = 2.0;

/// What is drawn in a trace.
pub struct View<'a> {
    /// The section.
    pub trace: &'a Trace,
    /// Whether the model after differs from the one before.
    pub changed: bool,
    /// Time windows to be marked, s.
    pub windows: &'a [[f64; 2]],
}

struct Curve<'a> {
    name: &'static str,
    values: &'a [f64],
    color: RGBColor,
    width: u32,
}

impl View<'_> {
    /// The large picture: the signals, and below them what each model leaves over.
    pub fn large(&self) -> Result<String, Error> {
        self.large_of([900, 400])
    }

    fn large_of(&self, size: [u32; 2]) -> Result<String, Error> {
        svg(size, &format!("section {}: measured and simulated", self.trace.label), |area| {
            let (head, rest) = area.split_vertically(px(26));
            legend(&head, self.curves().iter().map(|curve| (curve.name, curve.color)))?;
            let share = 0.62 * f64::from(size[1] - 26);
            let (top, bottom) = rest.split_vertically(px(share as u32));
            let signals = self.curves();
            let signal = if self.trace.unit == "rad" { "pitch angle, rad" } else { "pitch rate, rad/s" };
            self.panel(&top, &signals, self.range_of(&signals), signal, None, POINTS_LARGE)?;
            let left = self.left_over();
            let models = signals[1..].iter().zip(&left);
            let curves: Vec<Curve<'_>> =
                models.map(|(c, values)| Curve { values, width: px(1), ..*c }).collect();
            self.panel(&bottom, &curves, self.range_of(&curves), "left over", Some("time, s"), POINTS_LARGE)
        })
    }

    /// A small picture: the signals alone.
    pub fn small(&self) -> Result<String, Error> {
        svg([440, 190], &format!("section {}: measured and simulated", self.trace.label), |area| {
            let signals = self.curves();
            self.panel(
                area,
                &signals,
                self.range_of(&signals),
                self.trace.unit,
                Some("time, s"),
                POINTS_SMALL,
            )
        })
    }

    /// The large picture as a file of its own, for light and dark pages.
    pub fn standalone(&self) -> Result<String, Error> {
        Ok(standalone(&self.large_of([900, 360])?))
    }

    fn curves(&self) -> Vec<Curve<'_>> {
        let trace = self.trace;
        let model = |name, values, color| Curve { name, values, color, width: 5 };
        let measured = Curve { name: "measured", values: &trace.measured, color: MEASURED, width: 7 };
        if !self.changed {
            return vec![measured, model("the model, estimated again", &trace.baseline, EXTENDED)];
        }
        let before = model("before: the model, estimated again", &trace.baseline, BASELINE);
        vec![measured, before, model("after: with what was missing", &trace.extended, EXTENDED)]
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

    fn panel(
        &self,
        area: &Area<'_>,
        curves: &[Curve<'_>],
        range: Range<f64>,
        what: &str,
        time: Option<&str>,
        points: usize,
    ) -> Result<(), String> {
        let t = &self.trace.t;
        let span = t.first().copied().unwrap_or(0.0)..t.last().copied().unwrap_or(1.0);
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(6))
            .margin_right(px(12))
            .x_label_area_size(px(if time.is_some() { 32 } else { 6 }))
            .y_label_area_size(px(56))
            .build_cartesian_2d(span.clone(), range.clone())
            .map_err(|e| e.to_string())?;
        let written = |t: &f64| if time.is_some() { tick(t) } else { String::new() };
        mesh(&mut chart, &Axes { labels: [9, 5], x: time.unwrap_or(""), y: what }, &written)?;
        shade(&mut chart, self.windows, &span, &range)?;
        for curve in curves {
            let rows = min_max_rows(curve.values, points);
            let line = rows.iter().filter(|&&k| k < t.len());
            let line = line.map(|&k| (t[k], curve.values[k].clamp(range.start, range.end)));
            let series = LineSeries::new(line, curve.color.stroke_width(curve.width));
            chart.draw_series(series).map_err(|e| e.to_string())?;
        }
        Ok(())
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
        let view = View { trace: &trace, changed: true, windows: &[[10.0, 20.0]] };
        let (large, small) = (view.large().unwrap(), view.small().unwrap());
        assert!(large.len() < 200_000 && small.len() < 60_000, "{} {}", large.len(), small.len());
        let before = |picture: &str| picture.matches("stroke=\"#D95F1E\"").count();
        assert_eq!((before(&large), before(&small)), (3, 1), "legend, signal and what is left over; signal");
        assert!(!large.contains("IV<x>"));
    }

    #[test]
    fn a_simulation_that_runs_away_does_not_hide_the_rest() {
        let mut trace = trace(100);
        trace.baseline[50] = 1e12;
        trace.baseline[51] = f64::NAN;
        let view = View { trace: &trace, changed: false, windows: &[] };
        assert!(view.range_of(&view.curves()).end < 2.5);
        assert!(!view.large().unwrap().contains("after"));
    }

    #[test]
    fn a_section_without_simulation_is_drawn_all_the_same() {
        let empty = Trace { baseline: Vec::new(), extended: Vec::new(), ..trace(50) };
        let view = View { trace: &empty, changed: true, windows: &[] };
        assert!(view.large().unwrap().contains("<polyline"));
        assert!(view.standalone().unwrap().contains("prefers-color-scheme"));
    }
}
