//! A chart on a page and as a file.

use crate::marks::{HIGH, WIDE, marks};
use crate::ticks::{linear, logarithmic, written};
use crate::{Axis, Chart, Panel, Series, Tone, escaped};
use std::fmt::Write;

/// Space left and right of a plane, CSS pixels.
const SIDES: [u32; 2] = [56, 12];
/// Lines of text above a plane and below it, CSS pixels.
const LINES: [u32; 2] = [20, 24];
/// About as many ticks on x.
const ACROSS: usize = 9;
/// CSS pixels between ticks on y, about.
const APART: usize = 34;

impl Chart {
    /// The chart as a part of a page that has [`STYLE`](crate::STYLE) and, to be moved, [`SCRIPT`](crate::SCRIPT).
    pub fn html(&self) -> String {
        let mut text =
            format!("<div class=\"chart\" role=\"group\" aria-label=\"{}\">", escaped(&self.label));
        text += "<div class=\"legend\">";
        for (name, tone) in self.names() {
            let _ = write!(
                text,
                "<button type=\"button\" class=\"switch {}\" aria-pressed=\"true\">{}</button>",
                tone.class(),
                escaped(name)
            );
        }
        text += "</div>";
        for panel in &self.panels {
            let [y, x] = [&panel.y.range, &self.x.range].map(|r| format!("{} {}", r.start, r.end));
            let _ = write!(
                text,
                "<div class=\"quantity\">{title}</div><div class=\"panel\"><svg class=\"plot\" height=\"{height}\" role=\"img\" tabindex=\"0\" \
                 aria-label=\"{title} against {x_title}\" data-y=\"{y}\" data-x=\"{x}\" data-log=\"{}{}\">{}</svg></div>",
                if self.x.logarithmic { "x" } else { "" },
                if panel.y.logarithmic { "y" } else { "" },
                self.plane(panel),
                title = escaped(&panel.y.title),
                height = panel.height,
                x_title = escaped(&self.x.title),
            );
        }
        let _ = write!(text, "<div class=\"horizontal\">{}</div></div>", escaped(&self.x.title));
        text
    }

    /// The chart as a file of its own, `width` CSS pixels wide.
    pub fn file(&self, width: u32) -> String {
        let mut body = String::new();
        let mut top = 0;
        let mut left = SIDES[0];
        for (name, tone) in self.names() {
            let long = 40 + 7 * name.chars().count() as u32;
            if left > SIDES[0] && left + long > width {
                (left, top) = (SIDES[0], top + LINES[0]);
            }
            let _ = write!(
                body,
                "<g class=\"marks\"><path class=\"bold {}\" d=\"M{left} {line}h20\"/></g><text class=\"key\" x=\"{}\" y=\"{}\">{}</text>",
                tone.class(),
                left + 26,
                top + 15,
                escaped(name),
                line = top + 11,
            );
            left += long;
        }
        top += if left > SIDES[0] { LINES[0] + 4 } else { 0 };
        for panel in &self.panels {
            let _ = write!(
                body,
                "<text class=\"title\" x=\"{}\" y=\"{}\">{}</text><svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" overflow=\"visible\">{}</svg>",
                SIDES[0],
                top + 14,
                escaped(&panel.y.title),
                SIDES[0],
                top + LINES[0],
                width.saturating_sub(SIDES[0] + SIDES[1]),
                panel.height,
                self.plane(panel),
            );
            top += LINES[0] + panel.height + LINES[1];
        }
        let _ = write!(
            body,
            "<text class=\"title x\" x=\"{}\" y=\"{}\">{}</text>",
            SIDES[0] + width.saturating_sub(SIDES[0] + SIDES[1]) / 2,
            top + 10,
            escaped(&self.x.title)
        );
        let (height, label) = (top + LINES[0], escaped(&self.label));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
             aria-label=\"{label}\"><title>{label}</title><style>{}</style>{body}</svg>\n",
            include_str!("colours.css")
        )
    }

    /// Names of the legend with their colours, each once.
    fn names(&self) -> Vec<(&str, Tone)> {
        let mut names: Vec<(&str, Tone)> = Vec::new();
        for Series { name, tone, .. } in self.panels.iter().flat_map(|panel| &panel.series) {
            if !name.is_empty() && !names.iter().any(|(known, _)| known == name) {
                names.push((name, *tone));
            }
        }
        names
    }

    /// Grid and marks: places in per cent, so that they fit a plane of any width.
    fn plane(&self, panel: &Panel) -> String {
        let mut grid = String::new();
        for (k, (share, text)) in ticks(&self.x, ACROSS).into_iter().enumerate() {
            let odd = if k % 2 == 1 { " odd" } else { "" };
            let at = format!("{:.2}%", 100.0 * share);
            let _ = write!(
                grid,
                "<line x1=\"{at}\" x2=\"{at}\" y1=\"0\" y2=\"100%\"/><text class=\"x{odd}\" x=\"{at}\" y=\"100%\" dy=\"18\">{text}</text>"
            );
        }
        for (share, text) in ticks(&panel.y, (panel.height as usize / APART).max(2)) {
            let at = format!("{:.2}%", 100.0 * (1.0 - share));
            let zero = if text == "0" && !panel.y.logarithmic { " class=\"zero\"" } else { "" };
            let _ = write!(
                grid,
                "<line{zero} x1=\"0\" x2=\"100%\" y1=\"{at}\" y2=\"{at}\"/><text class=\"y\" x=\"-6\" y=\"{at}\" dy=\"4\">{text}</text>"
            );
        }
        format!(
            "<g class=\"grid\">{grid}</g><svg class=\"marks\" width=\"100%\" height=\"100%\" viewBox=\"0 0 {WIDE} {HIGH}\" \
             preserveAspectRatio=\"none\">{}</svg>",
            marks(&self.x, panel, &self.windows)
        )
    }
}

