//! The pictures of one campaign.

use super::campaign::{Campaign, closed_loop_label, prbs_label};
use crate::Error;
use crate::canvas::{
    Area, Axes, BASELINE, EXTENDED, MEASURED, font, mesh, padded, px, standalone, svg, tick,
};
use plotters::prelude::*;
use sysid::identify::compare::Identification;

/// A further method.
const GREEN: RGBColor = RGBColor(0x2E, 0x9E, 0x5B);
/// And one more.
const PURPLE: RGBColor = RGBColor(0x8E, 0x5B, 0xC2);
/// The methods of the paper's table and their colours.
const METHODS: [(&str, RGBColor); 4] =
    [("LMS FIR + Kung", PURPLE), ("PI-MOESP", EXTENDED), ("grey-box ML", BASELINE), ("H∞ match", GREEN)];
/// Orders and their colours.
const ORDERS: [RGBColor; 5] = [EXTENDED, BASELINE, GREEN, PURPLE, MEASURED];
/// A gain below this is not drawn, dB.
const FLOOR_DB: f64 = -20.0;

struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    color: RGBColor,
    width: u32,
}

struct Chart {
    label: String,
    size: [u32; 2],
    x: &'static str,
    y: &'static str,
    log_x: bool,
    /// Dots instead of lines.
    dotted: bool,
    curves: Vec<Curve>,
    /// Vertical bars (x, low, high) with a dot at the third.
    bars: Vec<[f64; 4]>,
    /// (x, low, high), filled.
    band: Vec<[f64; 3]>,
}

/// All pictures with their file names.
pub fn all(campaign: &Campaign, found: &Identification) -> Result<Vec<(&'static str, String)>, Error> {
    let named: Vec<&str> = METHODS.iter().map(|(name, _)| *name).collect();
    let traces = |label: &str, names: &[&str]| traces(campaign, found, label, names);
    let charts = [
        ("figure6.svg", traces(&closed_loop_label(), &named)),
        ("figure7.svg", traces(&prbs_label(), &named)),
        ("figure8.svg", traces(&prbs_label(), &["PI-MOESP", "H∞ match"])),
        ("bode.svg", bode(campaign, found)),
        ("choice.svg", choice(found)),
    ];
    charts.into_iter().map(|(name, chart)| Ok((name, chart.draw()?))).collect()
}

fn traces(campaign: &Campaign, found: &Identification, label: &str, names: &[&str]) -> Chart {
    let mut curves = Vec::new();
    if let Some(place) = campaign.split.held_out.iter().find(|p| p.label == label) {
        let run = &campaign.data.runs[place.run];
        let timed = |values: &[f64]| -> Vec<(f64, f64)> {
            place.rows.clone().zip(values).map(|(k, v)| (run.time(k), *v)).collect()
        };
        let measured = run.rate.as_deref().unwrap_or_default();
        let points = timed(measured.get(place.rows.clone()).unwrap_or_default());
        curves.push(Curve { name: "measured".into(), points, color: MEASURED, width: 6 });
        for (name, color) in METHODS.iter().filter(|(name, _)| names.contains(name)) {
            let method = found.methods.iter().find(|m| m.name == *name);
            if let Some(values) = method.and_then(|m| m.simulated.get(label)) {
                curves.push(Curve { name: (*name).into(), points: timed(values), color: *color, width: 5 });
            }
        }
    }
    Chart {
        label: format!("section {label}: pitch rate measured and simulated"),
        size: [900, 340],
        x: "time, s",
        y: "pitch rate, rad/s",
        log_x: false,
        dotted: false,
        curves,
        bars: Vec::new(),
        band: Vec::new(),
    }
}

fn bode(campaign: &Campaign, found: &Identification) -> Chart {
    let step = campaign.data.runs.first().map_or(0.02, |run| run.step);
    let decibel = |gain: f64| 20.0 * gain.max(1e-9).log10();
    let shown: Vec<_> = found.response.iter().filter(|line| line.coherence > 0.1).collect();
    let bars = shown.iter().map(|line| {
        let reach = 1.96 * line.deviation;
        let [low, high] = [-reach, reach].map(|r| decibel(line.gain * r.exp()));
        [line.omega_rad_s, low.max(FLOOR_DB), high, decibel(line.gain)]
    });
    let omegas: Vec<f64> = (0..200).map(|k| 0.8 * 125.0_f64.powf(f64::from(k) / 199.0)).collect();
    let curves = METHODS.iter().filter_map(|(name, color)| {
        let model = found.methods.iter().find(|m| m.name == *name)?.model.as_ref()?;
        let gain = |omega: &f64| Some((*omega, decibel(model.frequency_response(*omega, step)?.norm())));
        let points = omegas.iter().filter_map(gain).filter(|p| p.1 > FLOOR_DB).collect();
        Some(Curve { name: (*name).into(), points, color: *color, width: 5 })
    });
    let band = found.hinf.iter().flat_map(|hinf| &hinf.gain_band);
    Chart {
        label: "gain from the command to the pitch rate".into(),
        size: [900, 400],
        x: "rad/s",
        y: "gain, dB (1/s)",
        log_x: true,
        dotted: false,
        curves: curves.collect(),
        bars: bars.collect(),
        band: band
            .map(|[omega, low, high]| [*omega, decibel(*low).max(FLOOR_DB), decibel(*high)])
            .filter(|b| b[2] > FLOOR_DB && b[0] <= 100.0)
            .collect(),
    }
}

