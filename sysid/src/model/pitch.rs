//! The sampled pitch model: the grey-box plant with any number of effects, run as a simulation or as a predictor.
//!
//! Linear parts are propagated exactly (matrix exponential), effects by a midpoint rule over steps of at most 10 ms:
//! each effect's moment is split into its linear part, which joins the state matrix, and a remainder.
//! Dry friction comes last in a step (`dry_friction`).

mod drive;
mod dry_friction;
mod part_of_a_term;
mod placed;
mod predictor;

pub use drive::{Drive, Driven};
pub use part_of_a_term::Part;

use super::kick::Kick;
use super::shift::Shift;
use super::transition::Transition;
use crate::dataset::{Amplitudes, Run};
use crate::model::effect::{Conditions, Effect};
use crate::model::noise::Disturbance;
use crate::model::plant::{GYRO, Plant, Q, Q_IMU, STATES, State, StateMatrix, THETA, THETA_IMU};
use drive::set_beside;
use dry_friction::rubs;
use nalgebra::{RowSVector, SMatrix};
use placed::{Placed, inertia_factor, later, limited, linear_part, placed};

/// Longest step of the midpoint rule, s.
const LONGEST_STEP: f64 = 0.0101;
/// Steps of the midpoint rule in a period of the motion: terms that bend a motion of nine samples a period are off by a third
/// of their size when they act once a sample.
const SUBSTEPS_A_PERIOD: f64 = 36.0;
const MOST_SUBSTEPS: usize = 8;
/// Room for the effects' own states.
pub const OWN_STATES: usize = 28;
/// A pitch rate is "rest" below this share of its standard deviation.
const REST: f64 = 0.02;
/// A reading that no sensor gives, rad/s and rad.
const BEYOND: Output = [1e9; 2];
/// Divergence: states beyond this multiple of the signals' size end a run.
const DIVERGED: f64 = 1e4;

/// An effect with the values of its parameters.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Its parameters, in the order of [`Effect::parameters`].
    pub values: Vec<f64>,
}

/// Where a simulation stands: the plant's state and the effects' own.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// State of the plant.
    pub x: State,
    own: [f64; OWN_STATES],
    /// Roll rate at this sample, rad/s.
    roll_rate: f64,
}

/// Kalman gains of the predictor, one column per measured channel.
#[derive(Clone, Debug)]
pub struct Gains {
    /// With the plant as it is at first.
    pub begin: Vec<State>,
    /// With the inertia that an effect leaves, from the moment on that it changes.
    changed: Option<Vec<State>>,
    /// By what is new in the command.
    corrects: Option<State>,
}

/// Output of the model at one sample: pitch rate in rad/s and pitch angle in rad, as the sensors show them.
pub type Output = [f64; 2];

/// The model, discretised for one sample period.
pub struct PitchModel<'a> {
    plant: Plant,
    terms: Vec<Placed<'a>>,
    /// Those of the terms that act on what drives the motion.
    driving: Vec<Placed<'a>>,
    /// Those that act on the motion, or are moved by it, within a sample, but for dry friction.
    within_sample: Vec<Placed<'a>>,
    /// Dry friction; with none of these two, samples are not cut.
    rubbing: Vec<Placed<'a>>,
    /// Those of these that have states of their own.
    following: Vec<Placed<'a>>,
    /// Whether one of these is impulsive.
    is_impulsive: bool,
    /// Over a whole sample, dry friction by its linear part too: what gains are made of.
    linearised: StateMatrix,
    /// Over one substep, for the inner loop.
    substep: Transition,
    /// Over a whole sample, for the inner loop.
    sample: Transition,
    per_moment: State,
    /// Response of the state at the sample's end to a unit moment during each of its substeps.
    per_moment_of_substep: Vec<State>,
    /// Response of the state at a substep's end to a unit rate added to θ̇ within it.
    per_angle_rate: State,
    /// Response of the state at the sample's end to a unit rate added to θ̇ all the while.
    per_angle_rate_of_sample: State,
    /// Response of the state at a substep's end to a unit angular impulse within it.
    kick: Kick,
    /// Moment on the airframe per state, N m.
    moment_row: RowSVector<f64, STATES>,
    /// The states that are measured: rate and angle.
    measured: (usize, usize),
    /// Whether a term limits what the log can show.
    has_limit: bool,
    /// Delay of the input at the start of a recording, s.
    delay: f64,
    /// Whether the delay changes over time.
    delay_moves: bool,
    /// Whether the inertia changes over time.
    inertia_changes: bool,
    /// Where the input of each substep stands for that delay: between samples, held.
    shifts: Vec<[Shift; 2]>,
    stiffness: f64,
    damping: f64,
    step: f64,
    substeps: usize,
    sizes: Amplitudes,
    /// Conditions of a substep, but for what changes from one to the next.
    conditions: Conditions,
}

