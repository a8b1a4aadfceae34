//! Real logs against independent decoders: number of rows, first and last time, and sum of finite values.
//!
//! The numbers below are those of pyulog 1.3.0 (ULog), pymavlink 2.4.50 (DataFlash, tlog) and orangebox 0.5.0
//! (blackbox; gyro rates there as logged, in °/s). All fields of all topics were compared once with these decoders;
//! here stand a few of each file.

use std::path::{Path, PathBuf};

use flight_logs::{Format, Log, read};

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

fn logs(name: &str) -> Option<Vec<Log>> {
    let path = file(name)?;
    Some(read(&[&path]).unwrap_or_else(|error| panic!("{error}")))
}

struct Row {
    topic: (&'static str, u8),
    rows: usize,
    times_s: [f64; 2],
    sums: &'static [(&'static str, f64)],
}

fn check(log: &Log, expected: &[Row]) {
    for Row { topic: (name, instance), rows, times_s, sums } in expected {
        let topic = log.topic(name, *instance).unwrap_or_else(|| panic!("no topic {name}.{instance}"));
        assert_eq!(topic.time_s.len(), *rows, "{name}");
        for (found, expected) in [topic.time_s[0], topic.time_s[rows - 1]].iter().zip(times_s) {
            assert!((found - expected).abs() < 2e-6, "{name}: {found} s, expected {expected}");
        }
        for (field, expected) in *sums {
            let field = topic.field(field).unwrap_or_else(|| panic!("no field {name}.{field}"));
            let sum: f64 = field.values.iter().filter(|value| value.is_finite()).sum();
            let near = (sum - expected).abs() <= 1e-9 * expected.abs().max(1.0);
            assert!(near, "{name}.{}: {sum}, expected {expected}", field.name);
        }
    }
}

fn row(
    topic: (&'static str, u8),
    rows: usize,
    times_s: [f64; 2],
    sums: &'static [(&'static str, f64)],
) -> Row {
    Row { topic, rows, times_s, sums }
}

fn notes_with(log: &Log, words: &str) -> usize {
    log.notes.iter().filter(|note| note.contains(words)).count()
}

#[test]
fn px4_logs_of_all_ages() {
    let Some(logs_2016) = logs("px4/quad_2016_auavx21_flight.ulg") else { return };
    let log = &logs_2016[0];
    assert_eq!((log.format, log.vehicle.as_deref()), (Format::ULog, Some("AUAV_X21")));
    assert_eq!((log.parameters.len(), log.messages.len()), (493, 8 + 4));
    assert_eq!(log.notes, ["4 dropouts: 119 ms were not logged, the longest 62 ms"]);
    let attitude = &[("q[0]", 6144.352904975414), ("q[2]", 306.5053384612256)];
    check(
        log,
        &[
            row(
                ("actuator_controls_0", 0),
                3269,
                [112.574774, 181.4812],
                &[("control[1]", -311.65248487424105)],
            ),
            row(
                ("sensor_combined", 0),
                17070,
                [112.614307, 181.493506],
                &[("gyro_rad[1]", -52.66588105221399)],
            ),
            row(("vehicle_attitude", 0), 6461, [112.574307, 181.488706], attitude),
        ],
    );
    let Some(logs_2019) = logs("px4/quad_v1.9_fmuv3_motor_failure.ulg") else { return };
    check(
        &logs_2019[0],
        &[row(("esc_status", 0), 127, [5081.348405, 5120.249475], &[("esc[3].esc_rpm", 313018.0)])],
    );
    let Some(rig) = logs("px4/s250_flight3_log1.ulg") else { return };
    check(
        &rig[0],
        &[
            row(("sensor_gyro", 0), 9472, [20.401559, 66.519959], &[("y", 10.30179688636008)]),
            row(
                ("vehicle_rates_setpoint", 0),
                9399,
                [20.393133, 66.520543],
                &[("pitch", -287.1335213740931)],
            ),
        ],
    );
    let Some(vtol) = logs("px4/vtol_v1.11.2_cubeorange_servo_bench.ulg") else { return };
    check(
        &vtol[0],
        &[
            row(
                ("vehicle_angular_velocity", 0),
                1812,
                [20.327115, 26.82571],
                &[("xyz[1]", -1.9087478083000775)],
            ),
            row(
                ("actuator_controls_0", 0),
                1812,
                [20.327133, 26.82573],
                &[("control[1]", 73.34532544510753)],
            ),
        ],
    );
}

