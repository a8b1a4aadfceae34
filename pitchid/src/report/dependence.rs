//! The residual moment against the signal that it depends on most.

use super::content::symbol;
use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use sysid::diagnosis::answer::Dependence;

/// Two-sided 95 % of a normal distribution, in standard errors.
const NORMAL_95: f64 = 1.96;

/// Means by class of the signal with their 95 % intervals.
pub fn picture(dependence: &Dependence) -> Chart {
    let classes = told_apart(&dependence.classes);
    let ends = |c: &[f64; 3]| [c[1] - NORMAL_95 * c[2], c[1] + NORMAL_95 * c[2], 0.0];
    let line = Shape::Lines(vec![classes.iter().map(|c| [c[0], c[1]]).collect()]);
    let dots = Shape::Dots(classes.iter().map(|c| [c[0], c[1], NORMAL_95 * c[2]]).collect());
    Chart {
        label: format!("residual moment against {}", dependence.variable),
        x: Axis::linear(
            format!("{}, {}", symbol(&dependence.variable), dependence.unit),
            padded(classes.iter().map(|c| c[0])),
        ),
        panels: vec![Panel {
            height: 210,
            y: Axis::linear("residual moment, N m", padded(classes.iter().flat_map(ends))),
            series: vec![Series::new("", Tone::After, line), Series::new("", Tone::After, dots)],
        }],
        windows: Vec::new(),
    }
}

/// The classes, those at nearly the same value of the signal as one: a two-level input has many such.
fn told_apart(classes: &[[f64; 3]]) -> Vec<[f64; 3]> {
    const NEARLY_THE_SAME: f64 = 0.01;
    let finite: Vec<[f64; 3]> = classes.iter().filter(|c| c.iter().all(|v| v.is_finite())).copied().collect();
    let range = finite.last().map_or(0.0, |c| c[0]) - finite.first().map_or(0.0, |c| c[0]);
    let same = |a: &[f64; 3], b: &[f64; 3]| b[0] - a[0] < NEARLY_THE_SAME * range;
    let one = |group: &[[f64; 3]]| {
        let n = group.len() as f64;
        let mean = |i: usize| group.iter().map(|c| c[i]).sum::<f64>() / n;
        [mean(0), mean(1), group.iter().map(|c| c[2] * c[2]).sum::<f64>().sqrt() / n]
    };
    finite.chunk_by(same).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_dot_for_each_class() {
        let classes = vec![[-0.5, 0.1, 0.02], [0.0, 0.0, 0.02], [0.5, -0.1, 0.02], [f64::NAN, 0.0, 0.0]];
        let dependence = Dependence { variable: "q".into(), unit: "rad/s".into(), share: 0.3, classes };
        let drawn = picture(&dependence).html();
        assert_eq!(drawn.matches("h0").count(), 3);
        assert!(drawn.contains("q, rad/s"));
    }

    #[test]
    fn classes_of_one_value_are_one_dot() {
        let classes = [[-0.015, 0.1, 0.03], [-0.015, 0.3, 0.04], [0.0, 0.0, 0.02], [0.015, -0.1, 0.02]];
        let shown = told_apart(&classes);
        assert_eq!(shown.len(), 3);
        assert_eq!(shown[0][0], -0.015);
        assert!((shown[0][1] - 0.2).abs() < 1e-12 && (shown[0][2] - 0.025).abs() < 1e-12);
    }
}