impl<'a> PitchModel<'a> {
    /// Discretises `plant` with `terms` for the sample period `step` in s. `sizes` are the signals' typical sizes, at
    /// which the effects are linearised. `None` where the parameters leave no finite model.
    pub fn new(
        plant: &Plant,
        terms: &'a [Term],
        disturbance: &Disturbance,
        step: f64,
        sizes: &Amplitudes,
    ) -> Option<Self> {
        let mut plant = *plant;
        for term in terms {
            term.effect.plant(&term.values, &mut plant);
        }
        let fastest = sizes.q / sizes.theta.max(f64::MIN_POSITIVE);
        let longest = LONGEST_STEP.min(core::f64::consts::TAU / (SUBSTEPS_A_PERIOD * fastest));
        let substeps = (step / longest).ceil().clamp(1.0, MOST_SUBSTEPS as f64) as usize;
        let dt = step / substeps as f64;
        let acting = placed(terms);
        if acting.last().is_some_and(|last| last.collective.end > OWN_STATES) {
            return None;
        }
        let conditions = Conditions {
            dt,
            small_rate: REST * sizes.q,
            sizes: *sizes,
            inertia: plant.inertia,
            ..Conditions::default()
        };
        let (rub, others): (Vec<&Term>, Vec<&Term>) =
            terms.iter().partition(|term| rubs(term.effect, &term.values));
        let (stiffness, damping) = linear_part(&others, &conditions);
        let mut continuous = plant.state_matrix(stiffness, damping, disturbance);
        let (mut rate, mut angle) = plant.measured();
        let lag = |of: fn(&Term) -> Option<f64>| terms.iter().find_map(of);
        let (of_rate, of_angle) =
            (lag(|t| t.effect.gyro_lag(&t.values)), lag(|t| t.effect.angle_lag(&t.values)));
        let filtered = match (of_rate, of_angle) {
            (None, None) => None,
            (Some(lag), None) => Some((lag, &mut rate)),
            (None, Some(lag)) => Some((lag, &mut angle)),
            (Some(_), Some(_)) => return None,
        };
        if let Some((lag, measured)) = filtered {
            continuous[(GYRO, *measured)] = 1.0 / lag;
            continuous[(GYRO, GYRO)] = -1.0 / lag;
            *measured = GYRO;
        }
        let mut block = SMatrix::<f64, { STATES + 2 }, { STATES + 2 }>::zeros();
        block.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(&continuous);
        block[(Q, STATES)] = 1.0 / plant.inertia;
        block[(THETA, STATES + 1)] = 1.0;
        if plant.mount.is_some() {
            // Kinematics turn the mount along with the airframe: its deflection stays.
            block[(THETA_IMU, STATES + 1)] = 1.0;
        }
        block *= dt;
        if !block.amax().is_finite() || block.amax() > 1e4 {
            return None;
        }
        let (within_sample, driving): (Vec<Placed<'_>>, Vec<Placed<'_>>) =
            acting.iter().cloned().partition(|term| term.effect.within_sample());
        let (rubbing, within_sample): (Vec<Placed<'_>>, Vec<Placed<'_>>) =
            within_sample.into_iter().partition(|term| rubs(term.effect, term.values));
        let at_the_end = Conditions { t: f64::MAX, ..conditions };
        let delay = plant.delay + later(&acting, &conditions);
        let delay_moves = later(&acting, &at_the_end) != later(&acting, &conditions);
        let inertia_changes = inertia_factor(&acting, &at_the_end) != 1.0;
        let exp = block.exp();
        let transition = exp.fixed_view::<STATES, STATES>(0, 0).into_owned();
        let per_moment = exp.fixed_view::<STATES, 1>(0, STATES).into_owned();
        let per_angle_rate = exp.fixed_view::<STATES, 1>(0, STATES + 1).into_owned();
        let mut per_angle_rate_of_sample = per_angle_rate;
        let mut over_sample = transition;
        let mut per_moment_of_substep = vec![per_moment];
        for _ in 1..substeps {
            per_moment_of_substep.insert(0, over_sample * per_moment);
            per_angle_rate_of_sample = transition * per_angle_rate_of_sample + per_angle_rate;
            over_sample = transition * over_sample;
        }
        let kick = Kick::new(&(continuous * dt), &transition, plant.inertia);
        let moment_row = continuous.row(Q) * plant.inertia;
        let linear_friction = linear_part(&rub, &conditions).1;
        let linearised = if linear_friction == 0.0 {
            over_sample
        } else {
            continuous[(Q, Q)] -= linear_friction / plant.inertia;
            (continuous * step).exp()
        };
        Some(Self {
            plant,
            linearised,
            substep: Transition::new(&transition),
            sample: Transition::new(&over_sample),
            per_moment,
            per_moment_of_substep,
            per_angle_rate,
            per_angle_rate_of_sample,
            kick,
            moment_row,
            measured: (rate, angle),
            is_impulsive: within_sample.iter().any(|term| term.effect.is_impulsive()),
            driving,
            rubbing,
            following: within_sample.iter().filter(|term| !term.own.is_empty()).cloned().collect(),
            within_sample,
            has_limit: limited(&acting, BEYOND) != BEYOND,
            terms: acting,
            delay,
            delay_moves,
            inertia_changes,
            shifts: (0..substeps)
                .map(|i| [false, true].map(|held| Shift::new(delay, i, substeps, step, held)))
                .collect(),
            stiffness,
            damping,
            step,
            substeps,
            sizes: *sizes,
            conditions,
        })
    }

