//! The values that a number of a file may have, and the words for them.

use std::fmt;

/// A size of any quantity in SI units that no vehicle has: what is beyond is a slip of the pen.
pub const LARGEST: f64 = 1e12;

/// A range with its unit, its ends included; 0 is not in one that begins at [`f64::MIN_POSITIVE`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Legal {
    low: f64,
    high: f64,
    unit: &'static str,
}

impl Legal {
    /// From `low` to `high`, in `unit`; `1` and nothing stand for a pure number.
    pub const fn new(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low, high, unit }
    }

    /// Any number that a vehicle may have.
    pub const fn any(unit: &'static str) -> Self {
        Self::new(-LARGEST, LARGEST, unit)
    }

    /// The same from 0.
    pub const fn not_negative(unit: &'static str) -> Self {
        Self::new(0.0, LARGEST, unit)
    }

    /// The same above 0.
    pub const fn positive(unit: &'static str) -> Self {
        Self::new(f64::MIN_POSITIVE, LARGEST, unit)
    }

    /// Whether `value` is one of them; what is no number is not.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

impl fmt::Display for Legal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { low, high, unit } = *self;
        match low == f64::MIN_POSITIVE {
            true => write!(f, "a number above 0 and up to {}", plain(high))?,
            false => write!(f, "a number from {} to {}", plain(low), plain(high))?,
        }
        if ["", "1"].contains(&unit) { Ok(()) } else { write!(f, ", in {unit}") }
    }
}

/// A number as people write it: no row of zeros.
pub(crate) fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_their_ends_and_are_told_in_plain_numbers() {
        let positive = Legal::positive("kg m²");
        assert_eq!(positive.to_string(), "a number above 0 and up to 1e12, in kg m²");
        assert!(positive.holds(1e-300) && positive.holds(1e12));
        for value in [0.0, -1.0, 1e13, f64::NAN, f64::INFINITY] {
            assert!(!positive.holds(value), "{value}");
        }
        assert_eq!(Legal::not_negative("1").to_string(), "a number from 0 to 1e12");
        assert_eq!(Legal::new(1e-5, 0.99, "s").to_string(), "a number from 1e-5 to 0.99, in s");
        assert!(Legal::any("").holds(-1e12) && !Legal::any("").holds(-1.1e12));
    }
}