#[test]
fn px4_log_of_a_present_release() {
    let Some(logs) = logs("px4/quad_v1.15.1_fmuv6c_brownout.ulg") else { return };
    let log = &logs[0];
    assert_eq!(log.firmware.as_deref(), Some("PX4 v1.15.1 (93eef0c787)"));
    assert_eq!((log.parameters.len(), log.parameter("IMU_GYRO_RATEMAX")), (1096, Some(800.0)));
    assert_eq!(log.notes, Vec::<String>::new());
    check(
        log,
        &[
            row(
                ("vehicle_torque_setpoint", 0),
                3803,
                [158.987664, 235.009828],
                &[("xyz[1]", -120.89052150000134)],
            ),
            row(
                ("vehicle_angular_velocity", 0),
                3803,
                [158.987654, 235.009818],
                &[("xyz[1]", 0.15942282148171216)],
            ),
            row(("sensor_gyro", 1), 76, [159.789362, 234.787608], &[("x", -5.625089629553258)]),
            row(("battery_status", 0), 382, [158.98693, 234.987044], &[("voltage_v", 18.27736541000195)]),
        ],
    );
}

#[test]
fn px4_log_with_appended_data() {
    let Some(logs) = logs("px4/quad_2017_fmuv4pro_appended.ulg") else { return };
    let log = &logs[0];
    assert_eq!(log.notes, Vec::<String>::new());
    let sensors = &[("gyro_rad[0]", -9.165098065610437), ("accelerometer_m_s2[2]", -23543.02658843994)];
    check(
        log,
        &[
            row(("sensor_combined", 0), 2373, [12.262822, 21.880422], sensors),
            row(("actuator_outputs", 1), 96, [12.262584, 21.81704], &[("output[0]", 144000.0)]),
        ],
    );
    // What was appended: the reports on three crashes.
    let reports: Vec<&String> =
        log.info.iter().filter(|(key, _)| key == "hardfault_plain").map(|(_, text)| text).collect();
    assert_eq!(reports.len(), 3);
    assert!(reports.iter().all(|text| text.trim_end().ends_with("END Fault Log --")), "whole texts");
}

#[test]
fn px4_log_with_events_and_unix_time() {
    let Some(logs) = logs("px4/sitl_quad_2024_events.ulg") else { return };
    let tx = &[("tx_rate_avg", 41476.097412109375)];
    check(
        &logs[0],
        &[
            row(
                ("vehicle_attitude", 0),
                622,
                [1710773350.434, 1710773381.434],
                &[("q[0]", 621.9658616781235)],
            ),
            row(("telemetry_status", 3), 31, [1710773350.318, 1710773380.502], tx),
            row(("event", 0), 38, [1710773350.054, 1710773380.486], &[("id", 853614256.0)]),
        ],
    );
}

#[test]
fn ardupilot_log_that_starts_in_the_middle() {
    let Some(logs) = logs("ardupilot/copter_3.6_quad_short.bin") else { return };
    let log = &logs[0];
    assert_eq!(log.format, Format::DataFlash);
    assert_eq!((log.parameters.len(), log.parameter("ATC_RAT_PIT_FILT")), (772, Some(20.0)));
    let rates = &[("PDes", 102.57837075740099), ("P", 46.86324482224882), ("POut", -29.001257749972865)];
    check(
        log,
        &[
            row(("RATE", 0), 504, [402.617298, 453.494914], rates),
            row(("IMU", 0), 1258, [402.644506, 453.502278], &[("GyrY", 8.65961614443222)]),
            row(("ATT", 0), 504, [402.617284, 453.4949], &[("Pitch", -228.6199999999998)]),
            row(("RCOU", 0), 504, [402.617781, 453.495406], &[("C1", 727961.0)]),
            row(("POS", 0), 504, [402.617674, 453.495161], &[("Lat", 26227.330051800032)]),
        ],
    );
}

