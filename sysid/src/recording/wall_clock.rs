//! Times of day and dates with them, in the place of seconds.

use jiff::civil::{DateTime, Time};
use jiff::{Timestamp, tz::Offset};

/// Seconds in a day.
const DAY_S: f64 = 86_400.0;
/// Times of day behind a date.
const FORMATS: [&str; 2] = ["%H:%M:%S%.f", "%I:%M:%S%.f %p"];
/// A stamp less than this before midnight, s, and one less than this after it, are of two days.
const NEAR_S: f64 = 3600.0;

/// Seconds since midnight of a time of day (`12:34:56.789`, `02:34:56 PM`), or since 1970 of a date with one (ISO 8601, with or
/// without a zone). Of a date as it is written somewhere (`12-May-2023`, `05/12/2023`, `12.05.2023`) the time of day counts alone:
/// which number is the month is not known.
pub(super) fn seconds(cell: &str) -> Option<f64> {
    if cell.bytes().filter(|&byte| byte == b':').count() < 2 {
        return None;
    }
    let since_1970 = |stamp: Timestamp| stamp.as_duration().as_secs_f64();
    if let Ok(time) = cell.parse::<Time>()
        && !cell.contains('-')
    {
        return Some(time.duration_since(Time::midnight()).as_secs_f64());
    }
    if let Ok(stamp) = cell.parse::<Timestamp>() {
        return Some(since_1970(stamp));
    }
    if let Ok(date) = cell.parse::<DateTime>() {
        return Offset::UTC.to_timestamp(date).ok().map(since_1970);
    }
    let time = cell.split_once(' ').filter(|(date, _)| is_a_date(date)).map_or(cell, |(_, time)| time);
    let time = FORMATS.iter().find_map(|format| Time::strptime(format, time.trim()).ok())?;
    Some(time.duration_since(Time::midnight()).as_secs_f64())
}

/// Whether this is day, month and year in some order, with one separator.
fn is_a_date(text: &str) -> bool {
    ['/', '.', '-'].iter().any(|&separator| {
        let parts: Vec<&str> = text.split(separator).collect();
        let is_number = |part: &&str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
        let numbers = parts.iter().filter(|part| is_number(part)).count();
        let is_part = |part: &&str| !part.is_empty() && part.chars().all(char::is_alphanumeric);
        parts.len() == 3 && numbers >= 2 && parts.iter().all(is_part)
    })
}

/// Lets times of day go on over midnight.
pub(super) fn over_midnight(times: &mut [f64]) {
    let mut days = 0.0;
    let mut before = f64::NAN;
    for t in times {
        let of_day = *t;
        if before > DAY_S - NEAR_S && of_day < NEAR_S {
            days += DAY_S;
        }
        if !of_day.is_nan() {
            before = of_day;
        }
        *t += days;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_of_day_and_a_date_are_seconds() {
        assert_eq!(seconds("00:01:02.5"), Some(62.5));
        assert_eq!(seconds("1970-01-02 00:00:01"), Some(DAY_S + 1.0));
        assert_eq!(seconds("1970-01-01T01:00:00.25+01:00"), Some(0.25));
        assert_eq!(seconds("1970-01-01T00:00:03Z"), Some(3.0));
        for afternoon in
            ["12-May-2023 14:03:09.5", "05/12/2023 02:03:09.5 PM", "12.05.2023 14:03:09.5", "2:03:09.5 PM"]
        {
            assert_eq!(seconds(afternoon), Some(14.0 * 3600.0 + 189.5), "{afternoon}");
        }
        for other in ["gyro 14:03:09", "1/2 14:03:09", "12.05.2023 14:03:99", "a/b/c 1:00:00"] {
            assert_eq!(seconds(other), None, "{other}");
        }
        for other in ["12:34", "1.5", "a:b:c", "", "25:00:00", "0:00:61"] {
            assert_eq!(seconds(other), None, "{other}");
        }
    }

    #[test]
    fn a_day_follows_another() {
        let mut times = [86_399.0, f64::NAN, 1.0, 0.5, 2.0];
        over_midnight(&mut times);
        let past = |s: f64| DAY_S + s;
        assert_eq!(times[0], 86_399.0);
        assert_eq!(times[2..], [past(1.0), past(0.5), past(2.0)]);
        // a stray stamp in the morning, one in the evening, and a date set back
        for stray in [[36_000.0, 86_399.0, 36_001.0], [72_000.0, 0.0, 72_001.0], [2e9, 1.9e9, 2e9]] {
            let mut times = stray;
            over_midnight(&mut times);
            assert_eq!(times, stray);
        }
    }
}
