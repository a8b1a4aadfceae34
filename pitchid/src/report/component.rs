//! What the data say of a term with that term taken out of the model, beside the term.

use chart::ticks::padded;
use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use sysid::diagnosis::component::{Branch, Component};
use sysid::model::effect::{Picture, Signal};

/// Two-sided 95 % of a normal distribution, in standard errors.
const NORMAL_95: f64 = 1.96;
/// Intervals may enlarge the picture by this share of the range of points and curves on either side; beyond, they are cut.
const MOST_OF_INTERVALS: f64 = 0.5;

/// The picture of a term.
pub fn picture(component: &Component) -> Chart {
    let branches = &component.branches;
    let values = || {
        let points = branches.iter().flat_map(|b| b.data.iter().map(|p| p[1]));
        points.chain(branches.iter().flat_map(|b| b.with.iter().chain(&b.without)).map(|p| p[1]))
    };
    let inner = padded(values());
    let room = MOST_OF_INTERVALS * (inner.end - inner.start);
    let ends = branches.iter().flat_map(|b| &b.data).flat_map(|[_, y, error]| {
        [(y - NORMAL_95 * error).max(inner.start - room), (y + NORMAL_95 * error).min(inner.end + room)]
    });
    let range = padded(values().chain(ends));
    let across = branches.iter().flat_map(|b| {
        let curves = b.with.iter().chain(&b.without).map(|p| p[0]);
        curves.chain(b.data.iter().map(|p| p[0])).collect::<Vec<f64>>()
    });
    let span = padded(across);
    let (x, y) = axes(component);
    let series: Vec<Series> = match &branches[..] {
        [rising, falling, ..] => {
            let rising = drawn(rising, [("rising", Tone::After), ("rising", Tone::After)]);
            let falling = drawn(falling, [("falling", Tone::Third), ("falling", Tone::Third)]);
            rising.into_iter().chain(falling).collect()
        }
        _ => branches
            .iter()
            .flat_map(|b| drawn(b, [("with it", Tone::After), ("the data", Tone::Ink)]))
            .collect(),
    };
    Chart {
        label: format!("{}: data and term", component.about.id),
        x: Axis::linear(x, span),
        panels: vec![Panel { height: 220, y: Axis::linear(y, range), series }],
        windows: Vec::new(),
    }
}

/// Without the term, with it, and the data.
fn drawn(branch: &Branch, [with, data]: [(&str, Tone); 2]) -> [Series; 3] {
    let dots = branch.data.iter().map(|[x, y, error]| [*x, *y, NORMAL_95 * error]).collect();
    [
        Series::new("without the term", Tone::Before, Shape::Lines(vec![branch.without.clone()])),
        Series::new(with.0, with.1, Shape::Bold(vec![branch.with.clone()])),
        Series::new(data.0, data.1, Shape::Dots(dots)),
    ]
}

/// What stands on the axes, with units.
fn axes(component: &Component) -> (String, String) {
    let unit = component.input_unit;
    let per_unit = |of: &str| if unit == "1" { of.to_owned() } else { format!("{of}/{unit}") };
    let (signal, y) = match component.picture {
        Picture::Moment(Signal::Command) => {
            (Some(Signal::Command), "missing moment beside ∂M/∂u·u, N m".to_owned())
        }
        Picture::Moment(signal) => (Some(signal), "missing moment, N m".into()),
        Picture::Loop => (Some(Signal::Angle), "missing moment, N m".into()),
        Picture::Gain(signal) => (Some(signal), format!("effectiveness ∂M/∂u, {}", per_unit("N m"))),
        Picture::Damping(signal) => (Some(signal), "damping ∂M/∂q, N m s/rad".into()),
        Picture::StepResponse => (None, format!("moment per command, {}", per_unit("N m"))),
        Picture::Measured(signal) => (Some(signal), "added to the measured rate, rad/s".into()),
    };
    let x = match signal {
        None => "time since a step of the command, s".into(),
        Some(Signal::Rate) => "pitch rate q, rad/s".into(),
        Some(Signal::Angle) => "pitch angle θ, rad".into(),
        Some(Signal::Command) => format!("command u after the delay, {unit}"),
        Some(Signal::Time) => "time, s".into(),
        Some(Signal::RollRate) => "roll rate p, rad/s".into(),
        Some(Signal::RollCommand) => "command of roll".into(),
        Some(Signal::Thrust) => "thrust relative to its mean".into(),
        Some(Signal::Voltage) => "voltage relative to its mean".into(),
    };
    (x, y)
}

/// What the picture shows, as its caption.
pub fn caption(component: &Component) -> String {
    let about = &component.about;
    let what = match component.picture {
        Picture::StepResponse => "what the moment does after a step of the command",
        Picture::Gain(_) => "the effectiveness of the command",
        Picture::Damping(_) => "the damping",
        Picture::Measured(_) => "what is added to the measured rate",
        Picture::Moment(Signal::Command) => "the moment of the command beside ∂M/∂u·u",
        Picture::Moment(_) | Picture::Loop => "the moment that is missing",
    };
    format!(
        "{}: {}. Dots: {what} as the data have it with this term taken out of the model, no shape assumed, with 95 % intervals",
        about.id, about.sentence
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use sysid::catalogue::find;

    fn component(id: &str, branches: usize) -> Component {
        let effect = find(id).unwrap();
        let branch = Branch {
            data: (-5i32..=5).map(|k| [0.1 * f64::from(k), -0.05 * f64::from(k.signum()), 0.01]).collect(),
            with: vec![[-0.5, 0.05], [0.5, -0.05]],
            without: vec![[-0.5, 0.0], [0.5, 0.0]],
        };
        Component {
            about: effect.about(),
            picture: effect.picture().unwrap(),
            input_unit: "rad",
            left: false,
            branches: vec![branch; branches],
        }
    }

    #[test]
    fn dots_intervals_and_both_curves_are_drawn() {
        let drawn = picture(&component("coulomb_friction", 1)).html();
        assert_eq!(drawn.matches("h0").count(), 11);
        assert!(drawn.contains("q, rad/s") && drawn.contains("moment, N m"));
        assert_eq!(drawn.matches("class=\"line before\"").count(), 1);
        let turns = picture(&component("hysteresis", 2)).html();
        assert!(turns.contains("rising") && turns.matches("h0").count() == 22);
        assert!(caption(&component("servo_lag", 1)).contains("after a step of the command"));
    }

    #[test]
    fn an_interval_that_is_wide_does_not_hide_the_rest() {
        let mut wide = component("coulomb_friction", 1);
        wide.branches[0].data[0][2] = 1e6;
        let drawn = picture(&wide).html();
        assert!(drawn.contains(">0.1</text>") && !drawn.contains("1000000"), "{drawn}");
    }
}