#[test]
fn ardupilot_logs_with_units_instances_and_arrays() {
    let Some(simulated) = logs("ardupilot/sitl_copter_4.7_quad.BIN") else { return };
    let log = &simulated[0];
    assert_eq!(log.firmware.as_deref(), Some("ArduCopter V4.7.0-beta6-SFD (fea9ea77)"));
    check(
        log,
        &[
            row(("RATE", 0), 461, [2.539817, 56.439082], &[("POut", -0.05759928237989698)]),
            row(("IMU", 0), 397, [2.519825, 56.359114], &[("GyrY", 0.2770490746216865)]),
            row(("BARO", 1), 461, [2.539817, 56.439082], &[("Alt", 444.6427001953125)]),
            row(("XKF1", 1), 456, [3.539417, 56.439082], &[("Pitch", -106.79999999999991)]),
        ],
    );
    let unit = |topic: &str, field: &str| log.topic(topic, 0)?.field(field)?.unit.clone();
    assert_eq!(unit("IMU", "GyrY").as_deref(), Some("rad/s"));
    assert_eq!(unit("ATT", "Pitch").as_deref(), Some("deg"));
    assert_eq!(unit("BAT", "Volt").as_deref(), Some("V"));

    let Some(cut) = logs("ardupilot/copter_4.6.2_head_80k.bin") else { return };
    check(&cut[0], &[row(("ATT", 0), 5, [140.186526, 140.593234], &[("Pitch", 17.605733633041382)])]);
    assert_eq!(cut[0].vehicle.as_deref(), Some("QUAD/X"));
    assert_eq!(notes_with(&cut[0], "bad bytes"), 1, "{:?}", cut[0].notes);
    // Vibration in batches of 32 numbers to a field; the decoder's sum is over all of them.
    let batches = cut[0].topic("ISBD", 0).expect("vibration was logged");
    let all: f64 = batches
        .fields
        .iter()
        .filter(|field| field.name.starts_with("x["))
        .flat_map(|field| &field.values)
        .sum();
    assert_eq!(all, 2313.0);
}

#[test]
fn ardupilot_text_log() {
    let Some(logs) = logs("ardupilot/copter_3.1_mechanical_fail.log") else { return };
    let log = &logs[0];
    assert_eq!(
        (log.format, log.firmware.as_deref()),
        (Format::DataFlashText, Some("ArduCopter V3.1 (5c6503e2)"))
    );
    assert_eq!(log.parameters.len(), 289);
    let attitude = log.topic("ATT", 0).expect("there are attitudes");
    assert_eq!(attitude.time_s.len(), 1100);
    assert_eq!(attitude.field("Pitch").map(|field| field.values[0]), Some(-4.66));
    assert!(attitude.time_s.windows(2).all(|pair| pair[0] <= pair[1]), "spread in order");
    assert_eq!(notes_with(log, "without time stamps"), 1, "{:?}", log.notes);
}

#[test]
fn telemetry_log() {
    let Some(logs) = logs("mavlink/copter_2016_flight.tlog") else { return };
    let log = &logs[0];
    let attitude = &[
        ("pitch", -116.17970838025212),
        ("pitchspeed", -1.0356655549367133),
        ("time_boot_ms", 1017811637.0),
    ];
    check(
        log,
        &[
            row(("ATTITUDE", 1), 2829, [1436056006.15866, 1436057055.153708], attitude),
            row(
                ("RC_CHANNELS_RAW", 1),
                2831,
                [1436056006.04666, 1436057055.258872],
                &[("chan3_raw", 3890797.0)],
            ),
        ],
    );
    assert_eq!(log.messages.len(), 25);
    // 1314 packets of 13 bytes with a wrong checksum, each with its 8 bytes of time, and a cut-off one of 19.
    let bad = format!("{} bad bytes in 1315 places", 1314 * (13 + 8) + 19);
    assert_eq!(notes_with(log, &bad), 1, "{:?}", log.notes);
}

