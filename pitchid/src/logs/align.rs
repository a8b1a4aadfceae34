//! Input, rate and angle of a log on one clock.
//!
//! The clock is the rate's: u_k is the mean over [t_k, t_k+1) of the input held from each of its stamps to the next,
//! θ_k lies on the straight line between its neighbours. An input that is logged much more slowly than the rate gives
//! the clock instead, and q_k is the mean of the rate over one step T around t_k: nothing faster than the clock folds
//! back. Rows for which a channel is silent for more than three of its periods are left out: they become gaps.

use flight_logs::axes::{LEAST_HZ, Series};
use std::f64::consts::{PI, TAU};

/// Steps of the input over those of the rate from which the input gives the clock.
const SLOWER: f64 = 1.6;
/// Periods of a channel without a row that are a gap.
const GAP: f64 = 3.5;
/// Share of rows with stamps out of order up to which the others are used.
const DISORDER: f64 = 0.01;

/// The channels on one clock, rows that lack one left out.
#[derive(Debug, Default)]
pub struct Aligned {
    /// Times of the rows, s: the clock's own stamps.
    pub t: Vec<f64>,
    /// Input.
    pub input: Vec<f64>,
    /// Rate.
    pub rate: Vec<f64>,
    /// Angle, unwrapped.
    pub angle: Option<Vec<f64>>,
    /// What was done, for people.
    pub notes: Vec<String>,
}

/// Puts the channels onto one clock; `keep_angle` uses also an angle that is logged slowly.
///
/// # Errors
/// A channel of fewer than three rows, or with stamps out of order in more than one of a hundred: in words.
pub fn align(
    input: &Series,
    rate: &Series,
    angle: Option<&Series>,
    keep_angle: bool,
) -> Result<Aligned, String> {
    let mut notes = Vec::new();
    let input = forward(input, "input", &mut notes)?;
    let rate = forward(rate, "rate", &mut notes)?;
    let (input_step, rate_step) = (median_step(&input.time_s), median_step(&rate.time_s));
    let slow = input_step > SLOWER * rate_step;
    let (clock, step) = if slow { (&input.time_s, input_step) } else { (&rate.time_s, rate_step) };
    if slow {
        notes.push(format!(
            "the input is logged at {:.1} Hz, the rate at {:.1} Hz: the rate was averaged over {:.1} ms around each \
             input; what the controller asked for in between is not in the log",
            1.0 / input_step,
            1.0 / rate_step,
            1e3 * input_step
        ));
    }
    let angle = match angle.map(|angle| forward(angle, "angle", &mut notes)).transpose()? {
        Some(angle) if !keep_angle && median_step(&angle.time_s) > (SLOWER * step).max(1.0 / LEAST_HZ) => {
            notes.push(format!(
                "the angle is logged at {:.1} Hz only, and was left out; --column theta_rad=angle uses it",
                1.0 / median_step(&angle.time_s)
            ));
            None
        }
        angle => angle.map(|Series { time_s, values }| Series { time_s, values: unwrapped(&values) }),
    };
    let mut aligned = Aligned { angle: angle.as_ref().map(|_| Vec::new()), notes, ..Aligned::default() };
    for (k, &t) in clock.iter().enumerate() {
        let next = *clock.get(k + 1).filter(|next| **next - t <= GAP * step).unwrap_or(&(t + step));
        let q = if slow { mean_around(&rate, t, step, rate_step) } else { Some(rate.values[k]) };
        let Some((u, q)) = mean_held(&input, t, next, input_step).zip(q) else { continue };
        if let (Some(angle), Some(values)) = (&angle, &mut aligned.angle) {
            let Some(theta) = between(angle, t) else { continue };
            values.push(theta);
        }
        aligned.t.push(t);
        aligned.input.push(u);
        aligned.rate.push(q);
    }
    Ok(aligned)
}

/// A channel beside the axis at the times `clock`: the mean over the step where it is `held` or logged much faster, else on the
/// straight line; where it is silent, its nearest row, as it costs the axis none. `None` of a channel that is slower than the
/// clock, unless it is `slow` by nature, and of one whose stamps say nothing.
pub fn beside(clock: &[f64], series: &Series, held: bool, slow: bool) -> Option<Vec<f64>> {
    let series = forward(series, "", &mut Vec::new()).ok()?;
    let (step, period) = (median_step(clock), median_step(&series.time_s));
    if !slow && period > SLOWER * step {
        return None;
    }
    let nearest = |t: f64| {
        let next = series.time_s.partition_point(|&stamp| stamp < t).min(series.time_s.len() - 1);
        let last = next.saturating_sub(1);
        let nearer = if t - series.time_s[last] < series.time_s[next] - t { last } else { next };
        series.values[nearer]
    };
    let at = |t: f64| match held {
        true => mean_held(&series, t, t + step, period),
        false if step > SLOWER * period => mean_around(&series, t, step, period),
        false => between(&series, t),
    };
    Some(clock.iter().map(|&t| at(t).unwrap_or_else(|| nearest(t))).collect())
}

