//! Attitude-limit supervisor.
//!
//! ```text
//!            start                     plan complete
//!   Idle ─────────────> Exciting ─────────────────────> Done
//!                        │    ^
//!     |θ| or |q| above   │    │  |θ| and |q| below release
//!     its limit          v    │
//!                      Recovering{since, cause}
//!
//!   Exciting, Recovering ── fault, operator ──> Aborted{cause}
//! ```
//!
//! Theory of operation. In quasi-open loop nothing holds the vehicle but this machine: the pitch angle
//! integrates what the excitation leaves over, so it drifts into the limit sooner or later. Then the attitude
//! controller takes over (Recovering) in the very tick that saw the crossing, and the test stands still.
//! Release needs both angle and rate well inside, for a vehicle that passes level at speed would be back at
//! the limit at once; the gap between trip and release is the hysteresis. Then the excitation goes on at the
//! place where it was left.
//!
//! A recovery that lasts too long, one recovery too many, a fault of the samples ([`crate::health`]), or the
//! operator ends the test for good. Done and Aborted are left by nothing but a new state. Faults matter while
//! a test runs; before and after it a sample that is not usable merely gives neutral servos.
//!
//! [`Supervisor::step`] decides, the cycle acts on the decision:
//!
//! | phase | decision |
//! | --- | --- |
//! | Idle, Done | `Level`, or `Neutral` without a usable sample |
//! | Exciting | `Proceed` |
//! | Recovering | `Level` |
//! | Aborted | `Level` if the cause leaves controller and sample to be trusted, else `Neutral` |
//!
//! Termination: a test of n ticks ends after at most n + max_recoveries · (max_recovery + 1) + 1 further
//! ticks, whatever the samples are.
//!
//! Default limits: ±0.40 rad is inside the test-bed's travel of about ±0.5 rad by one overshoot of the
//! controller from 0.8 rad/s; 2 rad/s is twice what the strongest excitation of the paper (0.019 rad, 0.8 s)
//! can build up.

use crate::cause::{Event, Fault, Trip};
use crate::config_error::{ConfigError, within};
use crate::constants::ticks;
use crate::health::{Health, HealthState};
use crate::input::{Command, Input, Sample};

/// Limits in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupervisorConfig {
    /// |θ| beyond which the controller takes over, rad, 0.01 to 1.5.
    pub trip_theta_rad: f32,
    /// |q| beyond which the controller takes over, rad/s, 0.01 to 30.
    pub trip_q_rad_s: f32,
    /// |θ| below which the test goes on, rad, below 0.9 of the trip.
    pub release_theta_rad: f32,
    /// |q| below which the test goes on, rad/s, below 0.9 of the trip.
    pub release_q_rad_s: f32,
    /// Longest recovery, s, 0.1 to 60.
    pub max_recovery_s: f32,
    /// Most recoveries in one test, 0 to 10000.
    pub max_recoveries: u16,
    /// Lost samples in a row that are a fault, 1 to 50.
    pub lost_ticks: u16,
    /// Age beyond which a sample counts as lost, s, 0 to 1.
    pub max_age_s: f32,
    /// Identical samples in a row that are a fault, 2 to 1000; 0 switches the check off.
    pub frozen_samples: u16,
}

impl Default for SupervisorConfig {
    fn default() -> Self {
        Self {
            trip_theta_rad: 0.40,
            trip_q_rad_s: 2.0,
            release_theta_rad: 0.15,
            release_q_rad_s: 0.25,
            max_recovery_s: 5.0,
            max_recoveries: 200,
            lost_ticks: 3,
            max_age_s: 0.02,
            frozen_samples: 10,
        }
    }
}

