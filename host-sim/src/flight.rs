//! Flies a scenario with the core: recording out, truth apart.

use estimator_core::constants::TAPS;
use estimator_core::{Phase, Section};
use serde::Serialize;

use rand::RngExt;

use crate::air::Air;
use crate::aircraft::{Aircraft, SAMPLE_PERIOD_S};
use crate::disturbance::{Colour, ColouredMoment};
use crate::effects::SettingTruth;
use crate::error::Error;
use crate::pilot::ManualReference;
use crate::plant::{Plant, State};
use crate::reading::Others;
use crate::recording::{Row, to_csv};
use crate::scenario::{Background, Scenario};
use crate::seeds::{Stream, generator};
use crate::sensors::Noise;
use crate::vehicle::SimulatedVehicle;

/// A test that was flown.
#[derive(Clone, Debug)]
pub struct Flight {
    /// What a rig would have logged.
    pub rows: Vec<Row>,
    /// The command that was really sent at each row, rad; the log may show another one.
    pub sent: Vec<f32>,
    /// The true state at each row.
    pub states: Vec<State>,
    /// How the test ended.
    pub outcome: Phase,
    /// What the core's estimator found: taps, rad/s per rad.
    pub taps: [f32; TAPS],
    /// What was really there.
    pub truth: Truth,
    comment: String,
}

/// What was really there.
#[derive(Clone, Debug, Serialize)]
pub struct Truth {
    /// Schema of this file.
    schema: &'static str,
    /// Seed of everything random.
    seed: u64,
    /// Dwell range of the excitation, s.
    dwell_s: [f32; 2],
    /// Amplitude of the excitation, rad.
    amplitude_rad: f32,
    /// True plant: kg m², N m s/rad, N m/rad, s; mount N m/rad, N m s/rad, kg m².
    pub plant: Plant,
    /// What was concealed.
    pub effects: Vec<SettingTruth>,
    /// The disturbance.
    pub background: BackgroundTruth,
    /// Noise of the IMU, standard deviations.
    noise: Noise,
    /// How the test ended.
    outcome: String,
    /// Transitions of the supervisor: time in s, text.
    pub events: Vec<(f64, String)>,
}

/// Corner of the third pole, as a multiple of the band's centre.
const CORNER: f64 = 1.5;

/// The background moment; with an air whose noise grows with the command, that noise too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BackgroundTruth {
    level: Background,
    /// Its kind; not told where it is the usual one.
    #[serde(skip_serializing_if = "Air::is_usual")]
    pub air: Air,
    /// Standard deviation, N m.
    pub sigma: f64,
    /// Centre, rad/s.
    omega_rad_s: f64,
    /// Damping ratio.
    zeta: f64,
}

/// Flies `scenario` from rest to the end of its test.
///
/// # Errors
/// A plant or a configuration that cannot be, or whose motion leaves every bound. A test that the supervisor breaks off is no
/// error: the flight says so in its outcome.
pub fn fly(scenario: &Scenario) -> Result<Flight, Error> {
    fly_in(scenario, air_of(scenario)?)
}

/// Flies `scenario` in air of the strength and colour that [`air_of`] found for another test of the vehicle, drawn afresh.
///
/// # Errors
/// As [`fly`].
pub fn fly_in(scenario: &Scenario, background: BackgroundTruth) -> Result<Flight, Error> {
    flown(scenario, background).map_err(|error| match error {
        Error::BlownUp { step, t_s, .. } => {
            Error::BlownUp { step, t_s, culprit: culprit(scenario, background) }
        }
        error => error,
    })
}