#[test]
fn several_flights_in_one_blackbox_file() {
    let Some(bench) = logs("betaflight/bf4.2.11_bench_500Hz.bbl") else { return };
    assert_eq!(bench.len(), 2);
    check(
        &bench[0],
        &[row(("main", 0), 98, [33.011567, 33.206271], &[("loopIteration", 76048.0), ("motor[0]", 15719.0)])],
    );
    check(
        &bench[1],
        &[row(
            ("main", 0),
            24893,
            [191.882474, 241.860649],
            &[
                ("loopIteration", 4957092448.0),
                ("axisP[1]", 10527.0),
                ("motor[3]", 6542072.0),
                ("gyroADC[1]", -6556.0 * DEGREE),
            ],
        )],
    );
    let Some(flights) = logs("betaflight/bf4.2.9_roma_f5_3flights.bbl") else { return };
    let expected = [
        row(
            ("main", 0),
            16420,
            [220.155884, 286.062259],
            &[("loopIteration", 2156799840.0), ("axisI[1]", 105472.0)],
        ),
        row(
            ("main", 0),
            22168,
            [293.002787, 381.993134],
            &[("loopIteration", 3931184448.0), ("axisI[1]", 257386.0)],
        ),
        row(
            ("main", 0),
            32387,
            [386.138384, 516.162512],
            &[("loopIteration", 8391083056.0), ("axisI[1]", 297837.0)],
        ),
    ];
    assert_eq!(flights.len(), expected.len());
    for (log, row) in flights.iter().zip(expected) {
        assert_eq!(log.vehicle.as_deref(), Some("DIATONE ROMA F5"));
        check(log, &[row]);
    }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

#[test]
fn one_flight_in_a_blackbox_file() {
    let Some(hover) = logs("betaflight/LOG00037.BFL") else { return };
    let sums = &[
        ("loopIteration", 1125401208.0),
        ("axisP[1]", -7103.0),
        ("motor[3]", 12439591.0),
        ("gyroADC[1]", -5645.0 * DEGREE),
    ];
    check(&hover[0], &[row(("main", 0), 16774, [452.208896, 469.230773], sums)]);
    assert_eq!(hover[0].parameter("pitchPID[1]"), Some(126.0));
    assert_eq!(hover[0].notes, Vec::<String>::new());

    // The log starts with "logging resumes" and an I frame, which orangebox skips; blackbox-log 0.4.3 counts the same.
    let Some(freestyle) = logs("betaflight/btfl_002.bbl") else { return };
    let main = freestyle[0].topic("main", 0).expect("there are main frames");
    assert_eq!((main.time_s.len(), main.time_s[0], main.time_s[66639]), (66640, 17.433272, 151.271525));
}

#[test]
fn two_csv_files_are_one_log() {
    let (Some(controls), Some(sensors)) = (
        file("px4/zmr250_2016_flips_actuator_controls_0.csv"),
        file("px4/zmr250_2016_flips_sensor_combined_0.csv"),
    ) else {
        return;
    };
    let logs = read(&[&controls, &sensors]).unwrap();
    assert_eq!((logs.len(), logs[0].format), (1, Format::Ulog2Csv));
    let controls = logs[0].topic("actuator_controls_0", 0).expect("named by the file");
    assert_eq!((controls.time_s.len(), controls.time_s[0]), (4734, 10.091977));
    let sensors = logs[0].topic("sensor_combined", 0).expect("named by the file");
    assert_eq!((sensors.time_s.len(), sensors.time_s[0]), (24866, 10.131122));
    assert_eq!(sensors.field("gyro_rad[1]").map(|field| field.values[0]), Some(-0.0191978));
}