impl SupervisorConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field outside its legal range.
    pub fn build(&self) -> Result<Supervisor, ConfigError> {
        within("supervisor.trip_theta_rad", "rad", self.trip_theta_rad, [0.01, 1.5])?;
        within("supervisor.trip_q_rad_s", "rad/s", self.trip_q_rad_s, [0.01, 30.0])?;
        let [theta_high, q_high] = [0.9 * self.trip_theta_rad, 0.9 * self.trip_q_rad_s];
        within("supervisor.release_theta_rad", "rad", self.release_theta_rad, [0.001, theta_high])?;
        within("supervisor.release_q_rad_s", "rad/s", self.release_q_rad_s, [0.001, q_high])?;
        within("supervisor.max_recovery_s", "s", self.max_recovery_s, [0.1, 60.0])?;
        within("supervisor.max_recoveries", "", f32::from(self.max_recoveries), [0.0, 10_000.0])?;
        within("supervisor.lost_ticks", "", f32::from(self.lost_ticks), [1.0, 50.0])?;
        within("supervisor.max_age_s", "s", self.max_age_s, [0.0, 1.0])?;
        if self.frozen_samples != 0 {
            within("supervisor.frozen_samples", "", f32::from(self.frozen_samples), [2.0, 1000.0])?;
        }
        Ok(Supervisor {
            limits: *self,
            max_recovery: ticks(self.max_recovery_s),
            health: Health {
                lost_ticks: u32::from(self.lost_ticks),
                max_age_us: libm::roundf(self.max_age_s * 1e6) as u64,
                frozen_samples: u32::from(self.frozen_samples),
            },
        })
    }
}

/// Supervisor, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supervisor {
    limits: SupervisorConfig,
    max_recovery: u32,
    health: Health,
}

/// Where a test stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Phase {
    /// No test yet.
    #[default]
    Idle,
    /// The test runs.
    Exciting,
    /// The controller brings the vehicle back; the test stands still.
    Recovering {
        /// Tick that saw the crossing.
        since: u32,
        /// The limit crossed.
        cause: Trip,
    },
    /// The test is complete.
    Done,
    /// The test was broken off.
    Aborted {
        /// Why.
        cause: Fault,
    },
}

impl Phase {
    /// True while a test runs, recoveries included.
    #[must_use]
    pub const fn runs(&self) -> bool {
        matches!(self, Self::Exciting | Self::Recovering { .. })
    }

    /// True when a test has ended, well or badly.
    #[must_use]
    pub const fn ended(&self) -> bool {
        matches!(self, Self::Done | Self::Aborted { .. })
    }
}

/// Phase, counters and what the sample checks remember.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupervisorState {
    phase: Phase,
    recoveries: u32,
    health: HealthState,
}

impl SupervisorState {
    /// Where the test stands.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Recoveries so far.
    #[must_use]
    pub const fn recoveries(&self) -> u32 {
        self.recoveries
    }
}

/// Who moves the servo in this tick.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Decision {
    /// Nobody: servos to neutral.
    Neutral,
    /// The attitude controller, to level.
    Level,
    /// The test.
    Proceed,
}

/// Decision of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ruling {
    /// Who moves the servo.
    pub decision: Decision,
    /// The sample, if it is fit to act on.
    pub sample: Option<Sample>,
    /// The transition of this tick, if there was one.
    pub event: Option<Event>,
}

impl Supervisor {
    /// Looks at one tick. `complete`: nothing of the test is left.
    pub fn step(&self, state: &mut SupervisorState, input: &Input, complete: bool) -> Ruling {
        let checked = self.health.check(&mut state.health, input.tick, input.now_us, input.sample);
        let sample = checked.unwrap_or(None);
        let event = match state.phase {
            Phase::Idle => (input.command == Command::Start).then_some(Event::Started),
            Phase::Done | Phase::Aborted { .. } => None,
            Phase::Exciting | Phase::Recovering { .. } if input.command == Command::Abort => {
                Some(Event::Aborted(Fault::Operator))
            }
            Phase::Exciting | Phase::Recovering { .. } => match checked {
                Err(fault) => Some(Event::Aborted(fault)),
                Ok(sample) => self.guard(state, input.tick, sample, complete),
            },
        };
        if let Some(event) = event {
            enter(state, event, input.tick);
        }
        Ruling { decision: decide(&state.phase, sample.is_some()), sample, event }
    }

    /// The limits, for a test that runs on samples without fault.
    fn guard(
        &self,
        state: &SupervisorState,
        tick: u32,
        sample: Option<Sample>,
        complete: bool,
    ) -> Option<Event> {
        if let Phase::Recovering { since, cause: trip } = state.phase {
            let after_ticks = tick.wrapping_sub(since);
            if sample.is_some_and(|s| self.released(&s)) {
                return Some(Event::Resumed { after_ticks });
            }
            let ticks = after_ticks;
            return (ticks > self.max_recovery)
                .then_some(Event::Aborted(Fault::RecoveryTooLong { ticks, trip }));
        }
        if let Some(trip) = sample.and_then(|s| self.tripped(&s)) {
            let allowed = u32::from(self.limits.max_recoveries);
            let one_too_many = state.recoveries >= allowed;
            let fault = Event::Aborted(Fault::TooManyRecoveries { allowed, trip });
            return Some(if one_too_many { fault } else { Event::Tripped(trip) });
        }
        complete.then_some(Event::Finished { recoveries: state.recoveries })
    }

