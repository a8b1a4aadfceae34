//! The angle's changes against the integral of the rate: whether two channels tell of one motion.

use std::ops::Range;

/// Δθ against ∫q dt over windows of equal length, means removed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RateAndAngle {
    /// Standard deviation of ∫q dt.
    pub(crate) of_rate: f64,
    /// Standard deviation of Δθ.
    pub(crate) of_angle: f64,
    /// Correlation of the two; negative where one of them is reversed.
    pub(crate) correlation: f64,
}

impl RateAndAngle {
    /// Δθ per ∫q dt without its sign: 1 where both have the same unit. (Rate noise would flatten the slope of a
    /// regression: this ratio treats both alike.)
    pub(crate) fn slope(&self) -> f64 {
        self.of_angle / self.of_rate
    }

    /// Between these the slope lies: of a regression on the rate, which noise and a lag of the angle flatten and a lag of the
    /// gyro does not, and of one on the angle, the other way round.
    pub(crate) fn slopes(&self) -> [f64; 2] {
        let correlation = self.correlation.abs();
        [self.slope() * correlation, self.slope() / correlation]
    }
}

/// Compares over consecutive windows of `over` s within `segments`; `None` where there are fewer than five windows, or
/// either channel does not move.
pub(crate) fn rate_and_angle(
    q: &[f64],
    theta: &[f64],
    segments: &[Range<usize>],
    step: f64,
    over: f64,
) -> Option<RateAndAngle> {
    let length = ((over / step).round() as usize).clamp(1, 1000);
    let pairs: Vec<(f64, f64)> =
        segments.iter().flat_map(|rows| windows(q, theta, rows, length, step)).collect();
    let count = pairs.len() as f64;
    if pairs.len() < 5 {
        return None;
    }
    let (mx, my) = pairs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs.iter().map(|p| (p.0 - mx, p.1 - my)) {
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    let [of_rate, of_angle] = [xx, yy].map(|sum| (sum / count).sqrt());
    let compared = RateAndAngle { of_rate, of_angle, correlation: xy / (xx * yy).sqrt() };
    (compared.correlation.is_finite() && compared.slope() > 0.0).then_some(compared)
}

/// (∫q dt, Δθ) over consecutive windows of `length` steps, by the trapezium rule.
fn windows(q: &[f64], theta: &[f64], rows: &Range<usize>, length: usize, step: f64) -> Vec<(f64, f64)> {
    let starts = (rows.start..rows.end.saturating_sub(length)).step_by(length);
    let window = |k: usize| {
        let inner: f64 = q[k + 1..k + length].iter().sum();
        let area = step * (inner + 0.5 * (q[k] + q[k + length]));
        (area, theta[k + length] - theta[k])
    };
    starts.map(window).collect()
}
