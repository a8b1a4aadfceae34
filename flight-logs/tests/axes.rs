//! Which channels are proposed of logs, and what is said of those that do not serve.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use flight_logs::axes::{Axis, Channel, Formula, Proposal, propose};
use flight_logs::{Field, Format, Log, Topic, read};

/// A topic: name, rows per second, name and size of each field.
type Shape<'a> = (&'a str, f64, &'a [(&'a str, f64)]);

/// A log with these topics of 5 s; field `n` is sin(k + n) times its size.
fn made(format: Format, topics: &[Shape]) -> Log {
    let topic = |&(name, rate_hz, fields): &Shape| Topic {
        name: name.to_owned(),
        instance: 0,
        time_s: (0..=(5.0 * rate_hz) as u32).map(|k| f64::from(k) / rate_hz).collect(),
        fields: fields
            .iter()
            .enumerate()
            .map(|(n, &(name, size))| Field {
                name: name.to_owned(),
                unit: None,
                values: (0..=(5.0 * rate_hz) as u32)
                    .map(|k| size * (f64::from(k) + n as f64).sin())
                    .collect(),
            })
            .collect(),
    };
    Log {
        format,
        vehicle: None,
        firmware: None,
        topics: topics.iter().map(topic).collect(),
        parameters: Vec::new(),
        info: Vec::new(),
        messages: Vec::new(),
        notes: Vec::new(),
    }
}

fn input(proposal: &Proposal) -> String {
    proposal.channels.input.as_ref().map(ToString::to_string).unwrap_or_default()
}

fn rate(proposal: &Proposal) -> String {
    proposal.channels.rate.as_ref().map(ToString::to_string).unwrap_or_default()
}

#[test]
fn px4_takes_the_faster_gyro_and_the_new_torque() {
    let log = made(
        Format::ULog,
        &[
            ("vehicle_torque_setpoint", 50.0, &[("xyz[0]", 0.1), ("xyz[1]", 0.1), ("xyz[2]", 0.1)]),
            ("vehicle_angular_velocity", 50.0, &[("xyz[0]", 1.0), ("xyz[1]", 1.0), ("xyz[2]", 1.0)]),
            ("sensor_combined", 250.0, &[("gyro_rad[0]", 1.0), ("gyro_rad[1]", 1.0), ("gyro_rad[2]", 1.0)]),
            ("vehicle_thrust_setpoint", 50.0, &[("xyz[2]", 0.5)]),
        ],
    );
    for (axis, i) in Axis::ALL.into_iter().zip(0..) {
        let proposal = propose(&log, axis);
        assert!(proposal.serves() && proposal.settings.is_empty(), "{proposal:?}");
        assert_eq!(input(&proposal), format!("vehicle_torque_setpoint.xyz[{i}]"));
        assert_eq!(rate(&proposal), format!("sensor_combined.gyro_rad[{i}]"));
        let thrust = proposal.channels.thrust.expect("thrust is logged").series(&log);
        assert_eq!(thrust.values[1], -0.5 * 1_f64.sin(), "up positive");
    }
}

#[test]
fn ardupilot_rates_are_turned_into_radians() {
    let log = made(
        Format::DataFlash,
        &[("RATE", 400.0, &[("P", 90.0), ("PDes", 90.0), ("POut", 0.1)]), ("IMU", 25.0, &[("GyrY", 1.0)])],
    );
    let proposal = propose(&log, Axis::Pitch);
    assert!(proposal.serves(), "{:?}", proposal.hindrances);
    assert_eq!((input(&proposal).as_str(), rate(&proposal).as_str()), ("RATE.POut", "RATE.P * 0.017453"));
    let series = proposal.channels.rate.expect("found").series(&log);
    assert!((series.values[1] - PI / 2.0 * 1_f64.sin()).abs() < 1e-12);
    let yaw = propose(&log, Axis::Yaw);
    assert!(!yaw.serves() && yaw.hindrances[0].contains("no input of yaw"), "{:?}", yaw.hindrances);
}

