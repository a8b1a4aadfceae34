//! What all pages and pictures share: a style sheet, an SVG canvas, colours for light and dark, axes.

use crate::Error;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;

/// What all pages look like.
pub const STYLE: &str = include_str!("page.css");

/// plotters places points on whole pixels: drawn this many times larger and shown smaller, curves are smooth.
pub const SCALE: u32 = 4;

/// Text, axes.
pub const INK: RGBColor = RGBColor(0x3B, 0x43, 0x4C);
/// Grid lines.
pub const GRID: RGBColor = RGBColor(0xDD, 0xE2, 0xE8);
/// What was measured.
pub const MEASURED: RGBColor = RGBColor(0x8A, 0x95, 0xA1);
/// The model before.
pub const BASELINE: RGBColor = RGBColor(0xD9, 0x5F, 0x1E);
/// The model after.
pub const EXTENDED: RGBColor = RGBColor(0x0B, 0x66, 0xC3);

/// Style sheet that gives the colours above their dark counterparts: attributes of SVG elements yield to it.
pub const DARK_STYLE: &str = "\
@media (prefers-color-scheme: dark) {
  svg [fill=\"#3B434C\"] { fill: #C9D1D9 } svg [stroke=\"#3B434C\"] { stroke: #C9D1D9 }
  svg [fill=\"#DDE2E8\"] { fill: #30363D } svg [stroke=\"#DDE2E8\"] { stroke: #30363D }
  svg [fill=\"#8A95A1\"] { fill: #8B949E } svg [stroke=\"#8A95A1\"] { stroke: #8B949E }
  svg [fill=\"#D95F1E\"] { fill: #F0883E } svg [stroke=\"#D95F1E\"] { stroke: #F0883E }
  svg [fill=\"#0B66C3\"] { fill: #58A6FF } svg [stroke=\"#0B66C3\"] { stroke: #58A6FF }
}
";

/// A drawing area that writes into a string.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A chart over two linear axes.
pub type Plane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Draws an SVG picture of `size` (CSS pixels) for a page, with which it scales; `label` is for those who cannot see it.
pub fn svg(
    size: [u32; 2],
    label: &str,
    draw: impl FnOnce(&Area<'_>) -> Result<(), String>,
) -> Result<String, Error> {
    let failed =
        |what: String| Error::new(format!("a picture could not be drawn: {what}"), "leave out --report");
    let [width, height] = size.map(|s| s * SCALE);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
        draw(&area).map_err(failed)?;
        area.present().map_err(|e| failed(e.to_string()))?;
    }
    let [w, h] = size;
    let label = label.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    let (_, drawn) = text.split_once(">\n").unwrap_or(("", ""));
    Ok(format!(
        "<svg width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\">\n{drawn}"
    ))
}

/// Makes a picture of a page a file of its own, for light and dark.
pub fn standalone(picture: &str) -> String {
    let style = format!("<style>\ntext {{ font-family: system-ui, sans-serif }}\n{DARK_STYLE}</style>");
    let with_style = picture.replacen(">\n", &format!(">\n{style}\n"), 1);
    with_style.replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1)
}

/// A style for text of `size` CSS pixels.
pub fn font(size: f64) -> TextStyle<'static> {
    ("sans-serif", size * f64::from(SCALE)).into_font().color(&INK)
}

/// `n` CSS pixels on the enlarged canvas.
pub const fn px(n: u32) -> u32 {
    n * SCALE
}

/// What stands on the axes of a plane.
pub struct Axes<'a> {
    /// Number of labels along x and y, about.
    pub labels: [usize; 2],
    /// What x is, with its unit.
    pub x: &'a str,
    /// What y is, with its unit.
    pub y: &'a str,
}

/// Grid, axes and labels of a chart; `written` is how values of x are.
pub fn mesh(
    chart: &mut Plane<'_, '_>,
    axes: &Axes<'_>,
    written: &dyn Fn(&f64) -> String,
) -> Result<(), String> {
    chart
        .configure_mesh()
        .x_labels(axes.labels[0])
        .y_labels(axes.labels[1])
        .max_light_lines(0)
        .bold_line_style(GRID.stroke_width(3))
        .axis_style(INK.stroke_width(3))
        .label_style(font(12.0))
        .axis_desc_style(font(12.0))
        .x_label_formatter(&written)
        .y_label_formatter(&tick)
        .x_desc(axes.x)
        .y_desc(axes.y)
        .draw()
        .map_err(|e| e.to_string())
}

/// Shades windows of x over the whole height of a chart.
pub fn shade(
    chart: &mut Plane<'_, '_>,
    windows: &[[f64; 2]],
    span: &Range<f64>,
    range: &Range<f64>,
) -> Result<(), String> {
    for [from, to] in windows {
        let corners = [(from.max(span.start), range.start), (to.min(span.end), range.end)];
        if corners[0].0 < corners[1].0 {
            let shade = Rectangle::new(corners, EXTENDED.mix(0.08).filled());
            chart.draw_series([shade]).map_err(|e| e.to_string())?;
        }
    }
    Ok(())
}

/// A line of curves' names with their colours.
pub fn legend<'a>(
    area: &Area<'_>,
    curves: impl IntoIterator<Item = (&'a str, RGBColor)>,
) -> Result<(), String> {
    let mut x = 58;
    for (name, color) in curves {
        let line = [(x, 13), (x + 22, 13)].map(|(x, y)| (px(x) as i32, px(y) as i32));
        area.draw(&PathElement::new(line, color.stroke_width(px(2)))).map_err(|e| e.to_string())?;
        let at = (px(x + 28) as i32, px(7) as i32);
        area.draw(&Text::new(name, at, font(13.0))).map_err(|e| e.to_string())?;
        x += 56 + (6.1 * name.chars().count() as f64) as u32;
    }
    Ok(())
}

/// The range of some values with a margin of 6 % on either side; around 0 where there is nothing to see.
pub fn padded(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return -1.0..1.0;
    }
    let margin = (0.06 * (high - low)).max(1e-9 * (1.0 + high.abs()));
    low - margin..high + margin
}

/// A tick as people write it: true minus sign, no needless zeros.
pub fn tick(value: &f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    let shown = if rounded == 0.0 && value.abs() > 1e-12 {
        format!("{value:.1e}")
    } else {
        format!("{}", rounded + 0.0)
    };
    shown.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_plain() {
        assert_eq!(tick(&-0.5), "−0.5");
        assert_eq!(tick(&(0.1 + 0.2)), "0.3");
        assert_eq!(tick(&-0.0), "0");
    }

    #[test]
    fn ranges_never_collapse() {
        let range = padded([2.0, 2.0].into_iter());
        assert!(range.start < 2.0 && range.end > 2.0);
        assert_eq!(padded([f64::NAN].into_iter()), -1.0..1.0);
    }

    #[test]
    fn labels_cannot_break_out_of_the_picture() {
        let picture = svg([100, 50], "\"><script>", |_| Ok(())).unwrap();
        assert!(picture.starts_with("<svg width=\"100\" height=\"50\" viewBox"), "{picture}");
        assert!(picture.contains("aria-label=\"&quot;&gt;&lt;script&gt;\""), "{picture}");
    }
}
