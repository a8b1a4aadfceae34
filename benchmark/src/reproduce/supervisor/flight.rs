//! One test that goes wrong, flown by the core and watched from outside.

use super::excursion::{Bounded, Excursion, Tick};
use crate::Error;
use estimator_core::constants::{SAMPLE_PERIOD_S, TAPS};
use estimator_core::{AttitudeConfig, Config, CycleState, Fault, Phase, Section, Telemetry, Vehicle};
use host_sim::fault::Failing;
use host_sim::hazard::Hazard;
use serde::Serialize;

/// Rounding and the trapezoids of an excursion's sums: relative, and rad.
const TOLERANCE: [f64; 2] = [1e-2, 1e-3];
/// Rounding of the controller's command, rad.
const SAME_COMMAND: f32 = 1e-6;

/// What became of one test.
#[derive(Clone, Debug, Serialize)]
pub struct Watched {
    /// Its number.
    pub number: u64,
    /// What was concealed.
    pub effects: Vec<&'static str>,
    /// What broke.
    pub failing: Option<Failing>,
    /// How it ended.
    pub ended: String,
    /// Recoveries, and the longest, s.
    pub recoveries: u32,
    /// The longest recovery, s.
    pub longest_s: f64,
    /// Excursions beyond the limit.
    pub excursions: usize,
    /// Those that nothing bounds.
    pub unbounded: usize,
    /// The one that went furthest.
    pub furthest: Option<Excursion>,
    /// The one that came nearest to its bound, and the share of it.
    pub nearest: Option<(Excursion, f64)>,
    /// Promises that were broken.
    pub broken: Vec<String>,
}

/// The controller's law as it is documented, and its trim.
struct Law {
    config: AttitudeConfig,
    trim: f32,
    last_u: f32,
}

impl Law {
    /// The command that the law gives for what the core saw and said.
    fn command(&mut self, told: &Telemetry) -> f32 {
        let excited = told.section.sequence().is_some() && told.phase == Phase::Exciting;
        let neutral = match told.phase {
            Phase::Aborted { cause } => !cause.leaves_control() || told.sample.is_none(),
            phase => !phase.runs() && told.sample.is_none(),
        };
        let AttitudeConfig { angle_gain, integral_gain_per_s, rate_gain_s, output_limit_rad: most, .. } =
            self.config;
        let u = match told.sample {
            _ if neutral => 0.0,
            _ if excited => told.excitation_rad,
            None => self.last_u,
            Some(sample) => {
                let error = told.theta_ref_rad - sample.theta_rad;
                let wanted = angle_gain * error - rate_gain_s * sample.q_rad_s + self.trim;
                if wanted.abs() <= most || wanted * error <= 0.0 {
                    self.trim += integral_gain_per_s * SAMPLE_PERIOD_S * error;
                    self.trim = self.trim.clamp(-most, most);
                }
                wanted.clamp(-most, most)
            }
        };
        self.last_u = u;
        u
    }
}

/// What is watched from tick to tick.
struct Watch {
    config: Config,
    law: Law,
    broken: Vec<String>,
    recovering: u32,
    longest: u32,
}

impl Watch {
    fn breaks(&mut self, told: &Telemetry, promise: &str) {
        // the first few tell enough
        if self.broken.len() < 5 {
            self.broken
                .push(format!("{:.2} s: {promise}", f64::from(told.tick) * f64::from(SAMPLE_PERIOD_S)));
        }
    }

    fn tick(&mut self, told: &Telemetry, before: &[f32; TAPS], state: &CycleState<TAPS>) {
        let numbers = [told.u_rad, told.excitation_rad, told.theta_ref_rad, told.prediction_error_rad_s];
        if !numbers.iter().chain(state.taps()).all(|x| x.is_finite()) {
            self.breaks(told, "a number that is not finite");
        }
        let learns = told.phase == Phase::Exciting && told.section.sequence().is_some() && !told.supervised;
        if !learns && state.taps() != before {
            self.breaks(told, "the taps moved where the supervisor or the controller led");
        }
        let limits = self.config.supervisor;
        let beyond = told.sample.is_some_and(|sample| {
            sample.theta_rad.abs() > limits.trip_theta_rad || sample.q_rad_s.abs() > limits.trip_q_rad_s
        });
        if beyond && (told.excitation_rad != 0.0 || (told.section == Section::IV && !told.supervised)) {
            self.breaks(told, "the test went on beyond a limit");
        }
        let expected = self.law.command(told);
        if (told.u_rad - expected).abs() > SAME_COMMAND {
            self.breaks(told, "the command is not that of the controller's law");
        }
        self.recovering =
            if matches!(told.phase, Phase::Recovering { .. }) { self.recovering + 1 } else { 0 };
        self.longest = self.longest.max(self.recovering);
        if self.recovering > (limits.max_recovery_s / SAMPLE_PERIOD_S).round() as u32 + 1 {
            self.breaks(told, "a recovery neither ended nor was broken off");
        }
    }
}

