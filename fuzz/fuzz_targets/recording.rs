//! A recording as CSV, with whatever columns and options.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sysid::recording::{ReadOptions, header, parse};

fuzz_target!(|bytes: &[u8]| {
    // the options stand in the first line, so that a corpus stays readable
    let end = bytes.iter().position(|&byte| byte == b'\n').unwrap_or(0);
    let (first, table) = bytes.split_at(end);
    let mut options = ReadOptions::default();
    for word in String::from_utf8_lossy(first).split(' ').take(8) {
        match word.split_once(':') {
            Some(("column", map)) => options.columns.extend(map.parse()),
            Some(("section", section)) => options.sections.extend(section.parse()),
            Some(("split", time)) => options.splits.extend(time.parse::<f64>()),
            Some(("input", hold)) => options.input_hold = hold.parse().unwrap_or_default(),
            _ => {}
        }
    }
    let _ = header("a.csv", table);
    let Ok(recording) = parse("a.csv", table, &options) else { return };
    let length = recording.t.len();
    let signals =
        [Some(&recording.u), recording.q.as_ref(), recording.theta.as_ref(), recording.thrust.as_ref()];
    for signal in signals.into_iter().flatten().chain([&recording.t]) {
        assert!(signal.len() == length && signal.iter().all(|value| value.is_finite()));
    }
    assert!(recording.step > 0.0 && recording.sections.iter().all(|section| section.rows.end <= length));
    let mut written = Vec::new();
    let _ = recording.write_csv(&mut written);
});
