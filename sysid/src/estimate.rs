//! A number with a unit and an interval: the only form in which estimates leave this crate.

use serde::Serialize;
use std::fmt;

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

/// Significant digits of what is told.
const LEAST_DIGITS: i32 = 3;
/// The same where an interval is narrow.
const MOST_DIGITS: i32 = 6;
/// Quantile of the normal distribution for a two-sided 95 % interval.
pub(crate) const NORMAL_95: f64 = 1.959_963_984_540_054;

impl Estimate {
    /// The estimate with a normal interval of ±1.96 `deviation`, cut off at `bounds`.
    pub fn new(name: &str, unit: &str, value: f64, deviation: f64, bounds: [f64; 2]) -> Self {
        let reach = NORMAL_95 * deviation;
        let ci95 = [(value - reach).max(bounds[0]), (value + reach).min(bounds[1])];
        Self { name: name.into(), unit: unit.into(), value, ci95 }
    }

    /// The value and the ends of the interval: in three significant digits, or in as many as tell them apart, where six do.
    fn in_digits(&self) -> [String; 3] {
        let all = [self.value, self.ci95[0], self.ci95[1]];
        let apart = |told: &[String; 3]| (1..3).all(|end| all[end] == all[0] || told[end] != told[0]);
        let mut told = (LEAST_DIGITS..=MOST_DIGITS).map(|count| all.map(|x| significant(x, count)));
        told.find(apart).unwrap_or_else(|| all.map(digits))
    }
}

/// "Mc = 0.113 N m (95 %: 0.107 to 0.119)".
impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let [value, low, high] = self.in_digits();
        write!(f, "{} = {value}{unit} (95 %: {low} to {high})", self.name)
    }
}

/// Three significant digits.
pub fn digits(x: f64) -> String {
    significant(x, LEAST_DIGITS)
}

fn significant(x: f64, count: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let magnitude = x.abs().log10().floor() as i32;
    if (-4..5).contains(&magnitude) {
        format!("{x:.*}", usize::try_from(count - 1 - magnitude).unwrap_or(0))
    } else {
        format!("{x:.*e}", usize::try_from(count - 1).unwrap_or(0))
    }
}

/// Units of moments and of their slopes, the longest first, and those per unit inertia.
const UNITS: [(&str, &str); 7] = [
    ("N m s^2/rad^2", "1/rad"),
    ("N m s/rad", "1/s"),
    ("N m s/unit", "rad/s per unit"),
    ("N m/rad^3", "1/(s² rad²)"),
    ("N m/rad", "1/s²"),
    ("N m/unit", "rad/s² per unit"),
    ("N m", "rad/s²"),
];

/// `words`, each unit of a moment in them replaced by that of the moment per unit inertia.
pub fn per_inertia(words: &str) -> String {
    UNITS.iter().fold(words.to_owned(), |words, (moment, specific)| words.replace(moment, specific))
}

#[cfg(test)]
mod tests {
    use super::{Estimate, per_inertia};

    #[test]
    fn a_narrow_interval_is_told_in_the_digits_that_it_takes() {
        let told = |value: f64, deviation: f64| {
            Estimate::new("a", "1", value, deviation, [f64::NEG_INFINITY, f64::INFINITY]).in_digits()
        };
        assert_eq!(told(0.15, 0.005), ["0.150", "0.140", "0.160"]);
        assert_eq!(told(0.150_051_5, 1.4e-4), ["0.1501", "0.1498", "0.1503"]);
        assert_eq!(told(7.3e5, 70.0), ["7.300e5", "7.299e5", "7.301e5"]);
        assert_eq!(told(2.0, 0.0), ["2.00"; 3]);
        assert_eq!(told(0.06, 1e-12), ["0.0600"; 3], "nobody reads thirteen");
    }

    #[test]
    fn a_moment_becomes_an_acceleration_and_a_slope_its_slope() {
        let words =
            "Mc = 0.6 N m (0.5 to 0.7), dM_dq = -1 N m s/rad, dM_du = 130 N m/rad or 20 N m/unit; 3 N m.";
        assert_eq!(
            per_inertia(words),
            "Mc = 0.6 rad/s² (0.5 to 0.7), dM_dq = -1 1/s, dM_du = 130 1/s² or 20 rad/s² per unit; 3 rad/s²."
        );
    }
}
