//! The pictures of one campaign.

use super::campaign::{Campaign, closed_loop_label, prbs_label};
use chart::ticks::padded;
use chart::{Axis, Panel, Series, Shape, Tone};
use sysid::identify::compare::Identification;

/// The methods of the paper's table and their colours.
const METHODS: [(&str, Tone); 4] = [
    ("LMS FIR + Kung", Tone::Fourth),
    ("PI-MOESP", Tone::After),
    ("grey-box ML", Tone::Before),
    ("H∞ match", Tone::Third),
];
/// Orders and their colours.
const ORDERS: [Tone; 5] = [Tone::After, Tone::Before, Tone::Third, Tone::Fourth, Tone::Measured];
/// A gain below this is not drawn, dB.
const FLOOR_DB: f64 = -20.0;

struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    tone: Tone,
}

struct Chart {
    label: String,
    height: u32,
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
pub fn all(campaign: &Campaign, found: &Identification) -> Vec<(&'static str, String)> {
    let named: Vec<&str> = METHODS.iter().map(|(name, _)| *name).collect();
    let traces = |label: &str, names: &[&str]| traces(campaign, found, label, names);
    let charts = [
        ("figure6.svg", traces(&closed_loop_label(), &named)),
        ("figure7.svg", traces(&prbs_label(), &named)),
        ("figure8.svg", traces(&prbs_label(), &["PI-MOESP", "H∞ match"])),
        ("bode.svg", bode(campaign, found)),
        ("choice.svg", choice(found)),
    ];
    charts.into_iter().map(|(name, chart)| (name, chart.draw())).collect()
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
        curves.push(Curve { name: "measured".into(), points, tone: Tone::Measured });
        for (name, color) in METHODS.iter().filter(|(name, _)| names.contains(name)) {
            let method = found.methods.iter().find(|m| m.name == *name);
            if let Some(values) = method.and_then(|m| m.simulated.get(label)) {
                curves.push(Curve { name: (*name).into(), points: timed(values), tone: *color });
            }
        }
    }
    Chart {
        label: format!("section {label}: pitch rate measured and simulated"),
        height: 270,
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
        Some(Curve { name: (*name).into(), points, tone: *color })
    });
    let band = found.hinf.iter().flat_map(|hinf| &hinf.gain_band);
    Chart {
        label: "gain from the command to the pitch rate".into(),
        height: 330,
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
        Curve { name: format!("n = {}", k + 1), points, tone: *color }
    });
    Chart {
        label: "cross-validated VAF of PI-MOESP over block size and order".into(),
        height: 230,
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
    fn draw(&self) -> String {
        let place = |x: f64| if self.log_x { x.log10() } else { x };
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let xs = points()
            .map(|p| place(p.0))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let xs = if xs.0 < xs.1 { xs.0..xs.1 } else { 0.0..1.0 };
        let ys = padded(points().map(|p| p.1).chain(self.bars.iter().flat_map(|b| [b[1], b[2]])));
        let inside = |x: f64| place(x).clamp(xs.start, xs.end);
        let band = self.band.iter().map(|[x, low, high]| [inside(*x), *low, *high]).collect();
        let middles = self.bars.iter().map(|[x, _, _, middle]| [inside(*x), *middle, 0.0]).collect();
        let bars = self.bars.iter().map(|[x, low, high, _]| vec![[inside(*x), *low], [inside(*x), *high]]);
        let mut series = vec![
            Series::new("", Tone::After, Shape::Band(band)),
            Series::new("", Tone::Measured, Shape::Lines(bars.collect())),
            Series::new("", Tone::Measured, Shape::Dots(middles)),
        ];
        for curve in &self.curves {
            let points = curve.points.iter().map(|(x, y)| [place(*x), *y]);
            let shape = if self.dotted {
                Shape::Dots(points.map(|[x, y]| [x, y, 0.0]).collect())
            } else {
                Shape::Lines(vec![points.collect()])
            };
            series.push(Series::new(curve.name.as_str(), curve.tone, shape));
        }
        chart::Chart {
            label: self.label.clone(),
            x: Axis { title: self.x.into(), range: xs, logarithmic: self.log_x },
            panels: vec![Panel { height: self.height, y: Axis::linear(self.y, ys), series }],
            windows: Vec::new(),
        }
        .file(900)
    }
}