    /// Whether the linear model's motion dies out or drifts, but does not grow.
    pub fn is_stable(&self) -> bool {
        const HAIR: f64 = 1e-6;
        self.linearised.complex_eigenvalues().iter().all(|root| root.norm() <= 1.0 + HAIR)
    }

    /// Indices of the states that are measured: rate and angle.
    pub fn measured(&self) -> (usize, usize) {
        self.measured
    }

    fn inertia_at(&self, t: f64) -> f64 {
        inertia_factor(&self.terms, &Conditions { t, dt: self.step, ..self.conditions })
    }

    /// The point that stands for rest at the first measurement of `run`.
    pub fn start(&self, run: &Run) -> Point {
        let first =
            |signal: &Option<Vec<f64>>| signal.as_ref().and_then(|s| s.first()).copied().unwrap_or(0.0);
        let (rate, shown) = (first(&run.rate), first(&run.angle));
        let resting_at = |angle: f64| {
            let mut x = State::zeros();
            x[Q] = rate;
            x[GYRO] = if self.measured.1 == GYRO { angle } else { rate };
            x[THETA] = angle;
            if self.plant.mount.is_some() {
                x[Q_IMU] = rate;
                x[THETA_IMU] = angle;
            }
            Point { x, own: [0.0; OWN_STATES], roll_rate: at_row(&run.beside.roll_rate, 0) }
        };
        // a sensor with another zero shows that angle at another one
        let there = resting_at(shown);
        let off = self.sensed(&there)[1] - shown;
        if off == 0.0 { there } else { resting_at(shown - off) }
    }

    /// What the log shows at `point`.
    pub fn output(&self, point: &Point) -> Output {
        self.limited(self.sensed(point))
    }

