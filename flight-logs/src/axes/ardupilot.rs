//! ArduPilot Copter: messages of <https://ardupilot.org/copter/docs/logmessages.html>, parameters of
//! <https://ardupilot.org/copter/docs/parameters.html>.

use super::{Axis, Channel, Channels, Setting, fastest, moving, richest};
use crate::{Format, Log};

const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// `LOG_BITMASK`: attitude and rates in every loop; the IMU in every loop. Source: ArduCopter/defines.h.
const FAST_ATTITUDE: u32 = 1 << 0;
const FAST_IMU: u32 = 1 << 18;
/// Copter's default, where the log does not tell.
const DEFAULT_BITMASK: f64 = 176126.0;

/// The channels of one axis, in the body's axes (x forward, y right, z down).
pub(super) fn channels(log: &Log, axis: Axis) -> Channels {
    let one = |topic: &str, field: &str, factor: f64, unit, reason: &str| {
        Channel::sum(richest(log, topic)?, &[(field.to_owned(), factor)], unit, reason)
    };
    let letter = ["R", "P", "Y"][axis.index()];
    let gyro = ["GyrX", "GyrY", "GyrZ"][axis.index()];
    let angle = ["Roll", "Pitch", "Yaw"][axis.index()];
    let input = one("RATE", &format!("{letter}Out"), 1.0, "1", "what the rate controller asks of the motors")
        .or_else(|| motors(log, axis));
    let rate = fastest([
        first_gyro(log, gyro),
        one("RATE", letter, DEGREE, "rad/s", "rate as the rate controller saw it, logged in °/s"),
        one("GYR", gyro, 1.0, "rad/s", "one gyro, every sample"),
    ]);
    let volts = if log.format == Format::DataFlash { 1.0 } else { 0.01 };
    Channels {
        input,
        rate,
        angle: one("ATT", angle, DEGREE, "rad", "attitude that the estimator gives, logged in °"),
        setpoint: one(
            "RATE",
            &format!("{letter}Des"),
            DEGREE,
            "rad/s",
            "what the attitude loop asks for, logged in °/s",
        ),
        thrust: moving(
            log,
            [
                one("RATE", "AOut", 1.0, "1", "what is asked of the motors in all"),
                one("CTUN", "ThO", 1.0, "1", "what is asked of the motors in all"),
            ],
        ),
        battery: one("BAT", "Volt", 1.0, "V", "as measured")
            .or_else(|| one("CURR", "Volt", volts, "V", "as measured")),
    }
}

/// The first IMU: its number is an instance in new logs, and part of the name in old ones.
fn first_gyro(log: &Log, gyro: &str) -> Option<Channel> {
    let topic = log.topics.iter().find(|topic| topic.name == "IMU")?;
    Channel::sum(
        topic,
        &[(gyro.to_owned(), 1.0)],
        "rad/s",
        "the first IMU's gyro, filtered (INS_GYRO_FILTER)",
    )
}

/// The motors' outputs mixed back to an axis, for a quadrotor in X: motor 1 stands in front at the right, 2 behind at
/// the left (both turn against the clock), 3 in front at the left, 4 behind at the right.
/// Source: libraries/AP_Motors/AP_MotorsMatrix.cpp.
fn motors(log: &Log, axis: Axis) -> Option<Channel> {
    const QUAD: f64 = 1.0;
    const X: f64 = 1.0;
    let frame = |name: &str, wanted: f64| log.parameter(name).is_none_or(|found| found == wanted);
    if !(frame("FRAME_CLASS", QUAD) && frame("FRAME_TYPE", X) && frame("FRAME", X)) {
        return None;
    }
    let signs = match axis {
        Axis::Roll => [-1.0, 1.0, 1.0, -1.0],
        Axis::Pitch => [1.0, -1.0, 1.0, -1.0],
        Axis::Yaw => [1.0, 1.0, -1.0, -1.0],
    };
    let reason =
        "the motors' outputs (µs / 1000) mixed back for a quadrotor in X: limited, and rounded to 1 µs";
    let mix = |topic: &str, field: &dyn Fn(usize) -> Option<String>| {
        let terms: Option<Vec<(String, f64)>> =
            signs.iter().enumerate().map(|(motor, sign)| Some((field(motor)?, sign / 4000.0))).collect();
        Channel::sum(richest(log, topic)?, &terms?, "1", reason)
    };
    mix("RCOU", &|motor| output(log, motor))
        .or_else(|| mix("MOT", &|motor| Some(format!("Mot{}", motor + 1))))
}

/// The output that drives a motor, counted from 0: `SERVOn_FUNCTION` is 33 for the first.
fn output(log: &Log, motor: usize) -> Option<String> {
    let function = |n: usize| log.parameter(&format!("SERVO{n}_FUNCTION"));
    let known = (1..=14).any(|n| function(n).is_some());
    let driven = (1..=14).find(|&n| function(n) == Some(33.0 + motor as f64));
    driven.or((!known).then_some(motor + 1)).map(|n| format!("C{n}"))
}

/// What makes Copter log rates and gyros in every loop.
pub(super) fn settings(log: &Log) -> Vec<Setting> {
    let now =
        log.parameter("LOG_BITMASK").filter(|mask| (0.0..4e9).contains(mask)).unwrap_or(DEFAULT_BITMASK);
    let mask = now as u32 | FAST_ATTITUDE | FAST_IMU;
    let mut settings = Vec::new();
    if mask != now as u32 {
        let effect = "RATE and ATT (bit 0) and IMU (bit 18) in every loop, on top of what is logged now";
        settings.push(Setting::new(log, "LOG_BITMASK", mask.to_string(), effect));
    }
    if log.parameter("INS_LOG_BAT_MASK").is_none_or(|mask| mask != 0.0) {
        let effect = "no batches of vibration samples, which take the card's bandwidth";
        settings.push(Setting::new(log, "INS_LOG_BAT_MASK", "0", effect));
    }
    settings
}
