//! The flight image on the emulated chip, against the host's run of the same core.

use std::time::Instant;

use estimator_core::Phase;
use host_sim::Scenario;
use messages::board::MavMessage;
use pitchid_tests::chip::{Emulator, Pilot, twin};

#[test]
fn it_boots_on_the_internal_clock_and_reports_fifty_cycles() {
    let Some(emulator) = Emulator::boot() else { return };
    let mut pilot = Pilot::new(emulator);
    // the emulated chip has no crystal: the fall-back is what is seen to work
    assert_eq!(pilot.greeting, "pitchid: up at 16 MHz");
    for tick in 1..=50 {
        let found = pilot.wait_for(|message| match message {
            MavMessage::DEBUG_FLOAT_ARRAY(array) => Some(array.data),
            _ => None,
        });
        assert_eq!(found[0], tick as f32);
        assert_eq!(found[7], 0.0, "without an IMU the command is neutral");
    }
}

#[test]
fn a_whole_test_is_bit_for_bit_the_hosts() {
    let Some(emulator) = Emulator::boot() else { return };
    let mut pilot = Pilot::new(emulator);
    let scenario = Scenario::campaign(4, 0.015, 11).expect("campaign 4 exists");
    let begin = Instant::now();
    let flown = twin::fly(&mut pilot, &scenario);
    let (flight_s, wall_s) = (0.02 * f64::from(flown.ticks), begin.elapsed().as_secs_f64());
    let gain: f32 = flown.taps.iter().sum();
    println!(
        "{flight_s:.1} s of flight in {wall_s:.1} s, {} recoveries, sum of taps {gain} 1/s, {:?}",
        flown.recoveries, flown.phase
    );
    println!("budget stack_bytes {}", pilot.emulator.stack_bytes());
    assert_eq!(flown.phase, Phase::Done);
    assert!(gain > 10.0, "the estimator learned: {gain}");
}