#[test]
fn ardupilot_motors_are_mixed_back_where_the_controller_is_not_logged() {
    let outputs: &[(&str, f64)] = &[("C1", 0.0), ("C2", 0.0), ("C3", 0.0), ("C4", 0.0)];
    let mut log = made(Format::DataFlash, &[("RCOU", 100.0, outputs), ("IMU", 100.0, &[("GyrX", 1.0)])]);
    // Nose up by 100 µs each: motors 1 and 3 stand in front.
    for (field, value) in log.topics[0].fields.iter_mut().zip([1600.0, 1400.0, 1600.0, 1400.0]) {
        field.values.fill(value);
    }
    let mixed = |log: &Log, axis| {
        let value = propose(log, axis).channels.input?.series(log).values[0];
        Some((value * 1e9).round() / 1e9)
    };
    assert_eq!(Axis::ALL.map(|axis| mixed(&log, axis)), [Some(0.0), Some(0.1), Some(-0.0)]);
    // Motor 1 on the second output and the reverse: the craft rolls and yaws.
    let functions = [("SERVO1_FUNCTION", 34.0), ("SERVO2_FUNCTION", 33.0), ("SERVO3_FUNCTION", 35.0)];
    log.parameters = functions.map(|(name, value)| (name.to_owned(), value)).to_vec();
    log.parameters.push(("SERVO4_FUNCTION".to_owned(), 36.0));
    assert_eq!(mixed(&log, Axis::Pitch), Some(0.0));
    log.parameters.push(("FRAME_CLASS".to_owned(), 2.0));
    assert_eq!(mixed(&log, Axis::Pitch), None, "no mix is known of a hexacopter");
}

#[test]
fn betaflight_adds_the_terms_that_are_logged() {
    let log = made(
        Format::Blackbox,
        &[("main", 500.0, &[("gyroADC[0]", 1.0), ("motor[0]", 9.0), ("motor[1]", 9.0)])],
    );
    let proposal = propose(&log, Axis::Roll);
    assert_eq!(rate(&proposal), "main.gyroADC[0]");
    assert_eq!(input(&proposal), "", "two motors are no quadrotor");
    assert!(proposal.settings.iter().any(|setting| setting.parameter == "blackbox_disable_pids"));

    let names = |firmware: &str| -> Vec<&str> {
        let log = Log { firmware: Some(firmware.to_owned()), ..log.clone() };
        propose(&log, Axis::Roll).settings.iter().map(|setting| setting.parameter).collect()
    };
    assert_eq!(names("Betaflight 4.2.8 (101738d8e) STM32F7X2"), ["blackbox_p_ratio"]);
    assert_eq!(names("INAV 7.1.2 (4e1e59eb) KAKUTEH7"), ["blackbox_rate_num", "blackbox_rate_denom"]);

    let terms: &[(&str, f64)] =
        &[("axisP[1]", 100.0), ("axisI[1]", 10.0), ("gyroADC[1]", 1.0), ("setpoint[1]", 0.0)];
    let log = made(Format::Blackbox, &[("main", 500.0, terms)]);
    let proposal = propose(&log, Axis::Pitch);
    assert_eq!(input(&proposal), "main.axisP[1] * 0.001 + main.axisI[1] * 0.001");
    assert!(proposal.serves());
    assert!(proposal.cautions[0].contains("no motion of pitch was asked for"), "{:?}", proposal.cautions);
}

#[test]
fn values_that_are_not_set_are_left_out() {
    let mut log = made(Format::ULog, &[("sensor_combined", 250.0, &[("gyro_rad[1]", 1.0)])]);
    log.topics[0].fields[0].values[7] = f64::NAN;
    let series = propose(&log, Axis::Pitch).channels.rate.expect("found").series(&log);
    assert_eq!((series.values.len(), series.time_s[7]), (1250, 8.0 / 250.0));
}

#[test]
fn channels_by_hand_and_a_part_of_the_log() {
    let mut log = made(Format::ULog, &[("sensor_gyro", 250.0, &[("x", 1.0), ("y", 1.0)])]);
    let mut second = log.topics[0].clone();
    second.instance = 1;
    log.topics.push(second);
    let named = |name: &str| Channel::named(&log, name, -2.0, "rad/s").map(|channel| channel.to_string());
    assert_eq!(named("sensor_gyro.1.y").as_deref(), Some("sensor_gyro.1.y * -2"));
    assert_eq!(named("sensor_gyro.y").as_deref(), Some("sensor_gyro.y * -2"));
    assert_eq!([named("sensor_gyro"), named("sensor_gyro.z"), named("gyro.y")], [None, None, None]);

    log.keep(0.1, 0.2);
    assert_eq!(log.topics[1].time_s.len(), log.topics[1].fields[1].values.len());
    let [from, to] = log.span_s().expect("rows are left");
    assert!(from >= 0.1 && to < 0.2 && log.topics[0].time_s.len() == 25, "{from} {to}");
    log.keep(50.0, 60.0);
    assert!(log.topics.is_empty() && log.span_s().is_none());
}

/// The file of this name among the logs beside this checkout; `None`, with a word, where there are none.
fn file(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/logs");
    if !folder.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "no logs at {}", folder.display());
        println!("skipped: no flight logs beside this checkout");
        return None;
    }
    Some(folder.join(name))
}

