//! The host's run of the same core, tick by tick beside the chip's, and the aircraft that both fly.

use estimator_core::constants::MAX_TAPS;
use estimator_core::monitor::Verdict;
use estimator_core::{Command, Config, Cycle, CycleState, Event, Input, Phase, Sample, Telemetry, Vehicle};
use firmware::hil::{HilClock, HilTick};
use firmware::link::ground::FULL_STICK_RAD;
use firmware::link::telemetry::{cycle_array, monitor_value, taps_arrays};
use firmware::parameters::PARAMETERS;
use firmware::pitch_filter::PitchFilter;
use firmware::watch::Watch;
use host_sim::Scenario;
use host_sim::aircraft::Aircraft;
use host_sim::pilot::ManualReference;
use host_sim::seeds::{Stream, generator};
use host_sim::vehicle::SimulatedVehicle;
use messages::board::{
    DEBUG_FLOAT_ARRAY_DATA, HIL_SENSOR_DATA, HilSensorUpdatedFlags, MavMessage, NAMED_VALUE_FLOAT_DATA,
};

use super::Pilot;

/// What the image says when its flash does not keep the settings.
pub const NOT_KEPT: &str = "settings not kept: flash full or failing, restart";

const GRAVITY: f64 = 9.806_65;

/// The aircraft behind `HIL_SENSOR` and `HIL_ACTUATOR_CONTROLS`.
pub struct Simulated {
    vehicle: SimulatedVehicle,
}

impl Simulated {
    /// The scenario's aircraft at rest, without background.
    pub fn new(scenario: &Scenario) -> Self {
        let Scenario { plant, ref effects, seed, noise, plan, change, .. } = *scenario;
        let length_s = f64::from(plan.closed_loop_s);
        let reference = ManualReference::drawn(length_s, &mut generator(seed, Stream::Reference));
        let mut aircraft = Aircraft::new(plant, effects, None, seed);
        if let Some((from_s, changed)) = change {
            aircraft = aircraft.changing_at(from_s, changed);
        }
        Self { vehicle: SimulatedVehicle::new(aircraft, noise, generator(seed, Stream::Sensors), reference) }
    }

    /// What the sensors read in this tick, and the pilot's stick.
    pub fn sense(&mut self, tick: u32) -> (HIL_SENSOR_DATA, i16) {
        let input = self.vehicle.sense(tick);
        let sample = input.sample.expect("a simulated sensor always answers");
        let theta = f64::from(sample.theta_rad);
        let sensor = HIL_SENSOR_DATA {
            time_usec: sample.time_us,
            xacc: (GRAVITY * theta.sin()) as f32,
            zacc: (-GRAVITY * theta.cos()) as f32,
            ygyro: sample.q_rad_s,
            fields_updated: HilSensorUpdatedFlags::from_bits_retain(0x3f),
            ..HIL_SENSOR_DATA::default()
        };
        (sensor, (input.theta_ref_rad / FULL_STICK_RAD * 1000.0) as i16)
    }

    /// Moves on by one tick under `u_rad`, outside a test.
    pub fn actuate(&mut self, u_rad: f32) {
        self.vehicle.actuate(u_rad);
    }

    /// Moves on by one tick under `u_rad`.
    pub fn advance(&mut self, u_rad: f32, telemetry: &Telemetry) {
        self.vehicle.actuate(u_rad);
        self.vehicle.emit(telemetry);
    }
}

/// The core on the host, fed as the chip is.
pub struct Twin {
    cycle: Cycle<MAX_TAPS>,
    length: usize,
    state: CycleState<MAX_TAPS>,
    clock: HilClock,
    filter: PitchFilter,
    /// The monitor of the armed vehicle; off unless it is begun.
    pub watch: Watch,
    verdict: Option<Verdict>,
    /// The operator's command for the coming cycle.
    pub command: Command,
    /// Reference of section IV, rad.
    pub reference_rad: f32,
}