    fn tripped(&self, sample: &Sample) -> Option<Trip> {
        let SupervisorConfig { trip_theta_rad, trip_q_rad_s, .. } = self.limits;
        if sample.theta_rad.abs() > trip_theta_rad {
            Some(Trip::Angle { found: sample.theta_rad, limit: trip_theta_rad })
        } else if sample.q_rad_s.abs() > trip_q_rad_s {
            Some(Trip::Rate { found: sample.q_rad_s, limit: trip_q_rad_s })
        } else {
            None
        }
    }

    fn released(&self, sample: &Sample) -> bool {
        sample.theta_rad.abs() < self.limits.release_theta_rad
            && sample.q_rad_s.abs() < self.limits.release_q_rad_s
    }
}

fn enter(state: &mut SupervisorState, event: Event, tick: u32) {
    state.phase = match event {
        Event::Started | Event::Resumed { .. } => Phase::Exciting,
        Event::Tripped(cause) => Phase::Recovering { since: tick, cause },
        Event::Finished { .. } => Phase::Done,
        Event::Aborted(cause) => Phase::Aborted { cause },
    };
    if matches!(event, Event::Tripped(_)) {
        state.recoveries = state.recoveries.saturating_add(1);
    }
}

const fn decide(phase: &Phase, usable: bool) -> Decision {
    match phase {
        Phase::Exciting => Decision::Proceed,
        // a bridged loss: the controller holds its last command
        Phase::Recovering { .. } => Decision::Level,
        Phase::Idle | Phase::Done if usable => Decision::Level,
        Phase::Aborted { cause } if usable && cause.leaves_control() => Decision::Level,
        Phase::Idle | Phase::Done | Phase::Aborted { .. } => Decision::Neutral,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Bench {
        supervisor: Supervisor,
        state: SupervisorState,
        tick: u32,
    }

    impl Bench {
        fn started() -> Self {
            let config = SupervisorConfig { max_recoveries: 2, ..SupervisorConfig::default() };
            let mut bench =
                Self { supervisor: config.build().unwrap(), state: SupervisorState::default(), tick: 0 };
            bench.step(0.0, 0.0, Command::Start);
            bench
        }

        fn step(&mut self, theta: f32, q: f32, command: Command) -> Ruling {
            // a little noise, or the sensor counts as frozen
            let noise = 1e-4 * (self.tick % 7) as f32;
            let now_us = u64::from(self.tick) * 20_000;
            let sample = Some(Sample { time_us: now_us, q_rad_s: q + noise, theta_rad: theta + noise });
            let input = Input { tick: self.tick, now_us, sample, theta_ref_rad: 0.0, command };
            self.tick += 1;
            self.supervisor.step(&mut self.state, &input, false)
        }
    }

    #[test]
    fn trips_in_the_tick_of_the_crossing_and_releases_with_hysteresis() {
        let mut bench = Bench::started();
        assert_eq!(bench.step(0.39, 0.5, Command::None).decision, Decision::Proceed);
        let ruling = bench.step(0.41, 0.5, Command::None);
        assert_eq!(ruling.decision, Decision::Level);
        assert!(matches!(ruling.event, Some(Event::Tripped(Trip::Angle { limit: 0.4, .. }))));
        for (theta, q) in [(0.3, 0.0), (0.16, 0.0), (0.1, -0.5), (0.0, 0.3)] {
            assert_eq!(bench.step(theta, q, Command::None).decision, Decision::Level);
        }
        let ruling = bench.step(0.1, -0.1, Command::None);
        assert_eq!(ruling.event, Some(Event::Resumed { after_ticks: 5 }));
        assert_eq!(ruling.decision, Decision::Proceed);
    }

    #[test]
    fn a_limit_itself_is_neither_beyond_nor_within() {
        let config = SupervisorConfig::default();
        let supervisor = config.build().unwrap();
        let at = |theta_rad, q_rad_s| Sample { time_us: 0, q_rad_s, theta_rad };
        let (theta, q) = (config.trip_theta_rad, config.trip_q_rad_s);
        assert!(supervisor.tripped(&at(theta, -q)).is_none() && supervisor.tripped(&at(-theta, q)).is_none());
        assert!(supervisor.tripped(&at(-theta.next_up(), 0.0)).is_some());
        assert!(supervisor.tripped(&at(0.0, -q.next_up())).is_some());
        let (theta, q) = (config.release_theta_rad, config.release_q_rad_s);
        assert!(!supervisor.released(&at(theta, 0.0)) && !supervisor.released(&at(0.0, -q)));
        assert!(supervisor.released(&at(theta.next_down(), -q.next_down())));
    }

    #[test]
    fn a_release_lies_a_tenth_within_its_limit() {
        let limits =
            SupervisorConfig { trip_theta_rad: 0.4, trip_q_rad_s: 2.0, ..SupervisorConfig::default() };
        let with =
            |theta, q| SupervisorConfig { release_theta_rad: theta, release_q_rad_s: q, ..limits }.build();
        assert!(with(0.35, 1.79).is_ok() && with(0.37, 1.0).is_err() && with(0.1, 1.81).is_err());
    }

    #[test]
    fn frozen_samples_are_none_or_two_at_least() {
        let with =
            |frozen_samples| SupervisorConfig { frozen_samples, ..SupervisorConfig::default() }.build();
        assert!(with(0).is_ok() && with(2).is_ok() && with(1).is_err() && with(1001).is_err());
    }

    #[test]
    fn rate_trips_too() {
        let mut bench = Bench::started();
        let ruling = bench.step(0.0, -2.5, Command::None);
        assert!(matches!(ruling.event, Some(Event::Tripped(Trip::Rate { .. }))));
    }

    #[test]
    fn one_recovery_too_many_aborts_and_leaves_the_controller_on() {
        let mut bench = Bench::started();
        for _ in 0..2 {
            bench.step(0.5, 0.0, Command::None);
            bench.step(0.0, 0.0, Command::None);
        }
        let ruling = bench.step(0.5, 0.0, Command::None);
        assert!(matches!(ruling.event, Some(Event::Aborted(Fault::TooManyRecoveries { allowed: 2, .. }))));
        assert_eq!(ruling.decision, Decision::Level);
    }

    #[test]
    fn a_recovery_that_takes_too_long_ends_in_neutral() {
        let mut bench = Bench::started();
        bench.step(0.5, 0.0, Command::None);
        let event = (0..300).find_map(|_| bench.step(0.5, 0.0, Command::None).event);
        assert!(matches!(event, Some(Event::Aborted(Fault::RecoveryTooLong { ticks: 251, .. }))));
        assert_eq!(bench.step(0.0, 0.0, Command::None).decision, Decision::Neutral);
    }

    #[test]
    fn the_operator_ends_a_test_but_cannot_restart_it() {
        let mut bench = Bench::started();
        let ruling = bench.step(0.0, 0.0, Command::Abort);
        assert_eq!(ruling.event, Some(Event::Aborted(Fault::Operator)));
        assert_eq!(ruling.decision, Decision::Level);
        assert_eq!(bench.step(0.0, 0.0, Command::Start).event, None);
    }

    #[test]
    fn a_bad_sample_ends_a_test_in_neutral() {
        let mut bench = Bench::started();
        let ruling = bench.step(f32::NAN, 0.0, Command::None);
        assert!(matches!(ruling.event, Some(Event::Aborted(Fault::NotFinite { .. }))));
        assert_eq!(ruling.decision, Decision::Neutral);
    }

    #[test]
    fn a_sample_is_acted_on_up_to_its_greatest_age() {
        let supervisor =
            SupervisorConfig { max_age_s: 0.015, ..SupervisorConfig::default() }.build().unwrap();
        let used = |age_us: u64| {
            let sample = Some(Sample { time_us: 100_000, q_rad_s: 0.0, theta_rad: 0.0 });
            let now_us = 100_000 + age_us;
            let input = Input { tick: 0, now_us, sample, theta_ref_rad: 0.0, command: Command::None };
            supervisor.step(&mut SupervisorState::default(), &input, false).sample.is_some()
        };
        assert!(used(0) && used(15_000) && !used(15_001));
    }

    #[test]
    fn without_a_sample_an_idle_vehicle_is_neutral() {
        let supervisor = SupervisorConfig::default().build().unwrap();
        let mut state = SupervisorState::default();
        let input = Input { tick: 0, now_us: 0, sample: None, theta_ref_rad: 0.0, command: Command::None };
        assert_eq!(supervisor.step(&mut state, &input, false).decision, Decision::Neutral);
    }
}
