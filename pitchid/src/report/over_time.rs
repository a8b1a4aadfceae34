//! The residual moment over time, and how strong it is before and after.

use super::decimate::min_max_rows;
use benchmark::Error;
use benchmark::canvas::{
    Axes, BASELINE, EXTENDED, MEASURED, Plane, legend, mesh, padded, px, shade, svg, tick,
};
use plotters::prelude::*;
use sysid::diagnosis::over_time::ResidualMoment;

/// Points of each curve of a run.
const POINTS: usize = 2000;
/// The strength of a moment is its root mean square over this time, s.
const STRENGTH_S: f64 = 3.0;

/// What is drawn of every run: times and values.
struct Curve<'a> {
    name: &'static str,
    color: RGBColor,
    width: u32,
    runs: Vec<(&'a [f64], Vec<f64>)>,
}

/// One recording's picture from its `runs`; `windows` in s since its start.
pub fn picture(runs: &[&ResidualMoment], windows: &[[f64; 2]]) -> Result<String, Error> {
    let curves = curves(runs);
    let range = padded(curves.iter().flat_map(|c| &c.runs).flat_map(|(_, values)| values.iter().copied()));
    let times = || runs.iter().flat_map(|run| &run.t).copied();
    let span = times().fold(0.0, f64::min)..times().fold(1.0, f64::max);
    svg([900, 230], "residual moment over time", |area| {
        let (head, body) = area.split_vertically(px(26));
        legend(&head, curves.iter().map(|curve| (curve.name, curve.color)))?;
        let mut chart = ChartBuilder::on(&body)
            .margin_top(px(6))
            .margin_right(px(12))
            .x_label_area_size(px(32))
            .y_label_area_size(px(56))
            .build_cartesian_2d(span.clone(), range.clone())
            .map_err(|e| e.to_string())?;
        mesh(&mut chart, &Axes { labels: [9, 5], x: "time, s", y: "moment, N m" }, &tick)?;
        shade(&mut chart, windows, &span, &range)?;
        curves.iter().try_for_each(|curve| curve.draw(&mut chart))
    })
}

fn curves<'a>(runs: &[&'a ResidualMoment]) -> Vec<Curve<'a>> {
    let of = |name, color, width, values: &dyn Fn(&'a ResidualMoment) -> Vec<f64>| Curve {
        name,
        color,
        width,
        runs: runs.iter().map(|run| (run.t.as_slice(), values(run))).collect(),
    };
    let before = |run: &ResidualMoment| strength(&run.t, &run.baseline);
    let after = |run: &ResidualMoment| strength(&run.t, run.extended.as_deref().unwrap_or_default());
    let mut curves = vec![of("the moment", MEASURED, px(1), &|run| run.baseline.clone())];
    if runs.iter().all(|run| run.extended.is_none()) {
        curves.push(of("its strength (rms over 3 s)", EXTENDED, px(2), &before));
    } else {
        curves.push(of("its strength (rms over 3 s) before", BASELINE, px(2), &before));
        curves.push(of("after", EXTENDED, px(2), &after));
    }
    curves
}

impl Curve<'_> {
    fn draw(&self, chart: &mut Plane<'_, '_>) -> Result<(), String> {
        for (t, values) in &self.runs {
            let rows = min_max_rows(values, POINTS);
            let line = rows.iter().filter(|&&k| k < t.len()).map(|&k| (t[k], values[k]));
            let series = LineSeries::new(line, self.color.stroke_width(self.width));
            chart.draw_series(series).map_err(|e| e.to_string())?;
        }
        Ok(())
    }
}

/// Root mean square of `values` within half of [`STRENGTH_S`] before and after each time.
fn strength(t: &[f64], values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value * value);
    }
    let near = |time: f64| {
        let from = t.partition_point(|at| *at < time - 0.5 * STRENGTH_S).min(values.len());
        let to = t.partition_point(|at| *at <= time + 0.5 * STRENGTH_S).min(values.len());
        ((sums[to] - sums[from]).max(0.0) / to.saturating_sub(from).max(1) as f64).sqrt()
    };
    t.iter().take(values.len()).map(|time| near(*time)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(extended: bool) -> ResidualMoment {
        let t: Vec<f64> = (50..5000).map(|k| 0.02 * f64::from(k)).collect();
        let baseline: Vec<f64> = t.iter().map(|t| if *t > 60.0 { (3.0 * t).sin() } else { 0.0 }).collect();
        let after = extended.then(|| baseline.iter().map(|m| 0.1 * m).collect());
        ResidualMoment { recording: 0, t, baseline, extended: after }
    }

    #[test]
    fn before_and_after_are_drawn_with_their_window() {
        let drawn = picture(&[&run(true)], &[[60.0, 100.0]]).unwrap();
        assert!(drawn.contains("3 s) before") && drawn.contains(">\nafter\n"), "{drawn}");
        assert_eq!(drawn.matches("opacity=\"0.08\"").count(), 1, "one window");
        assert_eq!(drawn.matches("stroke=\"#D95F1E\"").count(), 2, "legend and curve");
        let alone = picture(&[&run(false)], &[]).unwrap();
        assert!(!alone.contains("before") && alone.matches("opacity=\"0.08\"").count() == 0);
    }

    #[test]
    fn strength_is_the_root_mean_square_nearby() {
        let run = run(true);
        let found = strength(&run.t, &run.baseline);
        let at = |time: f64| found[run.t.partition_point(|t| *t < time)];
        assert_eq!((found.len(), at(30.0)), (run.t.len(), 0.0));
        assert!((at(80.0) - 0.5_f64.sqrt()).abs() < 0.05, "{}", at(80.0));
        assert!(strength(&run.t, &[]).is_empty());
    }

    #[test]
    fn a_recording_without_a_run_is_an_empty_picture() {
        assert!(picture(&[], &[[0.0, 1.0]]).unwrap().contains("<svg"));
    }
}