    fn sensed(&self, point: &Point) -> Output {
        let (rate, angle) = self.measured;
        let y = [point.x[rate], point.x[angle]];
        let sense = |y, Placed { effect, values, own, .. }: &Placed<'_>| {
            effect.measure(values, &point.own[own.clone()], y, point.roll_rate)
        };
        self.terms.iter().fold(y, sense)
    }

    fn limited(&self, y: Output) -> Output {
        if self.has_limit { limited(&self.terms, y) } else { y }
    }

    /// One sample further, from row `k` of `run` to row k+1. `false` when the state has diverged.
    pub fn advance(&self, point: &mut Point, run: &Run, k: usize) -> bool {
        let mut at = self.conditions;
        let mut drives = [Drive::default(); MOST_SUBSTEPS];
        let drives = &mut drives[..self.substeps];
        self.drive(&mut point.own, run, k, &mut at, drives);
        self.moved(point, run, k, &mut at, drives)
    }

    /// The motion one sample further under `drives`, one for each substep; `at` are the conditions of any row. What the angle has
    /// of roll and yaw, θ̇ = q cos φ − r sin φ, comes at its end, by the mean of both rows.
    fn moved(&self, point: &mut Point, run: &Run, k: usize, at: &mut Conditions, drives: &[Drive]) -> bool {
        let before = point.x[Q];
        let goes_on = self.moved_level(point, run, k, at, drives);
        if let Some(rows) = &run.beside.roll_and_yaw {
            let (from, to) = (rows[k], *rows.get(k + 1).unwrap_or(&rows[k]));
            let pitching = 0.25 * (before + point.x[Q]) * (from.shortening + to.shortening);
            point.x += self.per_angle_rate_of_sample * (pitching + 0.5 * (from.carried + to.carried));
        }
        goes_on
    }

    /// The same of a vehicle that is level in roll.
    fn moved_level(
        &self,
        point: &mut Point,
        run: &Run,
        k: usize,
        at: &mut Conditions,
        drives: &[Drive],
    ) -> bool {
        if self.within_sample.is_empty() && self.rubbing.is_empty() {
            let mut driven = State::zeros();
            for (per_moment, drive) in self.per_moment_of_substep.iter().zip(drives) {
                driven += per_moment * (self.plant.dm_du * drive.blades + drive.forced);
            }
            point.x = self.sample.apply(&point.x) + driven;
        } else {
            set_beside(at, run, k);
            for (i, drive) in drives.iter().enumerate() {
                at.t = run.elapsed(k) + i as f64 * at.dt;
                at.command = drive.command;
                at.control = self.plant.dm_du * drive.blades;
                let mut forced = drive.forced;
                let mut kicked = None;
                if self.is_impulsive && drive.change != 0.0 {
                    at.blades_change = drive.change;
                    let impulses = self.within_sample.iter().map(|term| term.effect.impulse(term.values, at));
                    let impulse = impulses.sum::<f64>();
                    match drive.left {
                        Some(left) => {
                            kicked = Some(self.kick.left(left) * (impulse / inertia_factor(&self.terms, at)));
                        }
                        None => forced += impulse / at.dt,
                    }
                }
                self.substep_with_terms(point, at.control, forced, kicked, at);
            }
        }
        point.roll_rate = at_row(&run.beside.roll_rate, k + 1);
        point.x[Q].abs() < DIVERGED * self.sizes.q
            && point.x[THETA].abs() < DIVERGED * self.sizes.theta.max(1.0)
    }

    /// One substep under the control moment `control` and the moment `forced` that the motion has no part in; `kicked` is what
    /// a jump of the command adds to the state at its end.
    fn substep_with_terms(
        &self,
        point: &mut Point,
        control: f64,
        forced: f64,
        kicked: Option<State>,
        at: &Conditions,
    ) {
        let (before, driving) = (point.x, control + forced);
        let moment = self.nonlinear(&before, &point.own, driving, at);
        let mut after = self.substep.apply(&before) + self.per_moment * (driving + moment);
        if let Some(kicked) = kicked {
            after += kicked;
        }
        let mut middle = (before + after) * 0.5;
        // The chord cuts off an angle that swings: Hermite's cubic through both ends does not.
        middle[THETA] += at.dt * (before[Q] - after[Q]) / 8.0;
        after += self.per_moment * (self.nonlinear(&middle, &point.own, driving, at) - moment);
        if !self.rubbing.is_empty() {
            let (friction, slower) = self.rubbed(before[Q], after[Q], at);
            after += self.per_moment * friction + self.per_angle_rate * slower;
        }
        point.x = after;
        let (rate, angle) = self.measured;
        let mean = |state: usize| 0.5 * (before[state] + after[state]);
        for Placed { effect, values, own, .. } in &self.following {
            let own = &mut point.own[own.clone()];
            effect.follow(values, own, mean(Q), mean(THETA), at);
            effect.sense(values, own, after[rate], after[angle], control / self.plant.inertia, at);
        }
    }

    /// Moment that the effects add to the linear model at state `x`.
    #[inline(always)]
    fn nonlinear(&self, x: &State, own: &[f64; OWN_STATES], driving: f64, at: &Conditions) -> f64 {
        let (q, theta) = (x[Q], x[THETA]);
        let mut moment = self.stiffness * theta + self.damping * q;
        for term in &self.within_sample {
            moment += term.effect.moment(term.values, &own[term.own.clone()], q, theta, at);
        }
        if self.inertia_changes {
            let inertia = inertia_factor(&self.terms, at);
            let all = (self.moment_row * x)[0] + driving + moment;
            moment += all * (1.0 / inertia - 1.0);
        }
        moment
    }

    /// Free run: simulates rows `rows` of `run` from `point`, the state at the first of them.
    pub fn simulate(&self, run: &Run, rows: core::ops::Range<usize>, point: Point) -> Option<Vec<Output>> {
        self.driven(run).simulate(rows, point)
    }
}

/// Value of a column in row `k`, after its last row as it is there; zero where there is no column.
fn at_row(column: &Option<Vec<f64>>, k: usize) -> f64 {
    column.as_ref().and_then(|values| values.get(k).or(values.last())).copied().unwrap_or(0.0)
}
