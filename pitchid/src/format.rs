//! Numbers as people read them: as many digits as the interval justifies.

use serde::Serialize;
use sysid::estimate::Estimate;

/// Most digits behind the decimal point.
const MOST_DECIMALS: i32 = 8;
/// Sizes from here on are written with a power of ten.
const LARGE: f64 = 1e5;

/// An estimate in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Shown {
    /// The value.
    pub value: String,
    /// "0.107 to 0.119", or why there is none.
    pub interval: String,
}

/// An estimate with two significant digits of its interval's half-width.
pub fn estimate(estimate: &Estimate) -> Shown {
    let [low, high] = estimate.ci95;
    let half = 0.5 * (high - low);
    if !estimate.value.is_finite() {
        return Shown { value: "-".into(), interval: "not determined".into() };
    }
    if !half.is_finite() {
        return Shown { value: plain(estimate.value), interval: "not determined by these data".into() };
    }
    let fixed = |x: f64| with_resolution(x, half);
    Shown { value: fixed(estimate.value), interval: format!("{} to {}", fixed(low), fixed(high)) }
}

/// `x`, rounded to two significant digits of `resolution`.
fn with_resolution(x: f64, resolution: f64) -> String {
    if x.abs() >= LARGE || resolution <= 0.0 {
        return plain(x);
    }
    let decimals = (1 - resolution.log10().floor() as i32).clamp(0, MOST_DECIMALS);
    unsigned_zero(format!("{x:.*}", usize::try_from(decimals).unwrap_or(0)))
}

/// Three significant digits.
pub fn plain(x: f64) -> String {
    sysid::estimate::digits(x)
}

/// A value as it stands in a file of the user's, to six digits: a program may have written it with seventeen.
pub fn as_given(x: f64) -> String {
    let x = format!("{x:.5e}").parse().unwrap_or(x);
    if x != 0.0 && !(1e-4..LARGE).contains(&x.abs()) { format!("{x:e}") } else { format!("{x}") }
}

/// So many decimals, without a minus before a zero.
pub fn fixed(x: f64, decimals: usize) -> String {
    unsigned_zero(format!("{x:.decimals$}"))
}

/// Per cent with one decimal.
pub fn percent(x: f64) -> String {
    fixed(x, 1)
}

/// With its sign, one decimal.
pub fn signed(x: f64) -> String {
    format!("{x:+.1}").replace('-', "−")
}

/// Three significant digits with the unit.
pub fn in_unit(x: f64, symbol: &str) -> String {
    format!("{} {}", plain(x), unit(symbol)).trim_end().to_owned()
}

/// The unit as it follows a number: nothing for a pure number.
pub fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// "1 sample", "2 samples".
pub fn plural(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Nobody wants to read "-0.0".
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: f64, ci95: [f64; 2]) -> (String, String) {
        let shown = estimate(&Estimate { name: "x".into(), unit: "s".into(), value, ci95 });
        (shown.value, shown.interval)
    }

    #[test]
    fn digits_follow_the_interval() {
        assert_eq!(shown(0.112_83, [0.106_71, 0.118_95]), ("0.1128".into(), "0.1067 to 0.1190".into()));
        assert_eq!(shown(-23.4, [-26.1, -20.7]), ("-23.4".into(), "-26.1 to -20.7".into()));
        assert_eq!(shown(1234.4, [1000.0, 1500.0]), ("1234".into(), "1000 to 1500".into()));
        assert_eq!(shown(0.0, [0.0, 0.0]).0, "0");
        assert_eq!(shown(-0.001, [-0.5, 0.5]).0, "0.00");
    }

    #[test]
    fn what_is_not_determined_is_said_to_be_so() {
        assert_eq!(shown(3.0, [f64::NEG_INFINITY, f64::INFINITY]).1, "not determined by these data");
        assert_eq!(shown(f64::NAN, [f64::NAN, f64::NAN]).1, "not determined");
    }

    #[test]
    fn given_values_stay_as_they_were_written() {
        assert_eq!(as_given(5e-5), "5e-5");
        assert_eq!(as_given(0.02639), "0.02639");
        assert_eq!(as_given(0.0), "0");
        assert_eq!(percent(-0.01), "0.0");
        assert_eq!((fixed(-0.0001, 3), fixed(-1.5, 1)), ("0.000".into(), "-1.5".into()));
        assert_eq!((plural(1, "row"), plural(0, "row")), ("1 row".into(), "0 rows".into()));
    }
}
