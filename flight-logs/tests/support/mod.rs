//! Small logs of each format, made here: two or three kinds of message, `rows` rows of the main one.

/// Appends a ULog message.
pub fn message(bytes: &mut Vec<u8>, kind: u8, body: &[u8]) {
    bytes.extend((body.len() as u16).to_le_bytes());
    bytes.push(kind);
    bytes.extend(body);
}

fn keyed(key: &str, value: &[u8]) -> Vec<u8> {
    [&[key.len() as u8][..], key.as_bytes(), value].concat()
}

/// PX4: rates at 250 Hz, torque, a parameter that changes, text, a dropout.
pub fn ulog(rows: u16) -> Vec<u8> {
    let mut bytes = b"ULog\x01\x12\x35\x01".to_vec();
    bytes.extend(1_000_000_u64.to_le_bytes());
    message(&mut bytes, b'B', &[0; 40]);
    message(&mut bytes, b'F', b"rates:uint64_t timestamp;float[3] xyz;uint8_t flag;uint8_t[3] _padding0;");
    message(&mut bytes, b'F', b"torque:uint64_t timestamp;rates nested;char[4] label;");
    message(&mut bytes, b'I', &keyed("char[9] sys_name", b"PX4-quad!"));
    message(&mut bytes, b'P', &keyed("float MC_PITCHRATE_P", &0.15_f32.to_le_bytes()));
    message(&mut bytes, b'A', &[&[0, 7, 0][..], b"rates"].concat());
    message(&mut bytes, b'A', &[&[1, 8, 0][..], b"torque"].concat());
    for k in 0..rows {
        let time = (1_000_000 + 4000 * u64::from(k)).to_le_bytes();
        let rate = f32::from(k).sin().to_le_bytes();
        let row = [&time[..], &rate, &rate, &rate, &[1]].concat();
        message(&mut bytes, b'D', &[&[7, 0], &row[..]].concat());
        if k % 10 == 9 {
            message(&mut bytes, b'D', &[&[8, 0][..], &time, &row, &[0; 3], b"abcd"].concat());
            message(&mut bytes, b'S', &[0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]);
        }
        if k == 20 {
            message(&mut bytes, b'O', &[20, 0]);
            message(&mut bytes, b'L', &[&[b'6'][..], &time, b"armed"].concat());
            message(&mut bytes, b'P', &keyed("float MC_PITCHRATE_P", &0.2_f32.to_le_bytes()));
        }
    }
    bytes
}

fn padded(text: &str, length: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(length, 0);
    bytes
}

fn definition(kind: u8, length: u8, name: &str, format: &str, columns: &str) -> Vec<u8> {
    [&[0xa3, 0x95, 128, kind, length][..], &padded(name, 4), &padded(format, 16), &padded(columns, 64)]
        .concat()
}

