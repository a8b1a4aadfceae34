//! A number with a unit and an interval: the only form in which estimates leave this crate.

use serde::Serialize;

/// An estimate with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Name of the parameter, as in model files.
    pub name: String,
    /// Unit; `1` for a pure number.
    pub unit: String,
    /// Estimated value.
    pub value: f64,
    /// 95 % interval [low, high].
    pub ci95: [f64; 2],
}

/// Quantile of the normal distribution for a two-sided 95 % interval.
pub(crate) const NORMAL_95: f64 = 1.959_963_984_540_054;

impl Estimate {
    /// The estimate with a normal interval of ±1.96 `deviation`, cut off at `bounds`.
    pub fn new(name: &str, unit: &str, value: f64, deviation: f64, bounds: [f64; 2]) -> Self {
        let reach = NORMAL_95 * deviation;
        let ci95 = [(value - reach).max(bounds[0]), (value + reach).min(bounds[1])];
        Self { name: name.into(), unit: unit.into(), value, ci95 }
    }
}

/// Three significant digits.
pub fn digits(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let magnitude = x.abs().log10().floor() as i32;
    if (-4..5).contains(&magnitude) {
        format!("{x:.*}", usize::try_from(2 - magnitude).unwrap_or(0))
    } else {
        format!("{x:.2e}")
    }
}