/// Ticks after which every test is over: its own, and its recoveries with one tick each.
fn most_ticks(config: &Config) -> u32 {
    let plan = config.plan;
    let flown = plan.lead_in_s + 3.0 * (plan.section_s + plan.pause_s) + plan.closed_loop_s;
    let [test, recovery] =
        [flown, config.supervisor.max_recovery_s].map(|s| (s / SAMPLE_PERIOD_S).round() as u32);
    test + u32::from(config.supervisor.max_recoveries) * (recovery + 1) + 2
}

/// The cause, for counting.
const fn cause_without_numbers(cause: Fault) -> &'static str {
    match cause {
        Fault::TooManyRecoveries { .. } => "broken off: too many recoveries",
        Fault::RecoveryTooLong { .. } => "broken off: not level within the time of a recovery",
        Fault::NotFinite { .. } => "broken off: a reading is not a number",
        Fault::OutOfRange { .. } => "broken off: a reading beyond what a sensor reads",
        Fault::Frozen { .. } => "broken off: a reading is frozen",
        Fault::Missing { .. } => "broken off: no samples",
        Fault::Late { .. } => "broken off: samples late",
        Fault::Operator => "broken off: by the operator",
    }
}

/// Flies test `number` of `seed`, and watches every tick.
///
/// # Errors
/// None that a caller could cause.
pub fn watch(seed: u64, number: u64) -> Result<Watched, Error> {
    let hazard = Hazard::drawn(seed, number)?;
    let config = hazard.scenario.core();
    let unflyable = |error: estimator_core::ConfigError| Error::from(host_sim::Error::from(error));
    let cycle = config.build::<TAPS>().map_err(unflyable)?;
    let mut state = cycle.initial_state();
    let mut vehicle = hazard.vehicle()?;
    let law = Law { config: config.attitude, trim: 0.0, last_u: 0.0 };
    let mut watch = Watch { config, law, broken: Vec::new(), recovering: 0, longest: 0 };
    let (mut ticks, mut last): (Vec<Tick>, Option<Telemetry>) = (Vec::new(), None);
    for tick in 0..most_ticks(&config) {
        let before = *state.taps();
        let input = vehicle.sense(tick);
        let told = cycle.step(&mut state, &input);
        vehicle.actuate(told.u_rad);
        vehicle.emit(&told);
        let seen = told.sample.map(|sample| [sample.theta_rad, sample.q_rad_s].map(f64::from));
        ticks.push(Tick { truth: [0.0; 2], seen, u: f64::from(told.u_rad), trim: f64::from(watch.law.trim) });
        watch.tick(&told, &before, &state);
        last = Some(told);
        if told.phase.ended() {
            break;
        }
    }
    let (_, states, _) = vehicle.into_vehicle().into_log();
    for (tick, state) in ticks.iter_mut().zip(&states) {
        tick.truth = [state.theta, state.q];
    }
    let ended = match last.map(|told| told.phase) {
        Some(Phase::Done) => "done".to_owned(),
        Some(Phase::Aborted { cause }) => cause_without_numbers(cause).to_owned(),
        _ => {
            watch.broken.push("the test did not end".into());
            "not at all".to_owned()
        }
    };
    let plant = hazard.scenario.plant;
    let bounded = Bounded {
        limit_rad: f64::from(config.supervisor.trip_theta_rad),
        authority: plant.dm_du / plant.inertia_kg_m2,
        delay_s: plant.delay_s,
        attitude: config.attitude,
    };
    let excursions = bounded.excursions(&ticks);
    let ratio = |excursion: &Excursion| {
        let [relative, absolute] = TOLERANCE;
        excursion.bound_rad.map(|bound| excursion.excess_rad / (bound * (1.0 + relative) + absolute))
    };
    for (excursion, ratio) in excursions.iter().filter_map(|one| Some((one, ratio(one)?))) {
        if ratio > 1.0 {
            let Excursion { t_s, excess_rad, .. } = excursion;
            watch
                .broken
                .push(format!("{t_s:.2} s: {excess_rad:.3} rad beyond the limit, {ratio:.2} of the bound"));
        }
    }
    let nearest = excursions.iter().filter_map(|one| Some((*one, ratio(one)?)));
    Ok(Watched {
        number,
        effects: hazard.scenario.effects.iter().map(|effect| effect.entry().id).collect(),
        failing: hazard.failing,
        ended,
        recoveries: last.map_or(0, |told| told.recoveries),
        longest_s: f64::from(watch.longest) * f64::from(SAMPLE_PERIOD_S),
        excursions: excursions.len(),
        unbounded: excursions.iter().filter(|one| one.bound_rad.is_none()).count(),
        furthest: excursions.iter().copied().max_by(|a, b| a.excess_rad.total_cmp(&b.excess_rad)),
        nearest: nearest.max_by(|a, b| a.1.total_cmp(&b.1)),
        broken: watch.broken,
    })
}
