//! Where the model before and the one after leave something: a map of time and frequency.

use chart::{Axis, Chart, Panel, Series, Shape, Tone};
use sysid::diagnosis::map::Cell;

/// A cell of so many times the background is of the full colour.
const FULL: f64 = 30.0;

/// The maps of one recording; the second only where the model was `changed`. `windows` are shaded.
pub fn picture(maps: &[Vec<Cell>; 2], recording: usize, changed: bool, windows: Vec<[f64; 2]>) -> Chart {
    let [before, after] = maps
        .each_ref()
        .map(|map| -> Vec<Cell> { map.iter().filter(|cell| cell.recording == recording).copied().collect() });
    let ends = |of: fn(&Cell) -> [f64; 2]| {
        let all = || before.iter().chain(&after).map(of);
        let low = all().map(|[low, _]| low).fold(f64::INFINITY, f64::min);
        low..all().map(|[_, high]| high).fold(f64::NEG_INFINITY, f64::max)
    };
    let (time, band) = (ends(|cell| cell.time_s), ends(|cell| cell.band_rad_s));
    let panel = |title: &str, map: &[Cell], tone: Tone| Panel {
        height: 130,
        y: Axis::logarithmic(format!("{title}: frequency, rad/s"), band.start.log10()..band.end.log10()),
        series: vec![Series::new("", tone, Shape::Cells(map.iter().map(shade).collect()))],
    };
    let panels = if changed {
        vec![
            panel("left by the model before", &before, Tone::Before),
            panel("left by the model after", &after, Tone::After),
        ]
    } else {
        vec![panel("left by the model", &before, Tone::After)]
    };
    Chart {
        label: "what is left over time and frequency".into(),
        x: Axis::linear("time, s", time),
        panels,
        windows,
    }
}

/// What the background alone may reach is left white.
fn shade(cell: &Cell) -> [f64; 5] {
    let ([from, to], [low, high]) = (cell.time_s, cell.band_rad_s);
    let dark = if cell.power > cell.chance { cell.power.ln() / FULL.ln() } else { 0.0 };
    [from, to, low.log10(), high.log10(), dark]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_chance_does_not_reach_is_coloured() {
        let cell =
            Cell { recording: 0, time_s: [0.0, 2.0], band_rad_s: [1.0, 10.0], power: 2.0, chance: 3.0 };
        assert_eq!(shade(&cell)[4], 0.0);
        assert_eq!(shade(&Cell { power: 30.0, ..cell }), [0.0, 2.0, 0.0, 1.0, 1.0]);
    }
}
