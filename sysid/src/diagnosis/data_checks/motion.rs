//! Do rate and angle tell of one motion? Δθ against ∫q dt: the sign and the unit of the one against the other.

use super::{DEGREES, DataCheck, Gravity, joined, noted, too_large};
use crate::dataset::Dataset;
use crate::estimate::digits;
use crate::model::baseline::rough_gain;
use crate::recording::rate_and_angle::{RateAndAngle, rate_and_angle};
use crate::recording::{NoteKind, Recording};

/// Times over which ∫q dt is compared with Δθ, s: a gyro with a slow filter agrees over the longer one.
const WINDOWS: [f64; 2] = [0.2, 1.0];
/// Correlation from which sign and unit are judged.
const CORRELATED: f64 = 0.7;
/// Correlation below which, noise apart, the two channels tell of different motions.
const UNRELATED: f64 = 0.3;
/// Share of the correlation that the noise must leave before that is said.
const CLEAR: f64 = 0.8;
/// Half width, in ln, of the band around 57.3: a rate gain may be wrong by 30 % besides.
const NEAR: f64 = 0.4;
/// Ratios that a wrong gain of the gyro explains.
const GAIN_ERROR: f64 = 0.6;
/// Times that the one moves as far as the other from which no gain explains it.
const CONTRADICTION: f64 = 2.0;
/// Ratio of the bounds of that below which it is one factor.
const ONE_FACTOR: f64 = 1.2;
const ALONE: &str = "only one of rate and angle is there: nothing to compare with";

struct Compared {
    over: f64,
    found: RateAndAngle,
    /// The correlation that the noise of both channels would leave of a perfect one.
    reachable: f64,
}

/// Over the window that shows the closer relation.
fn compare(recording: &Recording) -> Option<Compared> {
    let (q, theta) = (recording.q.as_deref()?, recording.theta.as_deref()?);
    let [of_q, of_theta] = [q, theta].map(noise);
    let step = recording.step;
    let at = |over: f64| {
        let found = rate_and_angle(q, theta, &recording.segments, step, over)?;
        let clean = |noise: f64, spread: f64| (1.0 - noise / (spread * spread)).max(0.0);
        let in_rate = clean(of_q * of_q * step * over, found.of_rate);
        let in_angle = clean(2.0 * of_theta * of_theta, found.of_angle);
        Some(Compared { over, found, reachable: (in_rate * in_angle).sqrt() })
    };
    let both = WINDOWS.into_iter().filter_map(at);
    both.max_by(|a, b| a.found.correlation.abs().total_cmp(&b.found.correlation.abs()))
}

/// Standard deviation of the white noise in a smooth signal, from its third differences (variance 20 σ²).
fn noise(values: &[f64]) -> f64 {
    let third = values.windows(4).map(|v| v[3] - 3.0 * v[2] + 3.0 * v[1] - v[0]);
    (third.map(|d| d * d).sum::<f64>() / (20.0 * values.len().max(1) as f64)).sqrt()
}

/// The sign of the rate against the angle's, and whether the two belong together. Which of the two is reversed is told
/// by the sign of the response to the input, where the model has one (`dm_du`).
pub fn sign(recordings: &[Recording], data: &Dataset, dm_du: Option<f64>) -> DataCheck {
    const CAUSE: &str = "rate_sign";
    let wrong = |recording: &Recording| {
        let compared = compare(recording)?;
        let correlation = compared.found.correlation;
        if correlation < -CORRELATED {
            return Some(reversed(recording, &compared, data, dm_du));
        }
        (correlation.abs() < UNRELATED && compared.reachable > CLEAR).then(|| {
            format!(
                "the angle theta_rad does not follow the rate q_rad_s (correlation {correlation:.2} of the angle's change with the rate's \
                 integral over {} s, where noise would leave {:.2}): one of the two is another signal; delete or map the column",
                compared.over, compared.reachable
            )
        })
    };
    if let Some(words) = joined(recordings, wrong) {
        return DataCheck::found(CAUSE, Gravity::Stops, words);
    }
    let compared: Vec<Compared> = recordings.iter().filter_map(compare).collect();
    let Some(weakest) = compared.iter().min_by(|a, b| a.found.correlation.total_cmp(&b.found.correlation))
    else {
        return DataCheck::cannot_tell(CAUSE, ALONE);
    };
    let described = format!(
        "the angle's change follows the rate's integral over {} s with a correlation of {:.2}",
        weakest.over, weakest.found.correlation
    );
    if weakest.found.correlation > CORRELATED {
        DataCheck::ruled_out(CAUSE, described)
    } else {
        DataCheck::cannot_tell(CAUSE, format!("{described} only: too much noise, or too little motion"))
    }
}