#[test]
fn real_logs_that_serve() {
    for (name, flight, least_hz, input_is) in [
        ("px4/quad_v1.15.1_fmuv6c_brownout.ulg", 0, 47.0, "vehicle_torque_setpoint.xyz[1]"),
        ("betaflight/LOG00037.BFL", 0, 999.0, "main.axisP[1] * 0.001"),
        ("betaflight/btfl_002.bbl", 0, 499.0, "main.axisP[1] * 0.001"),
        ("betaflight/bf4.2.9_roma_f5_3flights.bbl", 2, 249.0, "main.axisP[1] * 0.001"),
    ] {
        let Some(path) = file(name) else { return };
        let log = &read(&[&path]).unwrap()[flight];
        let proposal = propose(log, Axis::Pitch);
        assert!(proposal.serves() && proposal.cautions.is_empty(), "{name}: {proposal:?}");
        assert!(input(&proposal).starts_with(input_is), "{name}: {}", input(&proposal));
        let channels = proposal.channels;
        assert!(
            channels.input.and_then(|channel| channel.rate_hz).is_some_and(|rate| rate > least_hz),
            "{name}"
        );
        // Where there is an attitude, its change is the integral of the rate: both have the same sign and unit.
        let (Some(angle), Some(rate)) = (channels.angle, channels.rate) else { continue };
        assert!(matches!(angle.formula, Formula::Euler { .. }));
        let (angle, rate) = (angle.series(log), rate.series(log));
        let slope = slope_of_change_by_rate(&angle.time_s, &angle.values, &rate.time_s, &rate.values);
        assert!((0.7..1.3).contains(&slope), "{name}: {slope}");
    }
}

/// Least squares of the angle's change over each of its steps by the rate's integral over the same step.
fn slope_of_change_by_rate(angle_s: &[f64], angle: &[f64], rate_s: &[f64], rate: &[f64]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for (time, value) in angle_s.windows(2).zip(angle.windows(2)) {
        let inside = rate_s.partition_point(|&t| t < time[0])..rate_s.partition_point(|&t| t < time[1]);
        let count = inside.len() as f64;
        if count > 0.0 && time[1] - time[0] < 0.2 {
            let integral = rate[inside].iter().sum::<f64>() / count * (time[1] - time[0]);
            product += integral * (value[1] - value[0]);
            square += integral * integral;
        }
    }
    product / square
}

#[test]
fn real_logs_that_do_not_serve_say_what_to_set() {
    let settings = |proposal: &Proposal| -> Vec<String> {
        proposal.settings.iter().map(|s| format!("{}={}", s.parameter, s.value)).collect()
    };
    for (name, flight, hindrance, setting) in [
        ("px4/quad_v1.9_fmuv3_motor_failure.ulg", 0, "at 9.6 Hz", Some("SDLOG_PROFILE=9")),
        ("px4/quad_2017_fmuv4pro_appended.ulg", 0, "at 9.8 Hz", Some("SDLOG_PROFILE=9")),
        ("px4/s250_flight3_log1.ulg", 0, "no input of pitch", Some("SDLOG_PROFILE=9")),
        ("px4/vtol_v1.11.2_cubeorange_servo_bench.ulg", 0, "at rest", None),
        ("px4/quad_2016_auavx21_flight.ulg", 0, "never armed", None),
        ("ardupilot/copter_3.6_quad_short.bin", 0, "at 9.9 Hz", Some("LOG_BITMASK=438271")),
        (
            "ardupilot/copter_3.1_mechanical_fail.log",
            0,
            "no angular rate of pitch",
            Some("LOG_BITMASK=263999"),
        ),
        ("mavlink/copter_2016_flight.tlog", 0, "log that the autopilot keeps", Some("INS_LOG_BAT_MASK=0")),
        ("betaflight/bf4.2.11_bench_500Hz.bbl", 0, "too short", None),
    ] {
        let Some(path) = file(name) else { return };
        let proposal = propose(&read(&[&path]).unwrap()[flight], Axis::Pitch);
        assert!(
            proposal.hindrances.iter().any(|text| text.contains(hindrance)),
            "{name}: {:?}",
            proposal.hindrances
        );
        match setting {
            Some(setting) => {
                assert!(
                    settings(&proposal).iter().any(|found| found == setting),
                    "{name}: {:?}",
                    settings(&proposal)
                );
            }
            None => assert_eq!(settings(&proposal), Vec::<String>::new(), "{name}"),
        }
    }
    let Some(bench) = file("betaflight/bf4.2.11_bench_500Hz.bbl") else { return };
    let proposal = propose(&read(&[&bench]).unwrap()[1], Axis::Pitch);
    assert!(proposal.cautions.iter().any(|text| text.contains("no motion of pitch")), "{proposal:?}");
}
