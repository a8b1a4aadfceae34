//! `pitchid fly` flies the emulated chip: the real command, the real image, the simulated aircraft.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};

use firmware::link::decoder::Decoder;
use messages::MavlinkVersion::V2;
use messages::Message;
use messages::board::{DEBUG_FLOAT_ARRAY_DATA, MavMessage};
use pitchid_tests::chip::case::scenario;
use pitchid_tests::chip::{Emulator, Pilot, Simulated};

/// Hands on what the ground has sent since.
fn uplink(ground: &mut TcpStream, pilot: &mut Pilot) {
    let mut bytes = [0; 1024];
    // nothing has come, or the ground has hung up
    let count = ground.read(&mut bytes).unwrap_or(0);
    pilot.emulator.send(&bytes[..count]);
}

/// One cycle; everything that the chip says in it goes to the ground. The command in rad and the report.
fn cycle(
    ground: &mut TcpStream,
    pilot: &mut Pilot,
    decoder: &mut Decoder,
    aircraft: &mut Simulated,
    tick: u32,
) -> DEBUG_FLOAT_ARRAY_DATA {
    pilot.send(&aircraft.sense(tick).0);
    let (mut u_rad, mut told) = (0.0, None);
    while told.is_none() {
        let bytes = pilot.emulator.receive();
        for &byte in &bytes {
            decoder.push(byte, |frame| match MavMessage::parse(V2, frame.id(), frame.payload()) {
                Ok(MavMessage::HIL_ACTUATOR_CONTROLS(controls)) => u_rad = controls.controls[0],
                Ok(MavMessage::DEBUG_FLOAT_ARRAY(array)) if array.name.to_str() == Ok("cycle") => {
                    told = Some(array);
                }
                _ => {}
            });
        }
        // the ground may have hung up
        let _ = ground.write_all(&bytes);
    }
    aircraft.actuate(u_rad);
    told.expect("the loop ends with a report")
}

#[test]
fn the_command_flies_the_image_and_records_every_cycle_of_the_test() {
    let Some(emulator) = Emulator::boot() else { return };
    let Some(command) = std::env::var_os("PITCHID_COMMAND") else {
        return println!("skipped: no command; `cargo xtask chip-test` builds it");
    };
    let mut pilot = Pilot::new(emulator);
    pilot.enter_hil();
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a local port is free");
    let port = format!("tcp:{}", listener.local_addr().expect("a bound socket has an address"));
    let lengths = ["TEST_LEAD=0.4", "TEST_SECTION=4", "TEST_PAUSE=0.4", "TEST_LOOP=2"];
    let mut fly = Command::new(command);
    fly.current_dir(&folder).stdout(Stdio::null()).args(["fly", &port, "--out", "f.csv", "--seed", "9"]);
    lengths.iter().for_each(|length| {
        fly.args(["--set", length]);
    });
    let mut child = fly.spawn().expect("the command starts");
    let (mut ground, _) = listener.accept().expect("the command calls");
    ground.set_nonblocking(true).expect("a socket takes the option");
    let mut decoder =
        Decoder::new(|id| MavMessage::default_message_from_id(id).map(|_| MavMessage::extra_crc(id)));
    let mut aircraft = Simulated::new(&scenario());
    let mut expected = Vec::new();
    let status = (0..).find_map(|tick| {
        uplink(&mut ground, &mut pilot);
        let told = cycle(&mut ground, &mut pilot, &mut decoder, &mut aircraft, tick).data;
        if told[2] == 1.0 || told[2] == 2.0 {
            expected.push([told[7], told[5], told[6]].map(f32::to_bits));
        }
        child.try_wait().expect("the command can be asked for")
    });
    assert!(status.is_some_and(|status| status.success()), "{status:?}");
    let text = std::fs::read_to_string(folder.path().join("f.csv")).expect("there is a recording");
    let rows: Vec<[u32; 3]> = text
        .lines()
        .filter_map(|line| {
            let numbers: Vec<f32> = line.split(',').skip(1).take(3).flat_map(str::parse).collect();
            numbers.first_chunk().map(|row: &[f32; 3]| row.map(f32::to_bits))
        })
        .collect();
    assert_eq!(rows.len(), expected.len());
    assert!(rows == expected && rows.len() > 700, "every cycle of the test is in the recording, to the bit");
    assert!(text.contains("# finished with"));
    println!("pitchid fly: {} cycles of the emulated chip recorded", rows.len());
}
