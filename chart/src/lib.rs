//! Charts as SVG. On a page they are as wide as their place while their text keeps its size, and a script of their own zooms,
//! pans, reads off and switches curves; as files they stand alone. Light and dark.

mod decimate;
mod draw;
mod marks;
pub mod ticks;

pub use decimate::min_max_rows;
use std::ops::Range;

/// What a page with charts needs in its style sheet.
pub const STYLE: &str = concat!(include_str!("colours.css"), include_str!("chart.css"));
/// What makes the charts of a page answer to mouse, touch and keys. They can be read without.
pub const SCRIPT: &str = include_str!("chart.js");

/// What a curve stands for, by which it has its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Data in a picture of few points.
    Ink,
    /// What was measured.
    Measured,
    /// The model before.
    Before,
    /// The model after.
    After,
    /// A further one.
    Third,
    /// And one more.
    Fourth,
}

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is, with its unit.
    pub title: String,
    /// What is shown: values, or their logarithms to the base 10.
    pub range: Range<f64>,
    /// Whether range and points are logarithms.
    pub logarithmic: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(title: impl Into<String>, range: Range<f64>) -> Self {
        Self { title: title.into(), range, logarithmic: false }
    }

    /// An axis of logarithms to the base 10.
    pub fn logarithmic(title: impl Into<String>, range: Range<f64>) -> Self {
        Self { title: title.into(), range, logarithmic: true }
    }
}

/// What is drawn of a series.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Lines through points, piece by piece.
    Lines(Vec<Vec<[f64; 2]>>),
    /// A heavier line.
    Bold(Vec<Vec<[f64; 2]>>),
    /// Dashed lines.
    Dashes(Vec<Vec<[f64; 2]>>),
    /// Dots: x, y, and how far its interval reaches to either side.
    Dots(Vec<[f64; 3]>),
    /// What lies between two curves: x, low, high.
    Band(Vec<[f64; 3]>),
    /// Shaded rectangles: x from and to, y from and to, how dark from 0 to 1.
    Cells(Vec<[f64; 5]>),
}

/// A curve, a cloud, a band.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend; empty: none. Series of one name are switched together.
    pub name: String,
    /// Its colour.
    pub tone: Tone,
    /// What is drawn.
    pub shape: Shape,
}

impl Series {
    /// A series.
    pub fn new(name: impl Into<String>, tone: Tone, shape: Shape) -> Self {
        Self { name: name.into(), tone, shape }
    }
}

/// A plane of a chart.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Height of the plane, CSS pixels.
    pub height: u32,
    /// Its vertical axis.
    pub y: Axis,
    /// What is drawn, the last on top.
    pub series: Vec<Series>,
}

/// Planes above one another over one horizontal axis.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it shows, for those who cannot see it.
    pub label: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The planes.
    pub panels: Vec<Panel>,
    /// Stretches of x that are shaded.
    pub windows: Vec<[f64; 2]>,
}

/// Text that may stand in HTML and in attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
