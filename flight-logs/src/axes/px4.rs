//! PX4: topics of <https://docs.px4.io/main/en/msg_docs/>, parameters of
//! <https://docs.px4.io/main/en/advanced_config/parameter_reference.html>.

use super::{Axis, Channel, Channels, Setting, fastest, moving, richest};
use crate::Log;

/// The channels of one axis, in the body's axes (x forward, y right, z down).
pub(super) fn channels(log: &Log, axis: Axis) -> Channels {
    let i = axis.index();
    let one = |topic: &str, field: String, factor: f64, unit, reason: &str| {
        Channel::sum(richest(log, topic)?, &[(field, factor)], unit, reason)
    };
    let input = fastest([
        one(
            "vehicle_torque_setpoint",
            format!("xyz[{i}]"),
            1.0,
            "1",
            "what the rate controller asks of the allocation (PX4 1.14 and later)",
        ),
        one(
            "actuator_controls_0",
            format!("control[{i}]"),
            1.0,
            "1",
            "what the rate controller asks of the mixer (PX4 up to 1.13)",
        ),
    ]);
    let rate = fastest([
        one(
            "vehicle_angular_velocity",
            format!("xyz[{i}]"),
            1.0,
            "rad/s",
            "gyro without bias, filtered (IMU_GYRO_CUTOFF): what the rate controller sees",
        ),
        one(
            "sensor_combined",
            format!("gyro_rad[{i}]"),
            1.0,
            "rad/s",
            "gyro, mean over each step of logging",
        ),
        one(
            "sensor_gyro",
            ["x", "y", "z"][i].to_owned(),
            1.0,
            "rad/s",
            "one gyro, uncalibrated: on older boards not turned into the body's axes (SENS_BOARD_ROT)",
        ),
        one(
            "vehicle_attitude",
            format!("{axis}speed"),
            1.0,
            "rad/s",
            "rate that the estimator gives (PX4 up to 1.9)",
        ),
        one(
            "rate_ctrl_status",
            format!("{axis}speed"),
            1.0,
            "rad/s",
            "rate as the rate controller saw it (PX4 up to 1.10)",
        ),
    ]);
    let angle = richest(log, "vehicle_attitude")
        .and_then(|topic| Channel::euler(topic, "q", axis, "attitude that the estimator gives"));
    let setpoint =
        one("vehicle_rates_setpoint", axis.to_string(), 1.0, "rad/s", "what the attitude loop asks for");
    let up = "z points down: sign turned";
    let thrust = moving(
        log,
        [
            one("vehicle_thrust_setpoint", "xyz[2]".to_owned(), -1.0, "1", up),
            one("actuator_controls_0", "control[3]".to_owned(), 1.0, "1", "what is asked of the mixer"),
            one("vehicle_rates_setpoint", "thrust_body[2]".to_owned(), -1.0, "1", up),
            one("vehicle_rates_setpoint", "thrust".to_owned(), 1.0, "1", "what the rate controller is given"),
            one(
                "vehicle_attitude_setpoint",
                "thrust".to_owned(),
                1.0,
                "1",
                "what the attitude loop is given",
            ),
        ],
    );
    let battery = one("battery_status", "voltage_v".to_owned(), 1.0, "V", "as measured");
    Channels { input, rate, angle, setpoint, thrust, battery }
}

/// What makes PX4 log torque and rates fast.
///
/// Source: parameter reference; `src/modules/logger/logged_topics.cpp`, where bit 3 of `SDLOG_PROFILE` adds the gyro,
/// the torque set-point and the motors at full rate.
pub(super) fn settings(log: &Log) -> Vec<Setting> {
    const DEFAULT_TOPICS: u32 = 1 << 0;
    const SYSTEM_IDENTIFICATION: u32 = 1 << 3;
    let now = log.parameter("SDLOG_PROFILE").filter(|mask| (0.0..4e9).contains(mask)).unwrap_or(0.0);
    let profile = (now as u32 | DEFAULT_TOPICS | SYSTEM_IDENTIFICATION).to_string();
    let mut settings = vec![Setting::new(
        log,
        "SDLOG_PROFILE",
        profile,
        "bit 3: gyro, torque set-point and motors at full rate, beside the default topics; restart after",
    )];
    if log.parameter("SDLOG_MODE").is_none_or(|mode| mode != 0.0) {
        settings.push(Setting::new(log, "SDLOG_MODE", "0", "log from arming to disarming"));
    }
    if log.parameter("IMU_GYRO_RATEMAX").is_none_or(|rate| rate < 400.0) {
        let effect = "rate loop, and its topics, at 400 Hz (1.11 and later)";
        settings.push(Setting::new(log, "IMU_GYRO_RATEMAX", "400", effect));
    }
    settings
}

/// The field that says that the craft was armed in none of its rows, where the outputs to the motors, if logged, never change.
pub(super) fn never_armed(log: &Log) -> Option<&'static str> {
    const ARMED: f64 = 2.0;
    let largest = |topic: &str, field: &str| {
        let topic = richest(log, topic)?;
        let field = topic.fields.iter().find(|known| known.name == field)?;
        field.values.iter().copied().reduce(f64::max)
    };
    let never = largest("vehicle_status", "arming_state")? < ARMED;
    let turns = richest(log, "actuator_outputs").is_some_and(|topic| {
        let outputs = topic.fields.iter().filter(|field| field.name.starts_with("output["));
        outputs.into_iter().any(|field| field.values.windows(2).any(|pair| pair[0] != pair[1]))
    });
    (never && !turns).then_some("vehicle_status.arming_state")
}
