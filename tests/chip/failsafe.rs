//! The ways the image gives up, provoked from outside: neutral on the blades before the reset, the cause told after it.

use std::time::Duration;

use firmware::servo::ServoConfig;
use messages::board::MavMessage;
use pitchid_tests::chip::debugger::{Debugger, Waiting};
use pitchid_tests::chip::emulator::{FAULTS, FLIGHT};
use pitchid_tests::chip::{Emulator, Pilot};

/// What the chip says when it is up.
const UP: &str = "pitchid: up at 16 MHz";
/// Register whose write is the reset.
const RESET: u32 = 0xE000_ED0C;
const VECTORS: u32 = 0x0800_0000;
const TIM4: u32 = 0x4000_0800;
const PERIOD: u32 = 0x2C;
const COMPARE: [u32; 2] = [0x34, 0x38];

/// The image, greeted and then stopped by its debugger, with the blades away from neutral.
fn ready(variable: &str, further: &[&str]) -> Option<(Pilot, Debugger)> {
    let waiting = Waiting::open();
    let mut arguments = waiting.arguments.clone();
    arguments.extend(further.iter().map(|&argument| argument.to_owned()));
    let emulator = Emulator::boot_with(variable, &arguments)?;
    let mut debugger = waiting.attach();
    debugger.go();
    let pilot = Pilot::new(emulator);
    assert_eq!(pilot.greeting, UP);
    debugger.halt();
    for compare in COMPARE {
        debugger.write(TIM4 + compare, 17);
    }
    debugger.watch(RESET);
    Some((pilot, debugger))
}

fn text(pilot: &mut Pilot) -> String {
    pilot.wait_for(|message| match message {
        MavMessage::STATUSTEXT(text) => text.text.to_str().ok().map(str::to_owned),
        _ => None,
    })
}

fn tick(message: &MavMessage) -> Option<usize> {
    match message {
        MavMessage::DEBUG_FLOAT_ARRAY(array) => Some(array.data[0] as usize),
        _ => None,
    }
}

/// The last cycle of which a stopped chip has told.
fn last_tick(pilot: &mut Pilot) -> usize {
    let told = std::iter::from_fn(|| pilot.hear_within(Duration::from_millis(300)));
    told.filter_map(|message| tick(&message)).last().unwrap_or(0)
}

/// It runs into the reset; the blades must be neutral before, and the text after it is returned.
fn told_after_reset(pilot: &mut Pilot, mut debugger: Debugger) -> String {
    debugger.stopped();
    let config = ServoConfig::default();
    let top = debugger.read(TIM4 + PERIOD) as u16;
    assert!(top > 1000, "{top}");
    let neutral = config.widths_us(0.0).map(|width| u32::from(config.duty(width, top)));
    assert_eq!(COMPARE.map(|compare| debugger.read(TIM4 + compare)), neutral);
    debugger.unwatch(RESET);
    debugger.go();
    while text(pilot) != UP {}
    let told = text(pilot);
    // told once: a reset from outside has nothing to tell
    pilot.emulator.reset();
    while text(pilot) != UP {}
    let next = pilot.wait_for(|message| match message {
        MavMessage::STATUSTEXT(_) => Some(false),
        MavMessage::DEBUG_FLOAT_ARRAY(_) => Some(true),
        _ => None,
    });
    assert!(next, "nothing more is told");
    told
}

#[test]
fn a_hard_fault_leaves_neutral_blades_and_its_address() {
    let Some((mut pilot, mut debugger)) = ready(FLIGHT, &[]) else { return };
    // nothing may be executed there
    debugger.go_from(0x5000_0001);
    assert_eq!(told_after_reset(&mut pilot, debugger), "last reset: hard fault at 0x50000000");
    println!("fault case: hard fault: neutral, reset, told");
}

#[test]
fn a_failing_supply_leaves_neutral_blades_and_is_told() {
    let Some((mut pilot, mut debugger)) = ready(FLIGHT, &[]) else { return };
    // the emulator has no supply to fail: the handler of the voltage detector is entered by hand
    let handler = debugger.read(VECTORS + 4 * 17);
    debugger.go_from(handler);
    assert_eq!(told_after_reset(&mut pilot, debugger), "last reset: supply below 2.9 V");
    println!("fault case: brown-out: neutral, reset, told");
}

#[test]
fn cycles_in_time_feed_the_watchdog_and_three_late_ones_leave_neutral_blades_and_are_told() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let log = folder.path().join("log");
    // the emulator has no watchdog, but says what is written to where it would be
    let arguments = ["-d", "unimp", "-D", log.to_str().expect("a path of letters")];
    let Some((mut pilot, mut debugger)) = ready(FAULTS, &arguments) else { return };
    let fed = || std::fs::read_to_string(&log).unwrap_or_default().matches("value 0xaaaa").count();
    // five cycles more, each of them in time and each of them feeding
    let before = (fed(), last_tick(&mut pilot));
    debugger.go();
    let tick = pilot.wait_for(|message| tick(message).filter(|&tick| tick > before.1 + 5));
    debugger.halt();
    let tick = last_tick(&mut pilot).max(tick);
    let fed_in_time = fed();
    assert!(fed_in_time.abs_diff(before.0).abs_diff(tick - before.1) <= 1, "{before:?} {fed_in_time} {tick}");
    debugger.go();
    pilot.stick(-1000);
    assert_eq!(told_after_reset(&mut pilot, debugger), "last reset: 3 deadlines missed in a row");
    println!("fault case: three deadlines missed: neutral, reset, told");
}

#[test]
fn a_panic_in_the_control_cycle_leaves_neutral_blades_and_its_line() {
    let Some((mut pilot, mut debugger)) = ready(FAULTS, &[]) else { return };
    debugger.go();
    pilot.stick(1000);
    let told = told_after_reset(&mut pilot, debugger);
    assert!(told.starts_with("last reset: panic at line "), "{told}");
    println!("fault case: panic in the control cycle: neutral, reset, told");
}
