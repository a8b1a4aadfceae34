//! The residual moment over time, and how strong it is before and after.

use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone, min_max_rows};
use sysid::diagnosis::over_time::ResidualMoment;

/// Points of each curve of a run.
const POINTS: usize = 2000;
/// The strength of a moment is its root mean square over this time, s.
const STRENGTH_S: f64 = 3.0;

/// One recording's picture from its `runs`; `windows` in s since its start.
pub fn picture(runs: &[&ResidualMoment], windows: &[[f64; 2]]) -> Chart {
    let series = curves(runs);
    let values = series.iter().flat_map(|of| match &of.shape {
        Shape::Lines(pieces) | Shape::Bold(pieces) => pieces.iter().flatten().map(|p| p[1]).collect(),
        _ => Vec::new(),
    });
    let range = padded(values);
    let times = || runs.iter().flat_map(|run| &run.t).copied();
    let span = times().fold(0.0, f64::min)..times().fold(1.0, f64::max);
    Chart {
        label: "residual moment over time".into(),
        x: Axis::linear("time, s", span),
        panels: vec![Panel { height: 160, y: Axis::linear("moment, N m", range), series }],
        windows: windows.to_vec(),
    }
}

fn curves(runs: &[&ResidualMoment]) -> Vec<Series> {
    let pieces = |values: &dyn Fn(&ResidualMoment) -> Vec<f64>| -> Vec<Vec<[f64; 2]>> {
        let piece = |run: &&ResidualMoment| {
            let values = values(run);
            let rows = min_max_rows(&values, POINTS);
            rows.iter().filter(|&&k| k < run.t.len()).map(|&k| [run.t[k], values[k]]).collect()
        };
        runs.iter().map(piece).collect()
    };
    let before = |run: &ResidualMoment| strength(&run.t, &run.baseline);
    let after = |run: &ResidualMoment| strength(&run.t, run.extended.as_deref().unwrap_or_default());
    let moment = Shape::Lines(pieces(&|run| run.baseline.clone()));
    let mut curves = vec![Series::new("the moment", Tone::Measured, moment)];
    if runs.iter().all(|run| run.extended.is_none()) {
        let strength = Shape::Bold(pieces(&before));
        curves.push(Series::new("its strength (rms over 3 s)", Tone::After, strength));
    } else {
        curves.push(Series::new(
            "its strength (rms over 3 s) before",
            Tone::Before,
            Shape::Bold(pieces(&before)),
        ));
        curves.push(Series::new("after", Tone::After, Shape::Bold(pieces(&after))));
    }
    curves
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
        let drawn = picture(&[&run(true)], &[[60.0, 100.0]]).html();
        assert!(drawn.contains("3 s) before") && drawn.contains(">after</button>"), "{drawn}");
        assert_eq!(drawn.matches("class=\"window\"").count(), 1, "one window");
        assert_eq!(drawn.matches("line bold before").count(), 1);
        let alone = picture(&[&run(false)], &[]).html();
        assert!(!alone.contains("before") && !alone.contains("class=\"window\""));
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
        assert!(picture(&[], &[[0.0, 1.0]]).html().contains("<svg"));
    }
}
