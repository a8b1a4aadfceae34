//! The 20 ms step: sense → supervise → excite or recover → estimate → emit.
//!
//! The order matters twice. The supervisor sees the sample before the excitation moves, so nothing is sent to
//! the servo in a tick that finds the vehicle beyond a limit. The estimator meets q\[k\] with the inputs up to
//! u\[k−1\] before it takes u\[k\], which acts on q\[k+1\] at the earliest; and it takes what was truly sent,
//! whoever sent it.

use crate::attitude::{Attitude, AttitudeState};
use crate::convergence::{ConvergenceMeter, ConvergenceState};
use crate::lms::{LmsState, NormalizedLms};
use crate::plan::{Plan, PlanState, Section};
use crate::prbs::{Prbs, PrbsState};
use crate::supervisor::{Decision, Ruling, Supervisor, SupervisorState};
use crate::telemetry::{Input, Sample, Telemetry};

/// A test, checked; made by [`crate::Config::build`]. N taps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle<const N: usize> {
    pub(crate) seed: u64,
    pub(crate) prbs: Prbs,
    pub(crate) plan: Plan,
    pub(crate) supervisor: Supervisor,
    pub(crate) attitude: Attitude,
    pub(crate) lms: NormalizedLms<N>,
    pub(crate) convergence: ConvergenceMeter,
}

/// Everything that changes from cycle to cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleState<const N: usize> {
    supervisor: SupervisorState,
    plan: PlanState,
    prbs: PrbsState,
    attitude: AttitudeState,
    lms: LmsState<N>,
    convergence: ConvergenceState,
    last_u: f32,
}

impl<const N: usize> CycleState<N> {
    /// The estimate: w, rad/s per rad, the first tap one sample after the input delay.
    #[must_use]
    pub const fn taps(&self) -> &[f32; N] {
        self.lms.taps()
    }
}

/// What moves the servo in one tick.
struct Drive {
    u: f32,
    excitation: f32,
    reference: f32,
}

impl<const N: usize> Cycle<N> {
    /// The state before a test. Assign it to reset.
    #[must_use]
    pub fn initial_state(&self) -> CycleState<N> {
        CycleState {
            supervisor: SupervisorState::default(),
            plan: PlanState::default(),
            prbs: self.prbs.start(self.seed, 0),
            attitude: AttitudeState::default(),
            lms: LmsState::default(),
            convergence: ConvergenceState::default(),
            last_u: 0.0,
        }
    }

    /// One cycle. The command to send is `u_rad` of the report.
    pub fn step(&self, state: &mut CycleState<N>, input: &Input) -> Telemetry {
        let stage = self.plan.current(&mut state.plan);
        let ruling = self.supervisor.step(&mut state.supervisor, input, stage.is_none());
        let phase = state.supervisor.phase();
        let section = stage.filter(|_| phase.runs()).unwrap_or_default();

        let drive = self.drive(state, &ruling, section, input.theta_ref_rad);
        let prediction_error_rad_s = self.estimate(state, &ruling, section, drive.u);
        if ruling.decision == Decision::Proceed || (phase.runs() && section.sequence().is_none()) {
            self.plan.advance(&mut state.plan);
        }

        Telemetry {
            tick: input.tick,
            now_us: input.now_us,
            sample: ruling.sample,
            u_rad: drive.u,
            excitation_rad: drive.excitation,
            theta_ref_rad: drive.reference,
            section,
            supervised: phase.runs() && ruling.decision != Decision::Proceed,
            phase,
            event: ruling.event,
            recoveries: state.supervisor.recoveries(),
            prediction_error_rad_s,
            convergence: self.convergence.figures(&state.convergence),
        }
    }

    fn drive(&self, state: &mut CycleState<N>, ruling: &Ruling, section: Section, theta_ref: f32) -> Drive {
        let (u, excitation, reference) = match (ruling.decision, section.sequence()) {
            (Decision::Neutral, _) => (0.0, 0.0, 0.0),
            (Decision::Proceed, Some(sequence)) => {
                if state.plan.begins() {
                    state.prbs = self.prbs.start(self.seed, sequence);
                }
                let excitation = self.prbs.step(&mut state.prbs);
                (excitation, excitation, 0.0)
            }
            (Decision::Proceed, None) if section == Section::IV => {
                let reference = self.attitude.reference(theta_ref);
                (self.control(state, ruling.sample, reference), 0.0, reference)
            }
            (Decision::Proceed | Decision::Level, _) => (self.control(state, ruling.sample, 0.0), 0.0, 0.0),
        };
        state.last_u = u;
        Drive { u, excitation, reference }
    }

    /// The controller's command; the last command while a lost sample is bridged.
    fn control(&self, state: &mut CycleState<N>, sample: Option<Sample>, reference: f32) -> f32 {
        sample.map_or(state.last_u, |s| {
            self.attitude.step(&mut state.attitude, reference, s.theta_rad, s.q_rad_s)
        })
    }

    /// q − q̂; the taps move in I to III unless the supervisor holds.
    fn estimate(&self, state: &mut CycleState<N>, ruling: &Ruling, section: Section, u: f32) -> f32 {
        let error = ruling.sample.map_or(0.0, |sample| {
            let adapt = ruling.decision == Decision::Proceed && section.sequence().is_some();
            let line = [state.lms.line().energy(), state.lms.line().sum()];
            let update = self.lms.observe(&mut state.lms, sample.q_rad_s, adapt);
            if adapt {
                self.convergence.step(&mut state.convergence, &self.lms, update, sample.q_rad_s, line);
            }
            update.error
        });
        self.lms.push(&mut state.lms, u);
        error
    }
}