fn choice(found: &Identification) -> Chart {
    let cells = found.subspace.as_ref().map_or(&[][..], |s| &s.cells);
    let curves = ORDERS.iter().enumerate().map(|(k, color)| {
        let own = cells.iter().filter(|cell| cell.order == k + 1);
        let points = own.filter_map(|cell| Some((cell.block_size as f64, cell.vaf_percent?))).collect();
        Curve { name: format!("n = {}", k + 1), points, color: *color, width: 5 }
    });
    Chart {
        label: "cross-validated VAF of PI-MOESP over block size and order".into(),
        size: [900, 300],
        x: "block size i",
        y: "VAF, %",
        log_x: false,
        dotted: true,
        curves: curves.collect(),
        bars: Vec::new(),
        band: Vec::new(),
    }
}

impl Chart {
    fn draw(&self) -> Result<String, Error> {
        Ok(standalone(&svg(self.size, &self.label, |area| {
            let (head, body) = area.split_vertically(px(26));
            self.legend(&head)?;
            self.panel(&body)
        })?))
    }

    /// Where x stands on the axis.
    fn place(&self, x: f64) -> f64 {
        if self.log_x { x.log10() } else { x }
    }

    fn legend(&self, area: &Area<'_>) -> Result<(), String> {
        let mut x = 66;
        for curve in &self.curves {
            let line = [(x, 13), (x + 22, 13)].map(|(x, y)| (px(x) as i32, px(y) as i32));
            area.draw(&PathElement::new(line, curve.color.stroke_width(px(2)))).map_err(|e| e.to_string())?;
            let at = (px(x + 28) as i32, px(7) as i32);
            area.draw(&Text::new(curve.name.as_str(), at, font(13.0))).map_err(|e| e.to_string())?;
            x += 60 + (7.2 * curve.name.chars().count() as f64) as u32;
        }
        Ok(())
    }

    fn panel(&self, area: &Area<'_>) -> Result<(), String> {
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let xs = points()
            .map(|p| self.place(p.0))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if xs.0 >= xs.1 {
            return Ok(());
        }
        let ys = padded(points().map(|p| p.1).chain(self.bars.iter().flat_map(|b| [b[1], b[2]])));
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(6))
            .margin_right(px(12))
            .margin_left(px(8))
            .x_label_area_size(px(34))
            .y_label_area_size(px(62))
            .build_cartesian_2d(xs.0..xs.1, ys.clone())
            .map_err(|e| e.to_string())?;
        let written = |x: &f64| if self.log_x { tick(&round(10.0_f64.powf(*x))) } else { tick(x) };
        mesh(&mut chart, &Axes { labels: [9, 6], x: self.x, y: self.y }, &written)?;
        let inside = |x: f64, y: f64| (self.place(x).clamp(xs.0, xs.1), y.clamp(ys.start, ys.end));
        let upper = self.band.iter().map(|b| inside(b[0], b[2]));
        let outline: Vec<(f64, f64)> =
            upper.chain(self.band.iter().rev().map(|b| inside(b[0], b[1]))).collect();
        if outline.len() > 2 {
            let area = Polygon::new(outline, EXTENDED.mix(0.15).filled());
            chart.draw_series([area]).map_err(|e| e.to_string())?;
        }
        for [x, low, high, middle] in &self.bars {
            let bar =
                PathElement::new(vec![inside(*x, *low), inside(*x, *high)], MEASURED.stroke_width(px(1)));
            chart.draw_series([bar]).map_err(|e| e.to_string())?;
            let dot = Circle::new(inside(*x, *middle), px(2), MEASURED.filled());
            chart.draw_series([dot]).map_err(|e| e.to_string())?;
        }
        for curve in &self.curves {
            let points = curve.points.iter().map(|(x, y)| inside(*x, *y));
            if self.dotted {
                let dots = points.map(|at| Circle::new(at, px(3), curve.color.filled()));
                chart.draw_series(dots).map_err(|e| e.to_string())?;
            } else {
                let line = LineSeries::new(points, curve.color.stroke_width(curve.width));
                chart.draw_series(line).map_err(|e| e.to_string())?;
            }
        }
        Ok(())
    }
}

/// Two significant digits.
fn round(x: f64) -> f64 {
    let unit = 10.0_f64.powf(x.abs().max(1e-12).log10().floor() - 1.0);
    (x / unit).round() * unit
}