/// ArduPilot: two IMUs in one message, batches, a parameter, text, units.
pub fn dataflash(rows: u16) -> Vec<u8> {
    let mut bytes = definition(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    bytes.extend(definition(1, 16, "IMU", "QBf", "TimeUS,I,GyrY"));
    bytes.extend(definition(2, 75, "ISBD", "Qa", "TimeUS,x"));
    bytes.extend(definition(3, 31, "PARM", "QNf", "TimeUS,Name,Value"));
    bytes.extend(definition(4, 75, "MSG", "QZ", "TimeUS,Message"));
    bytes.extend(definition(5, 44, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"));
    let head = |kind: u8, k: u16| {
        [&[0xa3, 0x95, kind][..], &(2_000_000 + 2500 * u64::from(k)).to_le_bytes()].concat()
    };
    bytes.extend([&head(5, 0)[..], &[1], &padded("s#E", 16), &padded("F--", 16)].concat());
    bytes.extend([&head(3, 0)[..], &padded("LOG_BITMASK", 16), &176126_f32.to_le_bytes()].concat());
    bytes.extend([&head(4, 0)[..], &padded("ArduCopter V4.6.2 (1ebd4d99)", 64)].concat());
    for k in 0..rows {
        for instance in 0..2 {
            bytes.extend([&head(1, k)[..], &[instance], &f32::from(k).cos().to_le_bytes()].concat());
        }
        if k % 10 == 9 {
            bytes.extend([&head(2, k)[..], &[k as u8; 64]].concat());
        }
    }
    bytes
}

/// ArduPilot, text.
pub fn dataflash_text(rows: u16) -> Vec<u8> {
    let mut text = "9\n\nArduCopter V3.1\nFMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format\n\
                    FMT, 129, 23, PARM, Nf, Name,Value\nFMT, 130, 15, IMU, If, TimeMS,GyrY\n\
                    FMT, 131, 5, MODE, Mh, Mode,ThrCrs\nPARM, RATE_PIT_P, 0.15\n"
        .to_owned();
    for k in 0..rows {
        text += &format!("IMU, {}, {:.3}\n", 4 * k, f32::from(k).sin());
        if k % 10 == 9 {
            text += "MODE, STABILIZE, 352\n";
        }
    }
    text.into_bytes()
}

fn variable(bytes: &mut Vec<u8>, mut value: u32) {
    while value > 127 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

fn zigzag(value: i32) -> u32 {
    (value << 1 ^ value >> 31) as u32
}

/// The motion of the blackbox log: gyro of the row `k` on axis `axis`.
pub fn gyro(k: i32, axis: i32) -> i32 {
    50 * (k % 7) - 100 * axis + k
}

/// Betaflight: a frame I every 32 iterations, all iterations logged; predictions by the last frame and by a line.
pub fn blackbox(rows: u16) -> Vec<u8> {
    let mut bytes = b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n\
        H I interval:32\nH P interval:1/1\nH Craft name:small\nH gyro_scale:0x3f800000\n\
        H Field I name:loopIteration,time,gyroADC[0],gyroADC[1],gyroADC[2],motor[0],motor[1]\n\
        H Field I signed:0,0,1,1,1,0,0\nH Field I predictor:0,0,0,0,0,4,5\nH Field I encoding:1,1,0,0,0,1,0\n\
        H Field P predictor:6,2,1,1,1,1,1\nH Field P encoding:9,0,7,7,7,0,0\n\
        H Field S name:flightModeFlags\nH Field S signed:0\nH Field S predictor:0\nH Field S encoding:1\n\
        H minthrottle:1000\n"
        .to_vec();
    bytes.extend([b'S', 3]);
    for k in 0..i32::from(rows) {
        if k % 32 == 0 {
            bytes.push(b'I');
            variable(&mut bytes, k as u32);
            variable(&mut bytes, 5_000_000 + 1000 * k as u32);
            for axis in 0..3 {
                variable(&mut bytes, zigzag(gyro(k, axis)));
            }
            variable(&mut bytes, 200 + k as u32);
            variable(&mut bytes, zigzag(-30));
        } else {
            bytes.push(b'P');
            // A frame I counts as both the last and the one before it.
            variable(&mut bytes, zigzag(if k % 32 == 1 { 1000 } else { 0 }));
            bytes.push(0b11_01_01_01);
            for axis in 0..3 {
                bytes.extend(((gyro(k, axis) - gyro(k - 1, axis)) as i16).to_le_bytes());
            }
            variable(&mut bytes, zigzag(1));
            variable(&mut bytes, zigzag(1));
        }
        if k == 40 {
            bytes.extend(b"E\x0f\x02");
        }
    }
    bytes.extend(b"E\xffEnd of log\0");
    bytes
}

/// MAVLink 2: attitudes with their times of arrival.
pub fn tlog(rows: u16) -> Vec<u8> {
    use messages::board::{ATTITUDE_DATA, MavMessage};
    let mut bytes = Vec::new();
    for k in 0..rows {
        bytes.extend((1_700_000_000_000_000 + 100_000 * u64::from(k)).to_be_bytes());
        let attitude = ATTITUDE_DATA {
            time_boot_ms: 100 * u32::from(k) + 1,
            pitch: f32::from(k).sin(),
            pitchspeed: f32::from(k).cos(),
            ..ATTITUDE_DATA::default()
        };
        let header = messages::MavHeader { system_id: 1, component_id: 1, sequence: k as u8 };
        messages::write_v2_msg(&mut bytes, header, &MavMessage::ATTITUDE(attitude))
            .expect("written to memory");
    }
    bytes
}

/// What `ulog2csv` writes of a topic.
pub fn ulog_csv(rows: u16) -> Vec<u8> {
    let mut text = "timestamp,gyro_rad[0],gyro_rad[1]\n".to_owned();
    for k in 0..rows {
        text += &format!("{},{:.4},nan\n", 4000 * u32::from(k), f32::from(k).sin());
    }
    text.into_bytes()
}
