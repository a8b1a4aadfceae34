//! Outputs that were smoothed both ways in time after they were measured: by a spline, by a filter that was run forwards and
//! backwards, by an interpolation of slower rows.
//!
//! ```text
//! V(n): what the rows n, 2n, ... 8n before a row do not tell of it, mean square        V ~ n^a
//! ```
//!
//! A moment that is white makes a = 1 of the rate that it moves, one behind a lag, or a command in steps, a = 3, and what a
//! sensor adds makes it less. Of the recordings of real rigs that this was tried on, none has more than 3.2 from one row to
//! two, and a simulation without any noise up to 4.2; a smoothed one, whose rows follow from each other to their last digits,
//! has 5 to 12. The likelihood of one row after another is then that of the smoothing: gains come out at a hundredth of what
//! they are, with narrow intervals. Rows as far apart as news comes are what was measured.

use super::{Dataset, Run, Smoothing, decorrelation};
use crate::linalg::least_squares::least_squares;
use nalgebra::DVector;

/// Rows of the past that are asked.
const PAST: usize = 8;
/// Exponent a from one row to two from which on an output was smoothed.
const SMOOTHED: f64 = 4.5;
/// Exponent above which the next row brings no news of an output where one was smoothed.
const NO_NEWS: f64 = 3.5;
/// Fewest rows that are asked, as far from each other as those that tell of them.
const FEWEST: usize = 40;
/// Rows of a run that say enough.
const ENOUGH: usize = 50_000;
const RATE: &str = "the rate";
const ANGLE: &str = "the angle";

impl Dataset {
    /// Leaves out a smoothed output beside one that is not, and of two that are, both made of one measurement, the angle, which hides
    /// most. Answers how many rows, each of `base` samples, make one that brings news: 1 where nothing is smoothed in what is left.
    pub(super) fn leave_out_smoothed(&mut self, base: usize) -> usize {
        let of = |signal: fn(&Run) -> Option<Vec<f64>>| -> Option<Vec<Vec<f64>>> {
            self.runs.iter().map(signal).collect()
        };
        let is_smoothed =
            |signals: &Vec<Vec<f64>>| exponent(signals, base, 1).is_some_and(|exponent| exponent > SMOOTHED);
        let (rates, slopes) = (of(|run| run.rate.clone()), of(Run::slope_of_angle));
        if ![&rates, &slopes].into_iter().flatten().any(is_smoothed) {
            return 1;
        }
        // Under an input whose rows follow from each other, as a slow sine's do, so may those of the motion.
        if of(|run| Some(run.u.clone())).as_ref().is_some_and(is_smoothed) {
            return 1;
        }
        let rows = |signals: Option<Vec<Vec<f64>>>| signals.map(|signals| rows_between_news(&signals, base));
        let (left_out, rows) = match (rows(rates), rows(slopes)) {
            (Some(rate), Some(angle)) if angle > 1 => {
                (Some(ANGLE), if rate > 1 { rate.max(angle) } else { 1 })
            }
            (Some(rate), Some(_)) => ((rate > 1).then_some(RATE), 1),
            (rate, angle) => (None, rate.or(angle).unwrap_or(1)),
        };
        self.has_angle &= left_out != Some(ANGLE);
        self.has_rate &= left_out != Some(RATE);
        for run in &mut self.runs {
            run.angle = run.angle.take().filter(|_| self.has_angle);
            run.rate = run.rate.take().filter(|_| self.has_rate);
        }
        if left_out.is_some() || rows > 1 {
            self.smoothing = Some(Smoothing { left_out, in_use: rows > 1 });
        }
        rows
    }
}

/// Rows of `base` samples from one to the next that brings news, as far as they still tell of each other; 1 where each does.
fn rows_between_news(signals: &[Vec<f64>], base: usize) -> usize {
    let most = decorrelation(signals) / base;
    let brings_none =
        |rows: &usize| exponent(signals, base, *rows).is_some_and(|exponent| exponent > NO_NEWS);
    (1..most).take_while(brings_none).last().map_or(1, |rows| rows + 1)
}

/// Exponent a of V from `rows` rows of `base` samples to one more.
fn exponent(signals: &[Vec<f64>], base: usize, rows: usize) -> Option<f64> {
    let (own, next) = (news(signals, base * rows)?, news(signals, base * (rows + 1))?);
    Some((next / own).ln() / ((rows + 1) as f64 / rows as f64).ln())
}

/// The row `apart` before row `k`, the difference of that and the one before it, and so on.
fn differences(signal: &[f64], k: usize, apart: usize) -> [f64; PAST] {
    let mut past: [f64; PAST] = core::array::from_fn(|i| signal[k - apart * (i + 1)]);
    for order in 1..PAST {
        for i in (order..PAST).rev() {
            past[i] = past[i - 1] - past[i];
        }
    }
    past
}

