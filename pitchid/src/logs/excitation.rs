//! Where an input moves, and how fast.

use super::align::median_step;
use flight_logs::axes::{LEAST_MOTION_RAD_S, Series};
use serde::Serialize;
use std::ops::Range;
use sysid::validate::coherence::coherence;

/// Length of the pieces that are judged, s.
const PIECE_S: f64 = 1.0;
/// Rows that a piece needs.
const LEAST_ROWS: usize = 8;
/// Shortest span that is told, s.
const SHORTEST_S: f64 = 3.0;
/// Share of the motion of lively pieces (nine of ten move less) from which a piece counts as excited.
const LIVELY: f64 = 0.25;
/// Shares of the power of the input that lie below the ends of its band.
const BAND: [f64; 2] = [0.1, 0.9];

/// A stretch of time in which the input moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Span {
    /// First and last time, s.
    pub time_s: [f64; 2],
    /// Standard deviation of the input.
    pub input_deviation: f64,
    /// Standard deviation of the rate, rad/s, where it is known.
    pub rate_deviation: Option<f64>,
    /// Below its ends lie 10 % and 90 % of the input's power, rad/s; `None` where the span is too short to tell.
    pub band_rad_s: Option<[f64; 2]>,
}

/// The spans in which input and rate move, in order of time; without a rate the input decides alone.
pub fn spans(input: &Series, rate: Option<&Series>) -> Vec<Span> {
    let (Some(&start), Some(&end)) = (input.time_s.first(), input.time_s.last()) else { return Vec::new() };
    let pieces = ((end - start) / PIECE_S).floor().clamp(0.0, 1e6) as usize;
    let piece = |k: usize| [k, k + 1].map(|k| start + PIECE_S * k as f64);
    let motion: Vec<f64> = (0..pieces).map(|k| deviation(input, piece(k))).collect();
    let mut sorted = motion.clone();
    sorted.sort_by(f64::total_cmp);
    let Some(lively) = sorted.get(sorted.len() * 9 / 10).map(|most| LIVELY * most) else { return Vec::new() };
    let moves = |k: usize| {
        motion[k] > 0.0
            && motion[k] >= lively
            && rate.is_none_or(|rate| deviation(rate, piece(k)) >= LEAST_MOTION_RAD_S)
    };
    let mut found: Vec<[f64; 2]> = Vec::new();
    for [from, to] in (0..pieces).filter(|&k| moves(k)).map(piece) {
        match found.last_mut() {
            Some(last) if from - last[1] <= 1.5 * PIECE_S => last[1] = to,
            _ => found.push([from, to]),
        }
    }
    found.retain(|[from, to]| to - from >= SHORTEST_S - 1e-6);
    let span = |time_s: [f64; 2]| Span {
        time_s,
        input_deviation: deviation(input, time_s),
        rate_deviation: rate.map(|rate| deviation(rate, time_s)),
        band_rad_s: band(input, time_s),
    };
    found.into_iter().map(span).collect()
}

fn rows(series: &Series, [from, to]: [f64; 2]) -> Range<usize> {
    let place = |time: f64| series.time_s.partition_point(|&t| t < time);
    place(from)..place(to)
}

fn inside(series: &Series, span: [f64; 2]) -> &[f64] {
    series.values.get(rows(series, span)).unwrap_or_default()
}

/// Standard deviation of the values in a span; 0 where they are few.
fn deviation(series: &Series, span: [f64; 2]) -> f64 {
    let values = inside(series, span);
    if values.len() < LEAST_ROWS {
        return 0.0;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

fn band(series: &Series, span: [f64; 2]) -> Option<[f64; 2]> {
    let values = inside(series, span);
    let lines = coherence(&[[values, values]], median_step(series.time_s.get(rows(series, span))?));
    // power between each line and the next
    let power: Vec<f64> = lines
        .windows(2)
        .map(|pair| {
            0.5 * (pair[0].output_share + pair[1].output_share) * (pair[1].omega_rad_s - pair[0].omega_rad_s)
        })
        .collect();
    let whole: f64 = power.iter().sum();
    let end = |share: f64| {
        let mut below = 0.0;
        let at = power.iter().position(|power| {
            below += power;
            below >= share * whole
        })?;
        Some((lines[at].omega_rad_s * lines[at + 1].omega_rad_s).sqrt())
    };
    Some([end(BAND[0])?, end(BAND[1])?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moving_part_and_its_band_are_found() {
        let time_s: Vec<f64> = (0..12_000).map(|k| 50.0 + 0.005 * f64::from(k)).collect();
        let wave = |t: &f64| if (70.0..85.0).contains(t) { (9.0 * t).sin() } else { 0.01 * (40.0 * t).sin() };
        let input = Series { values: time_s.iter().map(wave).collect(), time_s };
        let found = spans(&input, None);
        assert_eq!(found.len(), 1, "{found:?}");
        let [from, to] = found[0].time_s;
        assert!((from - 70.0).abs() < 1.1 && (to - 85.0).abs() < 1.1, "{found:?}");
        let [low, high] = found[0].band_rad_s.unwrap();
        assert!(low > 6.5 && low <= high && high < 12.0, "{low} {high}");
        let still = Series { values: vec![0.001; input.time_s.len()], time_s: input.time_s.clone() };
        assert_eq!(spans(&input, Some(&still)), Vec::new(), "the craft stands still");
        assert_eq!(spans(&Series::default(), None), Vec::new());
    }
}
