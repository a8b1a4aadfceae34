//! Betaflight and INAV: fields of `src/main/blackbox/blackbox.c`, mixers of `src/main/flight/mixer_init.c`.

use super::{Axis, Channel, Channels, Setting, moving};
use crate::{Log, Topic};

/// The channels of one axis. Input, rate and set-point share their sign; the firmware counts pitch positive nose down.
pub(super) fn channels(log: &Log, axis: Axis) -> Channels {
    let Some(main) = log.topic("main", 0) else { return Channels::default() };
    let i = axis.index();
    let resolution: f64 = if log.parameter("blackbox_high_resolution") == Some(1.0) { 10.0 } else { 1.0 };
    let one =
        |field: String, factor: f64, unit, reason: &str| Channel::sum(main, &[(field, factor)], unit, reason);
    let new = log.firmware.as_deref().is_some_and(|firmware| {
        ["Betaflight 4.", "Betaflight 20", "INAV "].iter().any(|start| firmware.starts_with(start))
    });
    Channels {
        input: controller(main, i).or_else(|| motors(log, main, axis)),
        rate: one(
            format!("gyroADC[{i}]"),
            1.0,
            "rad/s",
            match axis {
                Axis::Pitch => {
                    "gyro after the filters: what the controller sees; like the input positive nose down"
                }
                _ => "gyro after the filters: what the controller sees",
            },
        ),
        angle: one(
            format!("attitude[{i}]"),
            std::f64::consts::PI / 1800.0,
            "rad",
            "attitude that the firmware estimates (INAV), logged in 0.1°: check its sign against the rate",
        ),
        setpoint: one(
            format!("setpoint[{i}]"),
            (1.0 / resolution).to_radians(),
            "rad/s",
            "what the sticks or the angle mode ask for, logged in °/s",
        )
        .or_else(|| {
            let reason = "what the sticks or the angle mode ask for (INAV), logged in °/s";
            one(format!("axisRate[{i}]"), 1_f64.to_radians(), "rad/s", reason)
        }),
        thrust: moving(
            log,
            [
                one("setpoint[3]".to_owned(), 1e-3, "1", "throttle as the mixer takes it"),
                one("rcCommand[3]".to_owned(), 1e-3 / resolution, "1", "throttle of the stick")
                    .map(|throttle| throttle.plus(-1.0)),
            ],
        ),
        // Older firmware counts in 0.1 V, or in steps of its converter.
        battery: ["vbatLatest", "vbat"]
            .into_iter()
            .filter(|_| new)
            .find_map(|field| one(field.to_owned(), 0.01, "V", "as measured, logged in 0.01 V")),
    }
}

/// The controller's terms that are logged, added: the mixer takes a thousandth of their sum.
fn controller(main: &Topic, i: usize) -> Option<Channel> {
    main.field(&format!("axisP[{i}]"))?;
    let terms: Vec<(String, f64)> = ["axisP", "axisI", "axisD", "axisF", "axisS"]
        .iter()
        .map(|term| (format!("{term}[{i}]"), 1e-3))
        .filter(|(field, _)| main.field(field).is_some())
        .collect();
    let reason = "the controller's terms, added, as the mixer takes them (before its limit pidsum_limit)";
    Channel::sum(main, &terms, "1", reason)
}

/// Four motors mixed back to an axis: 1 stands behind at the right, 2 in front at the right, 3 behind at the left,
/// 4 in front at the left.
fn motors(log: &Log, main: &Topic, axis: Axis) -> Option<Channel> {
    if main.field("motor[4]").is_some() {
        return None;
    }
    let signs = match axis {
        Axis::Roll => [-1.0, -1.0, 1.0, 1.0],
        Axis::Pitch => [1.0, -1.0, 1.0, -1.0],
        Axis::Yaw => [1.0, -1.0, -1.0, 1.0],
    };
    let limit = |i: usize| log.parameter(&format!("motorOutput[{i}]"));
    let range = limit(1).zip(limit(0)).map_or(1000.0, |(high, low)| high - low).max(1.0);
    let terms: Vec<(String, f64)> = signs
        .iter()
        .enumerate()
        .map(|(motor, sign)| (format!("motor[{motor}]"), sign / (4.0 * range)))
        .collect();
    Channel::sum(
        main,
        &terms,
        "1",
        "the motors' outputs mixed back for a quadrotor in X: limited by the mixer",
    )
}

/// What makes the firmware log the controller and the gyro fast.
///
/// Source: <https://betaflight.com/docs/development/Cli> (before 4.3 the sample rate was set by `blackbox_p_ratio`, and
/// no field could be left out); INAV, `docs/Settings.md`.
pub(super) fn settings(log: &Log) -> Vec<Setting> {
    // its headers have other names than its commands
    let setting = |parameter, value: &str, effect| Setting {
        parameter,
        value: value.to_owned(),
        effect,
        unknown: false,
    };
    let firmware = log.firmware.as_deref().unwrap_or_default();
    if firmware.starts_with("INAV") {
        return vec![
            setting("blackbox_rate_num", "1", "with the next: every second loop"),
            setting("blackbox_rate_denom", "2", "500 Hz of a 1 kHz loop"),
        ];
    }
    let old = ["3.", "4.0", "4.1", "4.2"]
        .iter()
        .any(|version| firmware.starts_with(&format!("Betaflight {version}")));
    if old {
        return vec![setting("blackbox_p_ratio", "32", "1 kHz of an 8 kHz loop")];
    }
    vec![
        setting("blackbox_sample_rate", "1/8", "1 kHz of an 8 kHz loop (1/4 of 4 kHz, 1/2 of 2 kHz)"),
        setting("blackbox_mode", "NORMAL", "log while armed"),
        setting("blackbox_disable_pids", "OFF", "log the controller's terms"),
        setting("blackbox_disable_gyro", "OFF", "log the gyro"),
        setting("blackbox_high_resolution", "ON", "gyro and set-point in 0.1 °/s (4.4 and later)"),
        setting("debug_mode", "NONE", "no room spent on debugging"),
    ]
}
