//! Pages and charts in the style of the reports.

use ::chart::ticks::padded;
use ::chart::{Axis, Chart, Panel, Series, Shape, Tone};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A page with this in its body.
#[pyfunction]
fn page(title: &str, body: &str) -> String {
    pitchid::answers::page(title, body)
}

/// Name, tone, kind (`dots`, `line`, `dashes`, `band`), points of three numbers; a line needs two.
type Drawn = (String, String, String, Vec<[f64; 3]>);

/// A chart of one panel, as HTML for a page.
#[pyfunction]
#[pyo3(name = "chart")]
fn drawn(label: String, x: String, y: String, height: u32, series: Vec<Drawn>) -> PyResult<String> {
    let points = || series.iter().flat_map(|(.., points)| points);
    let across = padded(points().map(|point| point[0]));
    let reach = |(.., kind, points): &Drawn| {
        let of = |&[_, y, z]: &[f64; 3]| match kind.as_str() {
            "dots" => [y - z, y + z],
            "band" => [y, z],
            _ => [y, y],
        };
        points.iter().flat_map(of).collect::<Vec<f64>>()
    };
    let up = padded(series.iter().flat_map(reach).filter(|y| y.is_finite()));
    let drawn = series.into_iter().map(|(name, tone, kind, points)| {
        let line = || vec![points.iter().map(|point| [point[0], point[1]]).collect()];
        let shape = match kind.as_str() {
            "line" => Shape::Lines(line()),
            "dashes" => Shape::Dashes(line()),
            "band" => Shape::Band(points),
            "dots" => Shape::Dots(points),
            other => return Err(PyValueError::new_err(format!("{other}: dots, line, dashes or band"))),
        };
        let tone = match tone.as_str() {
            "before" => Tone::Before,
            "after" => Tone::After,
            "measured" => Tone::Measured,
            "third" => Tone::Third,
            _ => Tone::Ink,
        };
        Ok(Series::new(name, tone, shape))
    });
    let panel = Panel { height, y: Axis::linear(y, up), series: drawn.collect::<PyResult<_>>()? };
    let chart = Chart { label, x: Axis::linear(x, across), panels: vec![panel], windows: Vec::new() };
    Ok(chart.html())
}

/// Adds what belongs here to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(page, module)?)?;
    module.add_function(wrap_pyfunction!(drawn, module)?)
}
