//! An angle that is the rate's running sum, as a board without another sensor makes it, is no second measurement.
//!
//! ```text
//! θ_k = θ_0 + Σ_{i≤k} (q_i − b) T_i,    q_i that of the row, of the row before, or their mean, T_i by the stamps or their median
//! ```
//!
//! to the last digits of both over a whole stretch without a gap. No sensor of its own keeps to that: a gyro's noise adds up, and its
//! scale is another one by a per cent. Taken for a second one, with noise of its own, it has the rate lag by half a row, which no
//! stiff rig can do.

use super::checks::extremes;
use super::clock::median_step;
use super::columns::Role;
use super::table::{Signal, Table};
use super::{Note, NoteKind};

/// Fewest rows that are compared, and least share of all rows.
const FEWEST: usize = 100;
const LEAST_SHARE: f64 = 0.5;
/// Last digits that rounding puts between the angle and the sum, and so many standard deviations of what rounding the rate adds up to.
const ROUNDED: f64 = 0.6;
const SUMMED: f64 = 3.0 * 0.289;
/// The angle turns so many times that: no gyro's scale is as good as to keep to an encoder's count for the whole of it (0.25 %).
const LEAST_TURNED: f64 = 400.0;
/// Decimal places that are looked for.
const MOST_DIGITS: i32 = 9;
/// Step over the median beyond which rows are missing.
const GAP: f64 = 1.5;

/// Leaves the pitch angle out where it is such a sum.
pub(super) fn leave_out(table: &mut Table, notes: &mut Vec<Note>) {
    let of = |role: Role| table.signals.iter().find(|s| s.source.role == role);
    let (Some(rate), Some(angle)) = (of(Role::Q), of(Role::Theta)) else { return };
    if !is_sum(&table.t, rate, angle) {
        return;
    }
    let text = format!(
        "{} is the running sum of {} to its last digit, and no measurement of its own: it is not used",
        angle.source.name, rate.source.name
    );
    notes.push(Note::new(NoteKind::Ignored, text));
    table.signals.retain(|s| s.source.role != Role::Theta);
}

fn is_sum(t: &[f64], rate: &Signal, angle: &Signal) -> bool {
    if t.len() < FEWEST {
        return false;
    }
    let step = median_step(t, 1);
    let stretches = (0..t.len()).collect::<Vec<_>>();
    let longest = stretches.chunk_by(|&a, &b| t[b] - t[a] < GAP * step).max_by_key(|rows| rows.len());
    let Some(&[first, .., last]) = longest else { return false };
    let [t, q, theta] = [t, &rate.values, &angle.values].map(|values| &values[first..=last]);
    let (n, all) = (q.len(), rate.values.len());
    if n < FEWEST || (n as f64) < LEAST_SHARE * all as f64 {
        return false;
    }
    let [of_rate, of_angle] = [rate, angle].map(last_digit);
    let (low, high) = extremes(theta);
    let rounding = ROUNDED * of_angle + SUMMED * of_rate * step * (n as f64).sqrt();
    if high - low < LEAST_TURNED * rounding {
        return false;
    }
    [1.0, 0.0, 0.5].into_iter().any(|own| {
        [false, true].into_iter().any(|by_stamps| {
            let mut sum = 0.0;
            let left = (0..n).map(|k| {
                if k > 0 {
                    let step = if by_stamps { t[k] - t[k - 1] } else { step };
                    sum += step * (own * q[k] + (1.0 - own) * q[k - 1]);
                }
                theta[k] - sum
            });
            widest_off_line(&left.collect::<Vec<_>>()) <= rounding
        })
    })
}

/// The last digit that a signal was written with; 0 where it has more than can be counted.
fn last_digit(signal: &Signal) -> f64 {
    let factor = signal.source.factor.abs();
    let ends_at = |scale: &f64| {
        signal.values.iter().all(|value| {
            let digits = value / factor * scale;
            (digits - digits.round()).abs() < 1e-3
        })
    };
    let digit = (0..MOST_DIGITS).map(|place| 10_f64.powi(place)).find(ends_at);
    digit.map_or(0.0, |scale| factor / scale)
}

/// Largest distance from the line of least squares: an offset of the rate that the sum lacks is one.
fn widest_off_line(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let (middle, mean) = (0.5 * (n - 1.0), values.iter().sum::<f64>() / n);
    let spread = n * (n * n - 1.0) / 12.0;
    let slope =
        values.iter().enumerate().map(|(k, v)| (k as f64 - middle) * (v - mean)).sum::<f64>() / spread;
    let off = |(k, v): (usize, &f64)| (v - mean - slope * (k as f64 - middle)).abs();
    values.iter().enumerate().map(off).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use crate::recording::parse;

    /// A swing by a gyro with noise, and an angle in these digits, of the same board, or of an encoder.
    fn read(digit: f64, angle: impl Fn(f64, f64) -> f64) -> (bool, Vec<String>) {
        let mut text = String::from("t_s,u_norm,q_deg_s,theta_deg\n");
        let mut sum = 0.0;
        for k in 0..600 {
            let t = 0.005 * f64::from(k);
            let noise = 0.3 * (0.7 * f64::from(k * k % 1009)).sin();
            let q = 40.0 * (9.0 * t).sin() + noise + 0.05;
            sum += 0.005 * q;
            let encoder = 40.0 / 9.0 * (1.0 - (9.0 * t).cos());
            let angle = (angle(sum, encoder) / digit).round() * digit;
            text.push_str(&format!("{t:.3},{},{q:.2},{angle:.4}\n", (k / 90) % 2));
        }
        let recording = parse("a.csv", text.as_bytes(), &Default::default()).unwrap();
        let told = recording.notes.iter().filter(|note| note.text.contains("running sum"));
        (recording.theta.is_some(), told.map(|note| note.text.clone()).collect())
    }

    #[test]
    fn a_sum_of_the_rate_is_left_out_and_an_encoder_is_not() {
        let (used, told) = read(0.01, |sum, _| sum);
        assert!(!used && told[0].starts_with("theta_deg is the running sum of q_deg_s"), "{told:?}");
        for (digit, scale) in [(0.01, 1.0), (0.0879, 1.0), (0.0879, 1.003), (0.35, 1.01)] {
            let (used, told) = read(digit, |_, encoder| scale * encoder);
            assert!(used && told.is_empty(), "{digit} {scale}: {told:?}");
        }
    }
}
