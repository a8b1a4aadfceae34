//! The monitor on the emulated chip: its model over the link and out of the flash, and a flight in which something changes.

use std::sync::OnceLock;

use estimator_core::Config;
use estimator_core::monitor::{MonitorConfig, MonitorModel, NUMBERS};
use firmware::link::telemetry::PIECE;
use firmware::link::upload::pieces;
use firmware::watch::Watch;
use host_sim::{Background, Plant, Scenario};
use messages::board::{DEBUG_FLOAT_ARRAY_DATA, MavCmd};
use pitchid_tests::chip::{Emulator, Flash, Pilot, case, twin};
use sysid::monitor::design;
use sysid::recording::{ReadOptions, parse};

/// A monitor from an identification flight of the simulator.
fn model() -> MonitorModel {
    static MODEL: OnceLock<MonitorModel> = OnceLock::new();
    *MODEL.get_or_init(|| {
        let plain = Scenario::campaign(4, 0.015, 4).expect("campaign 4 exists");
        let flight = host_sim::fly(&Scenario { background: Background::Clean, ..plain }).expect("it flies");
        let text = flight.recording();
        let recording = parse("identification", text.as_bytes(), &ReadOptions::default()).expect("it is one");
        design(&[recording], None).expect("a monitor can be made").model
    })
}

fn upload(pilot: &mut Pilot, model: &MonitorModel) {
    let last = pieces(model).map(|piece| pilot.upload(&piece)).last();
    assert_eq!(last, Some((7, 1)));
}

#[test]
fn a_loss_of_effectiveness_in_flight_is_told_in_the_very_cycle_of_the_host_with_every_number_the_same() {
    let Some(emulator) = Emulator::boot() else { return };
    let mut pilot = Pilot::new(emulator);
    upload(&mut pilot, &model());
    let mut scenario = Scenario::campaign(4, 0.015, 21).expect("campaign 4 exists");
    scenario.plan.section_s = 20.0;
    let weak = Plant { dm_du: 0.6 * scenario.plant.dm_du, ..scenario.plant };
    scenario.change = Some((40.0, weak));
    let mut watch = Watch::default();
    watch.begin(&MonitorConfig::default(), Some(&model()));
    let mut told = Vec::new();
    let flown = twin::fly_watched(&mut pilot, &scenario, watch, |tick, texts| {
        if let Some((_, verdict)) = texts.split_once("monitor: ") {
            told.push((0.02 * f64::from(tick), verdict.to_owned()));
        }
    });
    println!("monitor, {} cycles: {told:?}", flown.ticks);
    println!("budget stack_bytes {}", pilot.emulator.stack_bytes());
    assert_eq!(told[0].1, "cannot tell: settling");
    let (at, verdict) = told.iter().find(|(_, verdict)| verdict.starts_with("changed")).expect("it is told");
    assert!(verdict.starts_with("changed: effectiveness -") && (40.0..50.0).contains(at), "{told:?}");
}

#[test]
fn a_model_of_the_flash_runs_from_the_first_armed_cycle_on_and_not_when_nothing_is_watched_for() {
    let flash = Flash::holding(|memory| memory.keep_model(&model().to_numbers()));
    let Some(mut pilot) = flash.boot() else { return };
    for watched in [u8::MAX, 0, 1] {
        let monitor = MonitorConfig { run_length_h: 100.0, watched };
        let config = Config { monitor, ..case::scenario().core() };
        twin::configure(&mut pilot, &config);
        let end = case::fly(
            &mut pilot,
            &config,
            |_, _| (),
            |tick, _, twin| {
                if tick == 0 {
                    twin.watch.begin(&config.monitor, Some(&model()));
                }
            },
        );
        assert_eq!(end.texts.contains("monitor: cannot tell: settling"), watched != 0, "{}", end.texts);
        pilot.order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    }
}

#[test]
fn a_model_comes_in_any_order_and_what_is_broken_or_comes_in_flight_is_refused_in_words() {
    let Some(emulator) = Emulator::boot() else { return };
    let mut pilot = Pilot::new(emulator);
    let sent: Vec<DEBUG_FLOAT_ARRAY_DATA> = pieces(&model()).collect();
    let mut spoilt = sent.clone();
    spoilt[(NUMBERS - 1) / PIECE].data[(NUMBERS - 1) % PIECE] += 1.0;
    assert_eq!([0, 1].map(|piece| pilot.upload(&spoilt[piece])), [(1, 0), (3, 0)]);
    pilot.send(&spoilt[2]);
    assert_eq!(pilot.text("monitor refused"), "monitor refused: not what was sent");
    assert_eq!(pilot.answer(&spoilt[2]), (0, -1));
    println!("fault case: a number of the model spoilt on its way: refused");

    assert_eq!(
        [2, 0, 0, 1, 1].map(|piece| pilot.upload(&sent[piece])),
        [(4, 0), (5, 0), (5, 0), (7, 1), (7, 1)]
    );
    pilot.enter_hil();
    pilot.arm();
    pilot.send(&sent[0]);
    assert_eq!(pilot.text("monitor refused"), "monitor refused: disarm first");
    println!("fault case: a model sent to an armed vehicle: refused");
}