/// Mean square of what the rows `apart`, 2 `apart`, ... before a row do not tell of it. Asked by their differences, each in
/// its own size: of a smooth signal the rows themselves are one and the same.
fn news(signals: &[Vec<f64>], apart: usize) -> Option<f64> {
    let rows = || {
        signals.iter().flat_map(|signal| {
            let row = move |k: usize| (differences(signal, k, apart), signal[k] - signal[k - apart]);
            (PAST * apart..signal.len().min(ENOUGH)).map(row)
        })
    };
    let (mut count, mut squares) = (0_usize, [0.0; PAST]);
    for (past, _) in rows() {
        count += 1;
        squares.iter_mut().zip(past).for_each(|(sum, x)| *sum += x * x);
    }
    if count < FEWEST * apart {
        return None;
    }
    let sizes = squares.map(|sum| (sum / count as f64).sqrt().max(f64::MIN_POSITIVE));
    let scaled = |past: [f64; PAST]| {
        let own = past.into_iter().zip(sizes).map(|(x, size)| x / size);
        DVector::from_iterator(PAST + 1, own.chain([1.0]))
    };
    let weights = least_squares(PAST + 1, rows().map(|(past, step)| (scaled(past), step)))?;
    let left = rows().map(|(past, step)| (step - weights.dot(&scaled(past))).powi(2)).sum::<f64>();
    Some(left / count as f64).filter(|news| *news > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::data_checks::fixture::{Flight, STEP, flight, read, smoothed};

    fn data(flight: &Flight) -> Dataset {
        Dataset::new(&[flight.recording()]).unwrap()
    }

    /// The signal behind a filter of two poles, as a board runs it.
    fn filtered(signal: &[f64]) -> Vec<f64> {
        let passed = 1.0 - (-STEP / 0.03_f64).exp();
        let once = |s: Vec<f64>| -> Vec<f64> {
            s.iter()
                .scan(s[0], |y, x| {
                    *y += passed * (x - *y);
                    Some(*y)
                })
                .collect()
        };
        once(once(signal.to_vec()))
    }

    #[test]
    fn neither_a_flight_nor_what_a_board_filters_was_smoothed() {
        for seed in 1..6 {
            let flown = flight(seed, 0.0);
            assert_eq!(data(&flown).smoothing, None, "{seed}");
            let boards = Flight { q: filtered(&flown.q), theta: filtered(&flown.theta), ..flown };
            assert_eq!(data(&boards).smoothing, None, "{seed}");
        }
    }

    #[test]
    fn a_simulation_without_noise_under_steps_or_a_slow_sine_was_not_smoothed() {
        let steps = |k: usize| if (k / 17 + k / 41).is_multiple_of(2) { 2.0 } else { -2.0 };
        let sine = |k: usize| (0.05 * k as f64).sin();
        for input in [&steps as &dyn Fn(usize) -> f64, &sine] {
            let (mut rate, mut text) = (0.0, String::from("t_s,u_N_m,q_rad_s\n"));
            for k in 0..2000 {
                text.push_str(&format!("{:.2},{},{rate}\n", STEP * k as f64, input(k)));
                rate += STEP * (input(k) - 2.0 * rate);
            }
            assert_eq!(Dataset::new(&[read(&text)]).unwrap().smoothing, None);
        }
    }

    #[test]
    fn rows_that_follow_from_each_other_are_made_one() {
        for seed in 1..4 {
            let flown = flight(seed, 0.0);
            let data = data(&Flight { q: smoothed(&flown.q), theta: smoothed(&flown.theta), ..flown });
            assert_eq!(
                data.smoothing,
                Some(Smoothing { left_out: Some("the angle"), in_use: true }),
                "{seed}"
            );
            assert!(!data.has_angle && (2..8).contains(&data.thinned), "{seed}: {}", data.thinned);
        }
    }

    #[test]
    fn an_output_that_was_smoothed_is_left_out_beside_one_that_was_not() {
        let flown = flight(1, 0.0);
        let of_rate = data(&Flight { q: smoothed(&flown.q), ..flown.clone() });
        assert_eq!(of_rate.smoothing, Some(Smoothing { left_out: Some("the rate"), in_use: false }));
        assert!(!of_rate.has_rate && of_rate.has_angle && of_rate.thinned == 1);
        let of_angle = data(&Flight { theta: smoothed(&flown.theta), ..flown });
        assert_eq!(of_angle.smoothing, Some(Smoothing { left_out: Some("the angle"), in_use: false }));
        assert!(of_angle.has_rate && !of_angle.has_angle);
    }
}
