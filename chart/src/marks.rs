//! Points of a plane as paths of whole numbers: one plane is `WIDE` by `HIGH`.

use crate::{Axis, Panel, Series, Shape, Tone, escaped};
use std::fmt::Write;
use std::ops::Range;

/// Width of a plane in its own numbers.
pub const WIDE: f64 = 20_000.0;
/// Height of a plane in its own numbers.
pub const HIGH: f64 = 10_000.0;

/// Shades of a map.
const SHADES: u32 = 8;

impl Tone {
    /// Its class in the style sheet.
    pub const fn class(self) -> &'static str {
        match self {
            Self::Ink => "ink",
            Self::Measured => "measured",
            Self::Before => "before",
            Self::After => "after",
            Self::Third => "third",
            Self::Fourth => "fourth",
        }
    }
}

/// Everything that is drawn in a plane.
pub fn marks(x: &Axis, panel: &Panel, windows: &[[f64; 2]]) -> String {
    let plane = Plane { x: &x.range, y: &panel.y.range };
    let mut text = String::new();
    for [from, to] in windows {
        let [from, to] = [from, to].map(|t| t.clamp(x.range.start, x.range.end));
        if from < to {
            let [left, right] = [from, to].map(|t| plane.across(t));
            let _ = write!(
                text,
                "<rect class=\"window\" x=\"{left}\" y=\"0\" width=\"{}\" height=\"{HIGH}\"/>",
                right - left
            );
        }
    }
    panel.series.iter().for_each(|series| plane.draw(series, &mut text));
    text
}

struct Plane<'a> {
    x: &'a Range<f64>,
    y: &'a Range<f64>,
}

impl Plane<'_> {
    fn across(&self, x: f64) -> i64 {
        (WIDE * (x - self.x.start) / (self.x.end - self.x.start)).round() as i64
    }

    /// Down from the top. What lies outside stays outside, a plane's height away at the most, for the frame to cut it off: held at
    /// the edge a curve would look as if it had met a stop.
    fn down(&self, y: f64) -> i64 {
        let height = self.y.end - self.y.start;
        let y = y.clamp(self.y.start - height, self.y.end + height);
        (HIGH * (1.0 - (y - self.y.start) / height)).round() as i64
    }

    fn at(&self, [x, y]: [f64; 2]) -> [i64; 2] {
        [self.across(x), self.down(y)]
    }

    fn draw(&self, series: &Series, text: &mut String) {
        let mut path = |class: &str, d: String| {
            let (tone, name) = (series.tone.class(), escaped(&series.name));
            let _ = write!(text, "<path class=\"{class} {tone}\" data-name=\"{name}\" d=\"{d}\"/>");
        };
        match &series.shape {
            Shape::Lines(pieces) => path("line", self.lines(pieces)),
            Shape::Bold(pieces) => path("line bold", self.lines(pieces)),
            Shape::Dashes(pieces) => path("line dashes", self.lines(pieces)),
            Shape::Dots(dots) => {
                let finite = || dots.iter().filter(|dot| dot.iter().all(|v| v.is_finite()));
                let reach = finite().filter(|[_, _, half]| *half > 0.0).map(|[x, y, half]| {
                    let [across, low] = self.at([*x, y - half]);
                    format!("M{across} {low}V{}", self.down(y + half))
                });
                path("reach", reach.collect());
                let dots = finite().map(|[x, y, _]| self.at([*x, *y])).map(|[x, y]| format!("M{x} {y}h0"));
                path("dots", dots.collect());
            }
            Shape::Band(rows) => {
                let low = rows.iter().map(|[x, low, _]| [*x, *low]);
                let high = rows.iter().rev().map(|[x, _, high]| [*x, *high]);
                path("band", self.lines(&[low.chain(high).collect()]) + "z");
            }
            Shape::Cells(cells) => self.cells(series, cells, text),
        }
    }

    /// One path for each shade.
    fn cells(&self, series: &Series, cells: &[[f64; 5]], text: &mut String) {
        for shade in 1..=SHADES {
            let of_shade =
                |cell: &&[f64; 5]| (cell[4].clamp(0.0, 1.0) * f64::from(SHADES)).ceil() == f64::from(shade);
            let rectangle = |&[from, to, low, high, _]: &[f64; 5]| {
                let ([left, bottom], [right, top]) = (self.at([from, low]), self.at([to, high]));
                format!("M{left} {bottom}H{right}V{top}H{left}z")
            };
            let d: String = cells.iter().filter(of_shade).map(rectangle).collect();
            if !d.is_empty() {
                let (tone, name) = (series.tone.class(), escaped(&series.name));
                let opacity = f64::from(shade) / f64::from(SHADES);
                let _ = write!(
                    text,
                    "<path class=\"cell {tone}\" data-name=\"{name}\" fill-opacity=\"{opacity}\" d=\"{d}\"/>"
                );
            }
        }
    }

    /// Each piece from its first point in steps, which is short. A value that is no number breaks the line.
    fn lines(&self, pieces: &[Vec<[f64; 2]>]) -> String {
        let mut text = String::new();
        let whole = pieces.iter().flat_map(|piece| piece.split(|point| !point.iter().all(|v| v.is_finite())));
        for piece in whole {
            let mut before: Option<[i64; 2]> = None;
            for point in piece.iter().map(|point| self.at(*point)) {
                let _ = match before {
                    None => write!(text, "M{} {}l0 0", point[0], point[1]),
                    Some(before) => write!(text, " {} {}", point[0] - before[0], point[1] - before[1]),
                };
                before = Some(point);
            }
        }
        text
    }
}