/// Flies `scenario` to its end; nothing where the supervisor breaks the test off, or the motion leaves every bound.
///
/// # Errors
/// As [`fly`], but for these.
pub(crate) fn fly_whole(scenario: &Scenario) -> Result<Option<Flight>, Error> {
    match fly(scenario) {
        Ok(flight) => Ok((flight.outcome == Phase::Done).then_some(flight)),
        Err(Error::BlownUp { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Which parameter it hangs on that the motion of `scenario` leaves every bound: the first effect without which it does not, or
/// value of the plant with the nominal one in its place.
fn culprit(scenario: &Scenario, background: BackgroundTruth) -> String {
    // the air of a test is sized by its motion, and may be wild where that is
    let stays = |other: Scenario| {
        let airs = [Ok(background), air_by(&other, flown)];
        airs.into_iter().any(|air| air.is_ok_and(|air| flown(&other, air).is_ok()))
    };
    for (i, effect) in scenario.effects.iter().enumerate() {
        let mut effects = scenario.effects.clone();
        effects.remove(i);
        if stays(Scenario { effects, ..scenario.clone() }) {
            let values: Vec<String> = effect.parameters().map(|(p, v)| format!("{} = {v}", p.name)).collect();
            return format!("without {} ({}) it does not", effect.entry().id, values.join(", "));
        }
    }
    let (own, nominal) = (scenario.plant, Plant::nominal());
    let another = |name: &str, value: f64| format!("with another {name} than {value} it does not");
    let others = [
        (another("dM_dq_N_m_s", own.dm_dq), Plant { dm_dq: nominal.dm_dq, ..own }),
        (another("dM_du_N_m", own.dm_du), Plant { dm_du: nominal.dm_du, ..own }),
        (another("delay_s", own.delay_s), Plant { delay_s: nominal.delay_s, ..own }),
        (another("inertia_kg_m2", own.inertia_kg_m2), Plant { inertia_kg_m2: nominal.inertia_kg_m2, ..own }),
        ("without the mount it does not".to_owned(), own.rigid()),
    ];
    let found = others.into_iter().find(|(_, plant)| stays(Scenario { plant: *plant, ..scenario.clone() }));
    found.map_or_else(|| "no parameter alone is the cause".to_owned(), |(words, _)| words)
}

/// As [`fly_in`], the culprit not told where the motion leaves every bound.
fn flown(scenario: &Scenario, background: BackgroundTruth) -> Result<Flight, Error> {
    let Scenario { seed, plant, ref effects, noise, .. } = *scenario;
    let cycle = scenario.core().build::<TAPS>()?;
    let mut state = cycle.initial_state();
    let log = Aircraft::new(plant, effects, None, seed);
    let mut vehicle = vehicle(scenario, background)?;
    let outcome = estimator_core::fly(&cycle, &mut state, &mut vehicle);
    if let Some(step) = vehicle.blown_up() {
        let t_s = f64::from(step) * SAMPLE_PERIOD_S;
        return Err(Error::BlownUp { step, t_s, culprit: String::new() });
    }
    let (mut rows, states, events) = vehicle.into_log();
    let sent: Vec<f32> = rows.iter().map(|row| row.u_rad).collect();
    stamp_commands(&mut rows, &sent, |t| log.logged_at(t));
    let end_s = rows.last().map_or(0.0, |row| row.t_s);
    let truth = Truth {
        schema: "pitchid.truth/1",
        seed,
        dwell_s: scenario.dwell_s,
        amplitude_rad: scenario.amplitude_rad,
        plant,
        effects: effects.iter().map(|setting| SettingTruth::new(setting, end_s)).collect(),
        background,
        noise,
        outcome: match outcome {
            Phase::Aborted { cause } => format!("aborted: {cause}"),
            _ => "finished".to_owned(),
        },
        events,
    };
    let [low, high] = scenario.dwell_s;
    let comment =
        format!("pitch test: dwell {low} to {high} s, amplitude {} rad, seed {seed}", scenario.amplitude_rad);
    Ok(Flight { rows, sent, states, outcome, taps: *state.taps(), truth, comment })
}

/// The vehicle of a scenario, whose pilot starts the test at tick 0.
///
/// # Errors
/// A plant that cannot be.
pub fn vehicle(scenario: &Scenario, background: BackgroundTruth) -> Result<SimulatedVehicle, Error> {
    scenario.plant.check()?;
    let Scenario { seed, plant, ref effects, noise, plan, .. } = *scenario;
    let length_s = f64::from(plan.closed_loop_s);
    let reference =
        ManualReference::drawn(length_s, &mut generator(seed, Stream::Reference)).times(scenario.stick);
    let aircraft = Aircraft::new(plant, effects, background.moment(seed), seed);
    let mut aircraft = aircraft.among(scenario.others, seed);
    if background.air == Air::GrowsWithCommand {
        aircraft = aircraft.growing_with_command(f64::from(scenario.amplitude_rad));
    }
    if let Some((from_s, changed)) = scenario.change {
        aircraft = aircraft.changing_at(from_s, changed);
    }
    let Others { roll, yaw, .. } = aircraft.others();
    let turns = roll || yaw;
    let vehicle = SimulatedVehicle::new(aircraft, noise, generator(seed, Stream::Sensors), reference)
        .gusty_in(scenario.gusty)
        .gusty_during(scenario.gusts.clone());
    let logged = scenario.roll_yaw_logged || turns;
    Ok(if logged { vehicle.logging_roll_yaw(generator(seed, Stream::RollYaw)) } else { vehicle })
}

/// Logs at each row the command of another time; what the log would have to know before it was sent is cut off.
fn stamp_commands(rows: &mut Vec<Row>, sent: &[f32], logged_at: impl Fn(f64) -> f64) {
    let place = |t_s: f64| (logged_at(t_s) / SAMPLE_PERIOD_S + 1e-6).max(0.0) as usize;
    let known = rows.iter().take_while(|row| place(row.t_s) < sent.len()).count();
    rows.truncate(known);
    for row in rows {
        if let Some(command) = sent.get(place(row.t_s)) {
            row.u_rad = *command;
        }
    }
}

impl BackgroundTruth {
    /// A moment of standard deviation `sigma` (N m), whatever it leaves a model.
    #[must_use]
    pub const fn of_strength(air: Air, sigma: f64, omega_rad_s: f64, zeta: f64) -> Self {
        Self { level: Background::None, air, sigma, omega_rad_s, zeta }
    }

    fn moment(&self, seed: u64) -> Option<ColouredMoment> {
        let (omega, zeta) = (self.omega_rad_s, self.zeta);
        let colour = match self.air {
            Air::ThreePoles => Colour::ThreePoles { omega, zeta, corner: CORNER * omega },
            Air::BandPassed | Air::HeavyTailed | Air::GrowsWithCommand => Colour::BandPass { omega, zeta },
        };
        let strengths = generator(seed, Stream::Strength);
        let mut generator = generator(seed, Stream::Background);
        // its first two numbers made the spectrum
        let _: [f64; 2] = [generator.random(), generator.random()];
        let moment = (self.sigma > 0.0).then(|| ColouredMoment::new(self.sigma, colour, generator))?;
        Some(if self.air == Air::HeavyTailed { moment.wandering(strengths) } else { moment })
    }
}

/// Draws the spectrum (ω in 3..7 rad/s, ζ in 0.3..0.6) and sizes the moment for the share `v` that the true
/// model is to explain: with P the power of q without the moment, n² the noise in it, and w the power that a
/// unit moment adds, v = (P − n²) / (P + σ² w). The size is that for the usual air, and of any other the same.
///
/// # Errors
/// As [`fly`].
pub fn air_of(scenario: &Scenario) -> Result<BackgroundTruth, Error> {
    air_by(scenario, fly_in)
}

fn air_by(
    scenario: &Scenario,
    fly_in: impl Fn(&Scenario, BackgroundTruth) -> Result<Flight, Error>,
) -> Result<BackgroundTruth, Error> {
    let mut generator = generator(scenario.seed, Stream::Background);
    let [first, second]: [f64; 2] = [generator.random(), generator.random()];
    let level = scenario.background;
    let (omega_rad_s, zeta) = (3.0 + 4.0 * first, 0.3 + 0.3 * second);
    let silent = BackgroundTruth { level, air: Air::default(), sigma: 0.0, omega_rad_s, zeta };
    let air = scenario.air;
    let Some(share) = level.explainable() else { return Ok(BackgroundTruth { air, ..silent }) };

    let undisturbed = fly_in(scenario, silent)?;
    let excited = undisturbed.rows.iter().filter(|row| row.section.sequence().is_some());
    let total = variance(excited.map(|row| f64::from(row.q_rad_s)));
    let caused = (total - scenario.noise.q_rad_s.powi(2)).max(0.0);

    let unit = BackgroundTruth { sigma: 1.0, ..silent };
    let mut shaken = Aircraft::new(scenario.plant, &[], unit.moment(scenario.seed), scenario.seed);
    let ticks = (100.0 / SAMPLE_PERIOD_S) as usize;
    let added = variance((0..ticks).map(|_| {
        shaken.advance(0.0);
        shaken.state().q_p
    }));
    let sigma = ((caused / share - total).max(0.0) / added).sqrt();
    Ok(BackgroundTruth { air, sigma, ..silent })
}

fn variance(values: impl Iterator<Item = f64>) -> f64 {
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        count += 1.0;
        sum += value;
        squares += value * value;
    }
    if count > 0.0 { squares / count - (sum / count).powi(2) } else { 0.0 }
}

impl Flight {
    /// The recording as CSV.
    #[must_use]
    pub fn recording(&self) -> String {
        to_csv(&self.rows, &self.comment)
    }

    /// Rows of one section.
    pub fn section(&self, section: Section) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.section == section)
    }

    /// The truth as JSON.
    ///
    /// # Errors
    /// None that a caller could cause.
    pub fn truth_json(&self) -> Result<String, Error> {
        Ok(serde_json::to_string_pretty(&self.truth)? + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Setting;

    /// What is said of the nominal campaign with another plant and an effect.
    fn said(plant: Plant, effect: Option<(&str, &[(&str, f64)])>) -> String {
        let mut scenario = Scenario { plant, ..Scenario::campaign(4, 0.015, 1).unwrap() };
        scenario.conceal(effect.into_iter().map(|(id, values)| Setting::new(id, values).unwrap()).collect());
        fly(&scenario).unwrap_err().to_string()
    }

    #[test]
    fn a_simulation_that_blows_up_names_the_step_and_the_value() {
        let nominal = Plant::nominal();
        let told = said(nominal, Some(("quadratic_drag", &[("D", 1e9)])));
        assert!(told.starts_with("the simulation blew up at step "), "{told}");
        assert!(told.ends_with("without quadratic_drag (D = 1000000000) it does not"), "{told}");
        let mode: &[(&str, f64)] = &[("omega", 20.0), ("zeta", 0.01), ("gain", 1e6)];
        let told = said(nominal, Some(("structural_mode", mode)));
        assert!(told.contains("without structural_mode (gain = 1000000, "), "{told}");
        let told = said(Plant { dm_dq: 160.0, ..nominal }, None);
        assert!(told.contains("step 4 (0.08 s)") && told.contains("another dM_dq_N_m_s than 160"), "{told}");
        let told = said(Plant { dm_du: 1e9, ..nominal }, None);
        assert!(told.ends_with("with another dM_du_N_m than 1000000000 it does not"), "{told}");
    }
}
