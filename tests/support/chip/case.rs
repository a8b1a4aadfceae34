//! One case: a short test flown in lockstep, with a fault put into it.

use estimator_core::{Command, Config, Event, Phase, Telemetry};
use host_sim::Scenario;
use messages::board::{HIL_SENSOR_DATA, MavCmd};

use super::twin::{configure, lockstep};
use super::{Emulator, Pilot, Simulated, Twin};

/// Ticks flown in one case.
pub const TICKS: u32 = 400;
/// Sections I to III of 20 s.
///
/// # Panics
/// Never: campaign 4 exists.
#[must_use]
pub fn scenario() -> Scenario {
    let mut scenario = Scenario::campaign(4, 0.015, 5).expect("campaign 4 exists");
    scenario.plan.lead_in_s = 0.4;
    scenario.plan.section_s = 20.0;
    scenario
}

/// What comes of a case.
pub struct End {
    /// Texts of the transitions, line by line.
    pub texts: String,
    /// Phase of the last tick.
    pub phase: Phase,
    /// Command of the last tick, rad.
    pub u_rad: f32,
}

/// A test of [`TICKS`] ticks from a fresh start, each sensor frame through `spoil`, `meanwhile` before each tick.
pub fn fly(
    pilot: &mut Pilot,
    config: &Config,
    mut spoil: impl FnMut(u32, &mut HIL_SENSOR_DATA),
    meanwhile: impl FnMut(u32, &mut Pilot, &mut Twin),
) -> End {
    let mut end = End { texts: String::new(), phase: Phase::Idle, u_rad: 0.0 };
    fly_until(
        pilot,
        config,
        |tick, _, sensor| spoil(tick, sensor),
        meanwhile,
        |told, texts| {
            end.texts.push_str(texts);
            end.texts.push('\n');
            (end.phase, end.u_rad) = (told.phase, told.u_rad);
            told.tick + 1 >= TICKS
        },
    );
    end
}

/// The same, until `over`; `spoil` also sees what the tick before has told.
pub fn fly_until(
    pilot: &mut Pilot,
    config: &Config,
    mut spoil: impl FnMut(u32, Option<&Telemetry>, &mut HIL_SENSOR_DATA),
    mut meanwhile: impl FnMut(u32, &mut Pilot, &mut Twin),
    mut over: impl FnMut(&Telemetry, &str) -> bool,
) {
    pilot.order(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    pilot.enter_hil();
    pilot.arm();
    pilot.begin();
    let (mut twin, mut aircraft) = (Twin::new(config), Simulated::new(&scenario()));
    twin.command = Command::Start;
    let mut last = None;
    for tick in 0.. {
        meanwhile(tick, pilot, &mut twin);
        let (mut sensor, _) = aircraft.sense(tick);
        spoil(tick, last.as_ref(), &mut sensor);
        let (telemetry, said) = lockstep(pilot, &mut twin, &sensor);
        aircraft.advance(said.u_rad.unwrap_or_default(), &telemetry);
        if let Some(Event::Aborted(fault)) = telemetry.event
            && !fault.leaves_control()
        {
            assert_eq!(telemetry.u_rad, 0.0, "neutral in the very cycle that finds {fault}");
        }
        last = Some(telemetry);
        if over(&telemetry, &said.texts) {
            return;
        }
    }
}

/// The chip in the loop with the parameters of [`scenario`].
pub fn ready() -> Option<(Pilot, Config)> {
    let mut pilot = Pilot::new(Emulator::boot()?);
    let config = scenario().core();
    pilot.enter_hil();
    configure(&mut pilot, &config);
    Some((pilot, config))
}