fn reversed(recording: &Recording, compared: &Compared, data: &Dataset, dm_du: Option<f64>) -> String {
    let of = |column: &str| recording.option_to_scale(column, -1.0).unwrap_or_default();
    let advice = match dm_du {
        Some(gain) if rough_gain(data).is_some_and(|rough| rough * gain < 0.0) => format!(
            "the rate is reversed, for it answers to the input against the model's sign; read it with {}",
            of("q_rad_s")
        ),
        Some(_) => format!(
            "the angle is reversed, for the rate answers to the input with the model's sign; read it with {}",
            of("theta_rad")
        ),
        None => format!(
            "one of the two is reversed; if the rate, read it with {}, if the angle, with {}",
            of("q_rad_s"),
            of("theta_rad")
        ),
    };
    format!(
        "the angle theta_rad falls while the rate q_rad_s is positive (correlation {:.2} of the angle's change with the rate's integral over {} s): {advice}",
        compared.found.correlation, compared.over
    )
}

/// Units of a rate that are no radians per second, in rad/s.
const UNITS: [(&str, f64); 3] = [
    ("turns per minute", std::f64::consts::TAU / 60.0),
    ("turns per second", std::f64::consts::TAU),
    ("mrad/s", 1e-3),
];

/// That the one moves so many times as far as the other that no wrong gain of a gyro explains it.
fn contradiction(recording: &Recording, found: RateAndAngle) -> Option<String> {
    let [least, most] = found.slopes();
    let (what, other, [least, most]) = match (least > CONTRADICTION, most < 1.0 / CONTRADICTION) {
        (true, _) => ("angle theta_rad", "rate", [least, most]),
        (_, true) => ("rate q_rad_s", "angle", [1.0 / most, 1.0 / least]),
        _ => return None,
    };
    let of = |column: &str, factor: f64| {
        let rounded = format!("{factor:.2e}").parse().unwrap_or(factor);
        recording.option_to_scale(column, rounded).unwrap_or_default()
    };
    let is_a_unit = most < ONE_FACTOR * least;
    let unit = UNITS.iter().find(|(_, factor)| (found.slope() / factor).ln().abs() < 0.5 * ONE_FACTOR.ln());
    let remedy = if is_a_unit {
        format!(
            "where the rate has another unit{} read it with {}, where the angle has, with {}, or leave one out",
            unit.map_or(String::new(), |(name, _)| format!(" ({name} would fit)")),
            of("q_rad_s", found.slope()),
            of("theta_rad", 1.0 / found.slope())
        )
    } else {
        "leave one out".into()
    };
    Some(format!(
        "the {what} moves {} to {} times as far as the {other} says: they contradict each other, and with the wrong one the gain is wrong by \
         as much; {remedy}",
        digits(least),
        digits(most),
    ))
}

/// The unit of the rate against the angle's.
pub fn unit(recordings: &[Recording], data: &Dataset) -> DataCheck {
    const CAUSE: &str = "rate_unit";
    // A gyro that clips shows less than the motion, and an angle that does.
    let clips = |recording: &Recording| {
        let place = recordings.iter().position(|other| std::ptr::eq(other, recording));
        data.runs.iter().any(|run| Some(run.recording) == place && run.rate_limit.is_finite())
    };
    let angle_clips =
        |recording: &Recording| noted(recording, NoteKind::Clipped, "theta_rad", "stays").is_some();
    let clear = |recording: &Recording| compare(recording).filter(|c| c.found.correlation.abs() > CORRELATED);
    let wrong = |recording: &Recording| {
        let found = clear(recording)?.found;
        let slope = found.slope();
        let near = |factor: f64| (slope / factor).ln().abs() < NEAR;
        let ((what, column), other) = match (near(DEGREES), near(1.0 / DEGREES)) {
            (true, _) => (("angle", "theta_rad"), "rate"),
            (_, true) => (("rate", "q_rad_s"), "angle"),
            _ if slope > 1.0 && clips(recording) || slope < 1.0 && angle_clips(recording) => return None,
            _ => return contradiction(recording, found),
        };
        Some(format!(
            "the {what} {column} moves {} times as far as the {other} says: degrees where radians belong; read it with {}",
            digits(slope.max(1.0 / slope)),
            recording.option_to_scale(column, 1.0 / DEGREES).unwrap_or_default()
        ))
    };
    if let Some(words) = joined(recordings, wrong) {
        return DataCheck::found(CAUSE, Gravity::Stops, words);
    }
    let large =
        |r: &Recording| too_large(r, "q_rad_s").or_else(|| too_large(r, "theta_rad")).map(str::to_owned);
    if let Some(words) = joined(recordings, large) {
        return DataCheck::found(CAUSE, Gravity::Headline, words);
    }
    if recordings.iter().all(|recording| recording.q.is_none() || recording.theta.is_none()) {
        return DataCheck::cannot_tell(CAUSE, ALONE);
    }
    let slopes: Vec<f64> = recordings.iter().filter_map(|r| Some(clear(r)?.found.slope())).collect();
    let farthest = slopes.iter().copied().max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()));
    match farthest {
        None => DataCheck::cannot_tell(CAUSE, "angle and rate are not related closely enough"),
        Some(slope) if slope.ln().abs() < GAIN_ERROR => DataCheck::ruled_out(
            CAUSE,
            format!(
                "the angle changes by {} times the rate's integral (57.3 or 0.0175 would be a unit)",
                digits(slope)
            ),
        ),
        Some(slope) => DataCheck::cannot_tell(
            CAUSE,
            format!(
                "the angle changes by {} times the rate's integral, which is no unit's factor",
                digits(slope)
            ),
        ),
    }
}