impl Twin {
    /// The core before a test.
    pub fn new(config: &Config) -> Self {
        let cycle = config.build().expect("the configuration is legal");
        Self {
            state: cycle.initial_state(),
            cycle,
            length: usize::from(config.lms.taps),
            clock: HilClock::default(),
            filter: PitchFilter::default(),
            watch: Watch::default(),
            verdict: None,
            command: Command::None,
            reference_rad: 0.0,
        }
    }

    /// The estimate, rad/s per rad.
    pub fn taps(&self) -> &[f32] {
        &self.state.taps()[..self.length]
    }

    /// One cycle.
    pub fn step(&mut self, sensor: &HIL_SENSOR_DATA) -> Telemetry {
        let HilTick { tick, now_us, sampled_us, motion } = self.clock.step(sensor);
        let sample = motion.map(|motion| Sample {
            time_us: sampled_us,
            q_rad_s: motion.q_rad_s,
            theta_rad: self.filter.step(&motion),
        });
        let command = std::mem::take(&mut self.command);
        let input = Input { tick, now_us, sample, theta_ref_rad: self.reference_rad, command };
        self.cycle.step(&mut self.state, &input)
    }
}

/// What a cycle of the twin is to make the chip say.
struct Expected {
    texts: String,
    value: Option<NAMED_VALUE_FLOAT_DATA>,
}

impl Expected {
    fn of(twin: &mut Twin, telemetry: &Telemetry) -> Self {
        let mut texts = telemetry.event.map_or(String::new(), |event| event.to_string());
        let report = twin.watch.step(telemetry);
        if let Some(verdict) = report.map(|report| report.verdict)
            && !twin.verdict.is_some_and(|last| last.is_like(&verdict))
        {
            twin.verdict = Some(verdict);
            texts += &format!("monitor: {verdict}");
        }
        Self { texts, value: report.map(|report| monitor_value(&report, telemetry)) }
    }
}

/// What the chip said in one cycle.
#[derive(Default)]
pub struct Said {
    /// Command of `HIL_ACTUATOR_CONTROLS`, rad.
    pub u_rad: Option<f32>,
    /// All of `STATUSTEXT`, one after the other.
    pub texts: String,
    /// What the monitor said of itself.
    pub value: Option<NAMED_VALUE_FLOAT_DATA>,
    /// The taps, where the cycle told them.
    pub taps: Vec<DEBUG_FLOAT_ARRAY_DATA>,
}

/// One cycle on the chip and on the twin, compared bit for bit; the twin's report and what else the chip said.
pub fn lockstep(pilot: &mut Pilot, twin: &mut Twin, sensor: &HIL_SENSOR_DATA) -> (Telemetry, Said) {
    pilot.send(sensor);
    let telemetry = twin.step(sensor);
    let expected = Expected::of(twin, &telemetry);
    let mut said = Said::default();
    let found = loop {
        match pilot.hear() {
            MavMessage::HIL_ACTUATOR_CONTROLS(controls) => said.u_rad = Some(controls.controls[0]),
            // the emulated flash takes nothing, and the image says so
            MavMessage::STATUSTEXT(text) if text.text.to_str() == Ok(NOT_KEPT) => {}
            MavMessage::STATUSTEXT(text) => said.texts.push_str(text.text.to_str().expect("text is UTF-8")),
            MavMessage::NAMED_VALUE_FLOAT(value) => said.value = Some(value),
            MavMessage::DEBUG_FLOAT_ARRAY(array) if array.name.to_str() == Ok("taps") => {
                said.taps.push(array);
            }
            MavMessage::DEBUG_FLOAT_ARRAY(array) => break array,
            _ => {}
        }
    };
    same(&found, &cycle_array(&telemetry), &format!("tick {}", telemetry.tick));
    assert_eq!(said.u_rad.map(f32::to_bits), Some(telemetry.u_rad.to_bits()), "tick {}", telemetry.tick);
    assert_eq!(said.texts, expected.texts, "tick {}", telemetry.tick);
    let bits = |value: &NAMED_VALUE_FLOAT_DATA| (value.name, value.time_boot_ms, value.value.to_bits());
    assert_eq!(said.value.as_ref().map(bits), expected.value.as_ref().map(bits), "tick {}", telemetry.tick);
    if matches!(telemetry.event, Some(Event::Finished { .. } | Event::Aborted(_))) {
        assert!(!said.taps.is_empty(), "the taps come at the end of a test");
    }
    if !said.taps.is_empty() {
        let expected: Vec<_> = taps_arrays(twin.taps(), telemetry.now_us).collect();
        assert_eq!(said.taps.len(), expected.len(), "tick {}", telemetry.tick);
        for (found, expected) in said.taps.iter().zip(&expected) {
            same(found, expected, &format!("taps in tick {}", telemetry.tick));
        }
    }
    (telemetry, said)
}