/// Ticks of an axis: where, as a share of the range, and what stands there.
fn ticks(axis: &Axis, count: usize) -> Vec<(f64, String)> {
    let range = &axis.range;
    let at = if axis.logarithmic { logarithmic(range, count) } else { linear(range, count) };
    let value = |v: f64| written(if axis.logarithmic { 10_f64.powf(v) } else { v });
    at.into_iter().map(|v| ((v - range.start) / (range.end - range.start), value(v))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;

    fn chart() -> Chart {
        let line = vec![vec![[0.0, 0.0], [1.0, 0.5], [2.0, f64::NAN], [3.0, 9.0], [4.0, 1.0]]];
        let series = vec![
            Series::new("a<b", Tone::Before, Shape::Lines(line)),
            Series::new("dots", Tone::Ink, Shape::Dots(vec![[1.0, 0.5, 0.1], [2.0, 0.5, 0.0]])),
            Series::new("", Tone::After, Shape::Band(vec![[0.0, 0.1, 0.2], [4.0, 0.1, 0.3]])),
        ];
        let panel = Panel { height: 200, y: Axis::linear("rate, rad/s", 0.0..1.0), series };
        Chart {
            label: "\"><script>".into(),
            x: Axis::linear("time, s", 0.0..4.0),
            panels: vec![panel],
            windows: vec![[1.0, 9.0], [7.0, 8.0]],
        }
    }

    #[test]
    fn a_chart_of_a_page_has_its_marks_where_they_belong() {
        let page = chart().html();
        assert!(
            page.contains("M0 10000l0 0 5000 -5000M15000 -10000l0 0 5000 10000"),
            "broken and cut off: {page}"
        );
        assert!(page.contains("M5000 5000h0M10000 5000h0") && page.contains("M5000 6000V4000"));
        assert!(
            page.contains("x=\"5000\" y=\"0\" width=\"15000\"")
                && page.matches("class=\"window\"").count() == 1
        );
        assert!(page.contains("a&lt;b</button>") && page.matches("<button").count() == 2);
        assert!(!page.contains("<script>"));
    }

    #[test]
    fn a_chart_as_a_file_says_what_its_axes_are() {
        let file = chart().file(440);
        assert!(file.starts_with("<svg xmlns=") && file.contains("prefers-color-scheme"));
        assert!(file.contains(">rate, rad/s<") && file.contains(">time, s<") && file.contains(">a&lt;b<"));
        assert!(file.contains("width=\"372\" height=\"200\""));
    }

    #[test]
    fn logarithms_are_written_as_what_they_are_of() {
        let mut chart = chart();
        chart.x = Axis::logarithmic("rad/s", -1.0..2.0);
        let page = chart.html();
        assert!(["0.1", "1", "10"].iter().all(|text| page.contains(&format!(">{text}</text>"))), "{page}");
        assert!(page.contains("data-log=\"x\""));
    }
}