/// The rows whose stamps grow.
fn forward(series: &Series, what: &str, notes: &mut Vec<String>) -> Result<Series, String> {
    let mut kept = Series::default();
    for (&t, &value) in series.time_s.iter().zip(&series.values) {
        if kept.time_s.last().is_none_or(|last| t > *last) {
            kept.time_s.push(t);
            kept.values.push(value);
        }
    }
    let (all, dropped) = (series.time_s.len(), series.time_s.len() - kept.time_s.len());
    if dropped as f64 > DISORDER * all as f64 {
        return Err(format!(
            "the clock of the {what} stands still or runs backwards at {dropped} of {all} rows"
        ));
    }
    if kept.time_s.len() < 3 {
        return Err(format!("the {what} has {} rows", kept.time_s.len()));
    }
    if dropped > 0 {
        notes.push(format!("{dropped} rows of the {what} were left out: their stamps do not grow"));
    }
    Ok(kept)
}

/// Median of the differences of growing stamps.
pub fn median_step(t: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Mean over [from, to) of the values held from stamp to stamp.
fn mean_held(series: &Series, from: f64, to: f64, period: f64) -> Option<f64> {
    let mut at = series.time_s.partition_point(|&t| t <= from).checked_sub(1)?;
    if from - series.time_s[at] > GAP * period {
        return None;
    }
    let (mut sum, mut start) = (0.0, from);
    while let Some(&end) = series.time_s.get(at + 1).filter(|&&end| end < to) {
        sum += series.values[at] * (end - start);
        (at, start) = (at + 1, end);
    }
    Some((sum + series.values[at] * (to - start)) / (to - from))
}

/// Mean of the rows within half a `step` of `t`, where at least half of those that belong there are there.
fn mean_around(series: &Series, t: f64, step: f64, period: f64) -> Option<f64> {
    let place = |time: f64| series.time_s.partition_point(|&stamp| stamp < time);
    let rows = &series.values[place(t - 0.5 * step)..place(t + 0.5 * step)];
    (rows.len() as f64 >= 0.5 * step / period).then(|| rows.iter().sum::<f64>() / rows.len() as f64)
}

/// The last value at `t` or before, where the series is not silent there.
pub fn last_before(series: &Series, t: f64) -> Option<f64> {
    let last = series.time_s.partition_point(|&stamp| stamp <= t).checked_sub(1)?;
    (t - series.time_s[last] <= GAP * median_near(&series.time_s, last)).then(|| series.values[last])
}

/// The value at `t` on the straight line between its neighbours.
pub fn between(series: &Series, t: f64) -> Option<f64> {
    let next = series.time_s.partition_point(|&stamp| stamp < t);
    let after = *series.time_s.get(next)?;
    if after == t {
        return Some(series.values[next]);
    }
    let last = next.checked_sub(1)?;
    let before = series.time_s[last];
    let near = after - before <= GAP * median_near(&series.time_s, last);
    near.then(|| {
        let part = (t - before) / (after - before);
        series.values[last] + part * (series.values[next] - series.values[last])
    })
}

/// Median step among the dozen around a row.
fn median_near(t: &[f64], row: usize) -> f64 {
    median_step(&t[row.saturating_sub(6)..(row + 8).min(t.len())])
}

/// An angle (rad) without jumps by a whole turn.
fn unwrapped(values: &[f64]) -> Vec<f64> {
    let (mut turns, mut last) = (0.0, None);
    let unwrap = |&value: &f64| {
        if let Some(last) = last {
            let change: f64 = value - last;
            if change.abs() > PI {
                turns -= TAU * change.signum();
            }
        }
        last = Some(value);
        value + turns
    };
    values.iter().map(unwrap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(count: u32, step: f64, shift: f64, value: impl Fn(f64) -> f64) -> Series {
        let time_s: Vec<f64> = (0..count).map(|k| 100.0 + shift + step * f64::from(k)).collect();
        let values = time_s.iter().map(|&t| value(t)).collect();
        Series { time_s, values }
    }

    #[test]
    fn an_input_stamped_just_after_the_rate_acts_from_that_row_on() {
        let input = series(200, 0.004, 0.000_02, |t| if t < 100.4 { 0.0 } else { 1.0 });
        let aligned = align(&input, &series(200, 0.004, 0.0, |t| t), None, false).unwrap();
        let row = aligned.t.iter().position(|&t| t > 100.3999).unwrap();
        assert!(aligned.input[row - 1].abs() < 1e-9 && (aligned.input[row] - 0.995).abs() < 1e-3);
        assert!(aligned.notes.is_empty(), "{:?}", aligned.notes);
    }

    #[test]
    fn a_slow_input_gives_the_clock_and_nothing_folds_back() {
        // 47 Hz would show as 3 Hz at 50 Hz
        let fast = |t: f64| (3.0 * t).sin() + 2.0 * (TAU * 47.0 * t).sin();
        let rate = series(5000, 0.001, 0.0, fast);
        let aligned = align(&series(240, 0.02, 0.1, f64::cos), &rate, None, false).unwrap();
        assert_eq!((aligned.t[3], aligned.input[3]), (100.16, 100.16_f64.cos()));
        let worst = aligned.t.iter().zip(&aligned.rate).map(|(t, q)| (q - (3.0 * t).sin()).abs());
        assert!(worst.fold(0.0, f64::max) < 0.2, "{:?}", &aligned.rate[..5]);
        assert!(aligned.notes[0].contains("averaged over 20.0 ms"), "{:?}", aligned.notes);
    }

    #[test]
    fn silence_of_a_channel_is_a_gap() {
        let mut angle = series(400, 0.004, 0.0, |t| t);
        angle.time_s.drain(100..120);
        angle.values.drain(100..120);
        let mut input = series(400, 0.004, 0.0, |t| t);
        input.time_s.drain(300..320);
        input.values.drain(300..320);
        let aligned = align(&input, &series(400, 0.004, 0.0, |t| t), Some(&angle), false).unwrap();
        let gaps = aligned.t.windows(2).filter(|pair| pair[1] - pair[0] > 0.014).count();
        assert_eq!((gaps, aligned.t.len()), (2, 400 - 20 - 17));
        assert!(aligned.angle.unwrap().iter().zip(&aligned.t).all(|(theta, t)| (theta - t).abs() < 1e-9));
    }

    #[test]
    fn slow_angles_are_left_out_and_turns_are_counted() {
        let rate = || series(2000, 0.004, 0.0, |_| 2.0);
        let wrapped = |t: f64| (2.0 * t + PI).rem_euclid(TAU) - PI;
        let slow = |keep| align(&rate(), &rate(), Some(&series(160, 0.05, 0.0, wrapped)), keep).unwrap();
        assert!(slow(false).angle.is_none() && slow(false).notes[0].contains("20.0 Hz"));
        let angle = slow(true).angle.unwrap();
        assert!(angle.windows(2).all(|pair| (pair[1] - pair[0] - 0.008).abs() < 1e-6));
    }

    #[test]
    fn what_stands_beside_costs_no_row() {
        let clock: Vec<f64> = (0..100).map(|k| 100.0 + 0.01 * f64::from(k)).collect();
        let mut rate = series(100, 0.01, 0.0, |t| t);
        rate.time_s.drain(40..60);
        rate.values.drain(40..60);
        let found = beside(&clock, &rate, false, false).unwrap();
        assert!((found[10] - clock[10]).abs() < 1e-9);
        assert_eq!([found[45], found[55]], [rate.values[39], rate.values[40]]);
        let battery = series(10, 0.1, 0.0, |t| t);
        assert!(beside(&clock, &battery, false, false).is_none());
        assert!((beside(&clock, &battery, false, true).unwrap()[55] - 100.55).abs() < 1e-9);
        assert!(beside(&clock, &series(2, 0.01, 0.0, |t| t), false, true).is_none());
    }

    #[test]
    fn clocks_that_run_backwards_are_refused() {
        let rate = series(200, 0.004, 0.0, |t| t);
        let mut input = rate.clone();
        input.time_s[100..110].fill(3.0);
        assert!(align(&input, &rate, None, false).unwrap_err().contains("10 of 200"));
        assert!(align(&series(2, 0.004, 0.0, |t| t), &rate, None, false).is_err());
    }
}
