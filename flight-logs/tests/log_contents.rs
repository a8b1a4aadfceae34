//! What is read from small logs whose contents are known.

mod support;

use flight_logs::{Field, Format, Log, Topic, parse, sniff};

fn log(name: &str, bytes: &[u8]) -> Log {
    let mut logs = parse(name, bytes).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(logs.len(), 1);
    assert_eq!(Some(logs[0].format), sniff(bytes));
    logs.remove(0)
}

fn topic<'a>(log: &'a Log, name: &str, instance: u8) -> &'a Topic {
    log.topic(name, instance).unwrap_or_else(|| panic!("no topic {name}.{instance}"))
}

fn field<'a>(log: &'a Log, name: &str, instance: u8, field: &str) -> &'a Field {
    topic(log, name, instance).field(field).unwrap_or_else(|| panic!("no field {name}.{instance}.{field}"))
}

#[test]
fn ulog() {
    let log = log("a.ulg", &support::ulog(50));
    let rates = topic(&log, "rates", 0);
    assert_eq!((rates.time_s.len(), rates.time_s[49]), (50, 1.0 + 0.004 * 49.0));
    assert_eq!(rates.rate_hz().map(f64::round), Some(250.0));
    let names: Vec<&str> = rates.fields.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["xyz[0]", "xyz[1]", "xyz[2]", "flag"]);
    assert_eq!(rates.fields[1].values[7], f64::from(7_f32.sin()));
    assert_eq!(field(&log, "torque", 1, "nested.xyz[2]").values[0], f64::from(9_f32.sin()));
    assert_eq!(log.parameters, [("MC_PITCHRATE_P".to_owned(), f64::from(0.15_f32))]);
    assert_eq!(log.info("sys_name"), Some("PX4-quad!"));
    let said: Vec<&str> = log.messages.iter().map(|(_, text)| text.as_str()).collect();
    assert_eq!(said[..2], ["dropout: 20 ms were not logged", "armed"]);
    assert!(said[2].starts_with("parameter MC_PITCHRATE_P changed from 0.15"), "{said:?}");
    assert_eq!(log.messages[1].0, 1.08);
    assert_eq!(log.notes, ["1 dropouts: 20 ms were not logged, the longest 20 ms"]);
}

#[test]
fn dataflash() {
    let log = log("a.bin", &support::dataflash(50));
    for instance in 0..2 {
        let imu = topic(&log, "IMU", instance);
        assert_eq!((imu.time_s.len(), imu.time_s[49]), (50, 2.1225));
        assert_eq!(imu.fields.len(), 1, "the instance is no channel");
        assert_eq!(imu.fields[0].values[3], f64::from(3_f32.cos()));
    }
    assert_eq!(topic(&log, "ISBD", 0).fields.len(), 32);
    assert_eq!(field(&log, "ISBD", 0, "x[31]").values[0], f64::from(0x0909));
    assert_eq!(log.parameter("LOG_BITMASK"), Some(176126.0));
    assert_eq!(log.firmware.as_deref(), Some("ArduCopter V4.6.2 (1ebd4d99)"));
    assert_eq!(log.notes, Vec::<String>::new());
}

#[test]
fn dataflash_text() {
    let log = log("a.log", &support::dataflash_text(50));
    let imu = topic(&log, "IMU", 0);
    assert_eq!((imu.time_s.len(), imu.time_s[49], imu.fields[0].values[1]), (50, 0.196, 0.841));
    let mode = topic(&log, "MODE", 0);
    assert_eq!(mode.fields.len(), 1, "words are no channel");
    assert!((mode.time_s[0] - 0.038).abs() < 1e-12, "between the rows around it: {}", mode.time_s[0]);
    assert_eq!(log.parameter("RATE_PIT_P"), Some(0.15));
}

#[test]
fn blackbox() {
    let log = log("a.bbl", &support::blackbox(50));
    let main = topic(&log, "main", 0);
    assert_eq!((main.time_s.len(), main.time_s[0], main.time_s[49]), (50, 5.0, 5.049));
    for axis in 0..3 {
        let gyro = field(&log, "main", 0, &format!("gyroADC[{axis}]"));
        assert_eq!(gyro.unit.as_deref(), Some("rad/s"));
        for (k, value) in gyro.values.iter().enumerate() {
            let expected = f64::from(support::gyro(k as i32, axis)).to_radians();
            assert!((value - expected).abs() < 1e-12, "axis {axis}, row {k}: {value}, expected {expected}");
        }
    }
    assert_eq!(field(&log, "main", 0, "loopIteration").values[49], 49.0);
    assert_eq!(field(&log, "main", 0, "motor[0]").values[31], 1231.0);
    assert_eq!(field(&log, "main", 0, "motor[1]").values[31], 1201.0);
    assert_eq!(field(&log, "slow", 0, "flightModeFlags").values, [3.0]);
    assert_eq!(log.messages, [(5.04, "disarmed, reason 2".to_owned())]);
    assert_eq!(log.vehicle.as_deref(), Some("small"));
    assert_eq!(log.notes, Vec::<String>::new());
}

#[test]
fn two_flights_in_one_blackbox_file() {
    let mut bytes = support::blackbox(50);
    bytes.extend([0xff; 100]);
    bytes.extend(support::blackbox(20));
    let logs = parse("a.bbl", &bytes).unwrap();
    let rows: Vec<usize> = logs.iter().map(|log| topic(log, "main", 0).time_s.len()).collect();
    assert_eq!(rows, [50, 20]);
    assert!(logs.iter().all(|log| log.notes.is_empty()));
}

#[test]
fn tlog() {
    let log = log("a.tlog", &support::tlog(50));
    let attitude = topic(&log, "ATTITUDE", 1);
    assert_eq!((attitude.time_s.len(), attitude.time_s[1]), (50, 1_700_000_000.1));
    assert_eq!(field(&log, "ATTITUDE", 1, "pitch").values[2], f64::from(2_f32.sin()));
    assert_eq!(field(&log, "ATTITUDE", 1, "time_boot_ms").values[2], 201.0);
}

#[test]
fn ulog2csv() {
    let log = log("x_sensor_combined_0.csv", &support::ulog_csv(50));
    assert_eq!(log.format, Format::Ulog2Csv);
    let sensors = topic(&log, "sensor_combined", 0);
    assert_eq!((sensors.time_s.len(), sensors.time_s[49], sensors.fields[0].values[1]), (50, 0.196, 0.8415));
    assert!(sensors.fields[1].values[0].is_nan());
}