fn same(chip: &DEBUG_FLOAT_ARRAY_DATA, host: &DEBUG_FLOAT_ARRAY_DATA, what: &str) {
    let bits = |array: &DEBUG_FLOAT_ARRAY_DATA| array.data.map(f32::to_bits);
    assert_eq!((chip.time_usec, chip.array_id), (host.time_usec, host.array_id), "{what}");
    assert_eq!(bits(chip), bits(host), "{what}: chip {:?}, host {:?}", chip.data, host.data);
}

/// Gives the chip every parameter of `config`.
pub fn configure(pilot: &mut Pilot, config: &Config) {
    // limits cross while they are set one by one, so the order is tried twice
    for _ in 0..2 {
        for parameter in PARAMETERS {
            pilot.set(parameter.name, parameter.value(config));
        }
    }
    for parameter in PARAMETERS {
        let wanted = parameter.value(config);
        assert_eq!(pilot.set(parameter.name, wanted).to_bits(), wanted.to_bits(), "{}", parameter.name);
    }
}

/// A test flown on the chip.
pub struct Flown {
    /// Cycles that it took.
    pub ticks: u32,
    /// How it ended.
    pub phase: Phase,
    /// The estimate, rad/s per rad.
    pub taps: Vec<f32>,
    /// Recoveries that it took.
    pub recoveries: u32,
}

/// Flies a whole test: HIL, parameters, arming, start, lockstep to the end.
pub fn fly(pilot: &mut Pilot, scenario: &Scenario) -> Flown {
    fly_watched(pilot, scenario, Watch::default(), |_, _| ())
}

/// The same with a monitor; every cycle's tick and texts go to `said`.
pub fn fly_watched(
    pilot: &mut Pilot,
    scenario: &Scenario,
    watch: Watch,
    mut said_in: impl FnMut(u32, &str),
) -> Flown {
    let config = scenario.core();
    pilot.enter_hil();
    configure(pilot, &config);
    pilot.arm();
    pilot.begin();
    let (mut twin, mut aircraft) = (Twin::new(&config), Simulated::new(scenario));
    (twin.command, twin.watch) = (Command::Start, watch);
    let mut stick = 0;
    for tick in 0.. {
        let (sensor, wanted) = aircraft.sense(tick);
        if wanted != stick {
            stick = wanted;
            pilot.stick(stick);
            twin.reference_rad = FULL_STICK_RAD * (f32::from(stick) / 1000.0);
        }
        let (telemetry, said) = lockstep(pilot, &mut twin, &sensor);
        said_in(tick, &said.texts);
        aircraft.advance(said.u_rad.unwrap_or_default(), &telemetry);
        if telemetry.phase.ended() {
            let Telemetry { phase, recoveries, .. } = telemetry;
            return Flown { ticks: tick + 1, phase, taps: twin.taps().to_vec(), recoveries };
        }
    }
    unreachable!("a test ends")
}
