//! Numbers in texts. What `core` formats floats with takes 14 KB of an image and 2 KB of its stack; this takes some hundred bytes.

use core::fmt;

/// Significant digits where no precision is asked for.
const DIGITS: u32 = 6;
/// Most places after the point.
const PLACES: u32 = 9;

/// A number written in decimals, rounded half away from zero: `{:.2}` with two places, `{:+}` with its sign, `{}` with up to six
/// significant digits and no zeros at the end. A zero has no minus. From 10⁹ on as `3.4e38`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimal(pub f32);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mut size, mut power) = (self.0.abs(), 0_u32);
        if !size.is_finite() {
            return f.write_str(if size.is_nan() { "NaN" } else { "infinite" });
        }
        if size >= 1e9 {
            while size >= 10.0 {
                (size, power) = (size / 10.0, power + 1);
            }
        }
        let (mut places, trim) = match f.precision() {
            Some(places) => ((places as u32).min(PLACES), false),
            None => (wanted(size), true),
        };
        let mut scaled = scaled(size, places);
        while trim && places > 0 && scaled.is_multiple_of(10) {
            (scaled, places) = (scaled / 10, places - 1);
        }
        let sign = if self.0 < 0.0 && scaled > 0 {
            "-"
        } else if f.sign_plus() {
            "+"
        } else {
            ""
        };
        let unit = 10_u64.pow(places);
        write!(f, "{sign}{}", scaled / unit)?;
        if places > 0 {
            write!(f, ".{:0width$}", scaled % unit, width = places as usize)?;
        }
        if power > 0 { write!(f, "e{power}") } else { Ok(()) }
    }
}

/// Places that show [`DIGITS`] significant digits.
fn wanted(size: f32) -> u32 {
    let (mut places, mut reach) = (DIGITS, 1.0);
    if size < 1.0 {
        reach = 0.1;
        while size < reach && places < PLACES {
            (reach, places) = (reach / 10.0, places + 1);
        }
    } else {
        while size >= reach && places > 0 {
            (reach, places) = (reach * 10.0, places - 1);
        }
    }
    places
}

/// size 10^places, rounded, in integers: below 10⁹ · 10⁹.
fn scaled(size: f32, places: u32) -> u64 {
    let bits = size.to_bits();
    let (exponent, fraction) = (bits >> 23, u64::from(bits & 0x7f_ffff));
    let mantissa = if exponent == 0 { fraction } else { fraction | 0x80_0000 };
    // size = mantissa 2^shift
    let product = mantissa * 10_u64.pow(places);
    match exponent.max(1) as i32 - 150 {
        shift @ 0.. => product << shift,
        shift @ -63..0 => {
            let down = shift.unsigned_abs();
            (product >> down) + ((product >> (down - 1)) & 1)
        }
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    use std::string::ToString;

    use proptest::prelude::*;

    #[test]
    fn numbers_read_as_a_person_writes_them() {
        let plain =
            [0.02, 3600.0, 0.4, 1.999, 1e-6, 16_777_215.0, 0.000_123, 0.1 + 0.2, 123_456.78, -0.5, 0.0];
        let found = plain.map(|value| Decimal(value).to_string());
        let expected = [
            "0.02", "3600", "0.4", "1.999", "0.000001", "16777215", "0.000123", "0.3", "123457", "-0.5", "0",
        ];
        assert_eq!(found, expected);
        assert_eq!(
            format!("{:.2} {:+.1} {:+.2}", Decimal(1.0), Decimal(2.25), Decimal(-0.001)),
            "1.00 +2.3 +0.00"
        );
        let edges = [0.012_345_678, 0.1, 0.099_999_9, 1.0, 10.0, 33_554_432.0, 536_870_912.0, 5.0e8, 0.25];
        let found = edges.map(|value| Decimal(value).to_string());
        let expected =
            ["0.0123457", "0.1", "0.0999999", "1", "10", "33554432", "536870912", "500000000", "0.25"];
        assert_eq!(found, expected);
        let tens = [1.234_567_9, 10.123_456, 123.456_78, 1_234.567_9, 12_345.678, 99_999.96];
        assert_eq!(
            tens.map(|value| Decimal(value).to_string()),
            ["1.23457", "10.1235", "123.457", "1234.57", "12345.7", "100000"]
        );
        let wild = [f32::NAN, f32::NEG_INFINITY, 1e30, f32::MAX, f32::MIN_POSITIVE];
        assert_eq!(
            wild.map(|value| Decimal(value).to_string()),
            ["NaN", "infinite", "1e30", "3.40282e38", "0"]
        );
    }

    proptest! {
        #[test]
        fn what_is_written_lies_within_half_a_digit(value in -1e6_f32..1e6, places in 0_usize..7) {
            let read: f64 = format!("{:.places$}", Decimal(value)).parse().unwrap();
            prop_assert!((read - f64::from(value)).abs() <= 0.5 * 10_f64.powi(-(places as i32)) + 1e-10);
        }
    }
}
