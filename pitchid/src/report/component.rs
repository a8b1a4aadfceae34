//! What the data say of a term with that term taken out of the model, beside the term.

use benchmark::Error;
use benchmark::canvas::{
    Area, Axes, BASELINE, EXTENDED, INK, MEASURED, Plane, legend, mesh, padded, px, svg, tick,
};
use plotters::prelude::*;
use sysid::diagnosis::component::{Branch, Component};
use sysid::model::effect::{Picture, Signal};

/// Two-sided 95 % of a normal distribution, in standard errors.
const NORMAL_95: f64 = 1.96;
/// Intervals may enlarge the picture by this share of the range of points and curves on either side; beyond, they are cut.
const MOST_OF_INTERVALS: f64 = 0.5;

/// The picture of a term.
pub fn picture(component: &Component) -> Result<String, Error> {
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
    svg([440, 300], &format!("{}: data and term", component.about.id), |area| {
        let (head, body) = area.split_vertically(px(24));
        names(&head, branches.len())?;
        let mut chart = ChartBuilder::on(&body)
            .margin_top(px(6))
            .margin_right(px(12))
            .x_label_area_size(px(38))
            .y_label_area_size(px(66))
            .build_cartesian_2d(span.clone(), range.clone())
            .map_err(|e| e.to_string())?;
        mesh(&mut chart, &Axes { labels: [6, 6], x: &x, y: &y }, &tick)?;
        for (branch, color) in branches.iter().zip([EXTENDED, MEASURED]) {
            draw(&mut chart, branch, color, [range.start, range.end])?;
        }
        Ok(())
    })
}

fn names(area: &Area<'_>, branches: usize) -> Result<(), String> {
    let without = ("without the term", BASELINE);
    match branches {
        2 => legend(area, [without, ("rising", EXTENDED), ("falling", MEASURED)]),
        _ => legend(area, [without, ("with it", EXTENDED), ("the data", INK)]),
    }
}

fn draw(
    chart: &mut Plane<'_, '_>,
    branch: &Branch,
    color: RGBColor,
    [low, high]: [f64; 2],
) -> Result<(), String> {
    let mut line = |points: Vec<(f64, f64)>, color: RGBColor, width: u32| {
        let path = PathElement::new(points, color.stroke_width(width));
        chart.draw_series([path]).map(|_| ()).map_err(|e| e.to_string())
    };
    let curve = |points: &[[f64; 2]]| points.iter().map(|[x, y]| (*x, *y)).collect();
    line(curve(&branch.without), BASELINE, px(1))?;
    line(curve(&branch.with), color, px(2))?;
    let dots = if color == EXTENDED { INK } else { color };
    for [x, y, error] in &branch.data {
        let ends = [y - NORMAL_95 * error, y + NORMAL_95 * error].map(|end| (*x, end.clamp(low, high)));
        line(ends.to_vec(), dots, px(1))?;
    }
    let dots = branch.data.iter().map(|[x, y, _]| Circle::new((*x, *y), px(3), dots.filled()));
    chart.draw_series(dots).map(|_| ()).map_err(|e| e.to_string())
}

/// What stands on the axes, with units.
fn axes(component: &Component) -> (String, String) {
    let unit = component.input_unit;
    let per_unit = |of: &str| if unit == "1" { of.to_owned() } else { format!("{of}/{unit}") };
    let (signal, y) = match component.picture {
        Picture::Moment(Signal::Command) => (Some(Signal::Command), "moment beside ∂M/∂u·u, N m".to_owned()),
        Picture::Moment(signal) => (Some(signal), "moment, N m".into()),
        Picture::Loop => (Some(Signal::Angle), "moment, N m".into()),
        Picture::Gain(signal) => (Some(signal), format!("∂M/∂u, {}", per_unit("N m"))),
        Picture::Damping(signal) => (Some(signal), "∂M/∂q, N m s/rad".into()),
        Picture::StepResponse => (None, format!("moment per command, {}", per_unit("N m"))),
        Picture::Measured(signal) => (Some(signal), "added to the measured rate, rad/s".into()),
    };
    let x = match signal {
        None => "time since a step of the command, s".into(),
        Some(Signal::Rate) => "q, rad/s".into(),
        Some(Signal::Angle) => "θ, rad".into(),
        Some(Signal::Command) => format!("u after the delay, {unit}"),
        Some(Signal::Time) => "time, s".into(),
        Some(Signal::RollRate) => "p, rad/s".into(),
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
            branches: vec![branch; branches],
        }
    }

    #[test]
    fn dots_intervals_and_both_curves_are_drawn() {
        let drawn = picture(&component("coulomb_friction", 1)).unwrap();
        assert_eq!(drawn.matches("<circle").count(), 11);
        assert!(drawn.contains("q, rad/s") && drawn.contains("moment, N m"));
        assert_eq!(drawn.matches("stroke=\"#D95F1E\"").count(), 2, "legend and curve");
        let turns = picture(&component("hysteresis", 2)).unwrap();
        assert!(turns.contains("rising") && turns.matches("<circle").count() == 22);
        assert!(caption(&component("servo_lag", 1)).contains("after a step of the command"));
    }

    #[test]
    fn an_interval_that_is_wide_does_not_hide_the_rest() {
        let mut wide = component("coulomb_friction", 1);
        wide.branches[0].data[0][2] = 1e6;
        let drawn = picture(&wide).unwrap();
        assert!(drawn.contains("0.05") && !drawn.contains("1000000"), "{drawn}");
    }
}
