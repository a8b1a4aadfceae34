//! The sampled pitch model: the grey-box plant with any number of effects, run as a simulation or as a predictor.
//!
//! Linear parts are propagated exactly (matrix exponential), effects by a midpoint rule over steps of at most 10 ms:
//! each effect's moment is split into its linear part, which joins the state matrix, and a remainder.

mod part_of_a_term;

pub use part_of_a_term::Part;

use super::innovation_filter::InnovationFilter;
use super::kalman::{Channel, steady_gain};
use super::kick::Kick;
use super::shift::Shift;
use super::transition::Transition;
use crate::dataset::{Amplitudes, Run};
use crate::model::effect::{Conditions, Effect};
use crate::model::noise::{Disturbance, Third};
use crate::model::plant::{
    DISTURBANCE, GUST, GYRO, Plant, Q, Q_IMU, STATES, State, StateMatrix, THETA, THETA_IMU,
};
use nalgebra::{RowSVector, SMatrix};

/// Longest step of the midpoint rule, s.
const LONGEST_STEP: f64 = 0.0101;
/// Steps of the midpoint rule in a period of the motion: terms that bend a motion of nine samples a period are off by a third
/// of their size when they act once a sample.
const SUBSTEPS_A_PERIOD: f64 = 36.0;
const MOST_SUBSTEPS: f64 = 8.0;
/// Room for the effects' own states.
pub const OWN_STATES: usize = 28;
/// A pitch rate is "rest" below this share of its standard deviation.
const REST: f64 = 0.02;
/// Leak of an angle that nothing observes, 1/s.
const LEAK: f64 = 0.1;
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

/// A term with the place of its own states among those of all terms.
struct Placed<'a> {
    effect: &'static dyn Effect,
    values: &'a [f64],
    own: core::ops::Range<usize>,
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
}

/// Output of the model at one sample: pitch rate in rad/s and pitch angle in rad, as the sensors show them.
pub type Output = [f64; 2];

/// The model, discretised for one sample period.
pub struct PitchModel<'a> {
    plant: Plant,
    terms: Vec<Placed<'a>>,
    /// Over a whole sample.
    over_sample: StateMatrix,
    /// Over one substep, for the inner loop.
    substep: Transition,
    /// Over a whole sample, for the inner loop.
    sample: Transition,
    per_moment: State,
    /// Response of the state at the sample's end to a unit moment during each of its substeps.
    per_moment_of_substep: Vec<State>,
    /// Response of the state to a unit rate added to θ̇.
    per_angle_rate: State,
    /// Response of the state at a substep's end to a unit angular impulse within it.
    kick: Kick,
    /// Moment on the airframe per state, N m.
    moment_row: RowSVector<f64, STATES>,
    /// The states that are measured: rate and angle.
    measured: (usize, usize),
    /// Whether a term needs the motion within a sample.
    within_sample: bool,
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
        let substeps = (step / longest).ceil().clamp(1.0, MOST_SUBSTEPS) as usize;
        let dt = step / substeps as f64;
        if terms.iter().map(|term| term.effect.states()).sum::<usize>() > OWN_STATES {
            return None;
        }
        let conditions = Conditions {
            dt,
            small_rate: REST * sizes.q,
            sizes: *sizes,
            inertia: plant.inertia,
            ..Conditions::default()
        };
        let (stiffness, damping) = linear_part(terms, &conditions);
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
        let terms = placed(terms);
        let at_the_end = Conditions { t: f64::MAX, ..conditions };
        let delay = plant.delay + later(&terms, &conditions);
        let delay_moves = later(&terms, &at_the_end) != later(&terms, &conditions);
        let inertia_changes = inertia_factor(&terms, &at_the_end) != 1.0;
        let exp = block.exp();
        let transition = exp.fixed_view::<STATES, STATES>(0, 0).into_owned();
        let per_moment = exp.fixed_view::<STATES, 1>(0, STATES).into_owned();
        let mut over_sample = transition;
        let mut per_moment_of_substep = vec![per_moment];
        for _ in 1..substeps {
            per_moment_of_substep.insert(0, over_sample * per_moment);
            over_sample = transition * over_sample;
        }
        Some(Self {
            plant,
            over_sample,
            substep: Transition::new(&transition),
            sample: Transition::new(&over_sample),
            per_moment,
            per_moment_of_substep,
            per_angle_rate: exp.fixed_view::<STATES, 1>(0, STATES + 1).into_owned(),
            kick: Kick::new(&(continuous * dt), &transition, plant.inertia),
            moment_row: continuous.row(Q) * plant.inertia,
            measured: (rate, angle),
            within_sample: terms.iter().any(|term| term.effect.within_sample()),
            has_limit: limited(&terms, BEYOND) != BEYOND,
            terms,
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
        self.over_sample.complex_eigenvalues().iter().all(|root| root.norm() <= 1.0 + HAIR)
    }

    /// Indices of the states that are measured: rate and angle.
    pub fn measured(&self) -> (usize, usize) {
        self.measured
    }

    /// Kalman gains for the outputs that `run` has, under the noise model `disturbance`.
    pub fn gain(&self, disturbance: &Disturbance, run: &Run) -> Option<Gains> {
        let begin = self.steady(disturbance, run)?;
        if !self.inertia_changes {
            return Some(Gains { begin, changed: None });
        }
        let factor = self.inertia_at(f64::MAX);
        let plant = Plant { inertia: factor * self.plant.inertia, ..self.plant };
        let later = PitchModel::new(&plant, &[], disturbance, self.step, &self.sizes)?;
        Some(Gains { begin, changed: Some(later.steady(disturbance, run)?) })
    }

    /// How a moment or an addition to a measurement that the model lacks shows in the innovations of the predictor with
    /// `gains` over `run`; the terms by their linear part.
    pub fn innovation_filter(&self, gains: &Gains, run: &Run) -> InnovationFilter {
        let (rate, angle) = self.measured;
        let channels = [(run.rate.is_some(), rate), (run.angle.is_some(), angle)];
        let measured: Vec<usize> = channels.iter().filter(|c| c.0).map(|c| c.1).collect();
        let per_addition: Vec<State> = gains.begin.iter().map(|k| self.over_sample * k).collect();
        let mut transition = self.over_sample;
        for (&state, addition) in measured.iter().zip(&per_addition) {
            let less = transition.column(state) - addition;
            transition.set_column(state, &less);
        }
        InnovationFilter {
            transition,
            per_moment: self.per_moment_of_substep.iter().sum(),
            per_addition,
            measured,
            delay: self.delay,
        }
    }

    fn inertia_at(&self, t: f64) -> f64 {
        inertia_factor(&self.terms, &Conditions { t, dt: self.step, ..self.conditions })
    }

    fn steady(&self, disturbance: &Disturbance, run: &Run) -> Option<Vec<State>> {
        let mut over_sample = self.over_sample;
        let mut process = StateMatrix::zeros();
        let mut driven = |state: usize, intensity: f64| {
            let mut drive = State::zeros();
            drive[state] = intensity * (self.step / 2.0).sqrt();
            let later = self.over_sample * drive;
            process += drive * drive.transpose() + later * later.transpose();
        };
        driven(DISTURBANCE + 1, disturbance.intensity);
        if let Some(Third::Gust(gust)) = disturbance.third {
            driven(GUST, gust.sigma * (2.0 / gust.time_constant).sqrt());
        }
        let (rate, angle) = self.measured;
        let mut channels = Vec::with_capacity(2);
        if run.rate.is_some() {
            channels.push(Channel { state: rate, variance: 1.0 });
        }
        if run.angle.is_some() {
            let noise = if run.rate.is_some() { disturbance.angle_noise } else { 1.0 };
            channels.push(Channel { state: angle, variance: noise * noise });
        } else {
            // The angle is a pure integrator that nothing observes: a slow leak keeps its variance finite.
            for i in [THETA, THETA_IMU] {
                for j in 0..STATES {
                    over_sample[(i, j)] *= 1.0 - LEAK * self.step;
                }
            }
        }
        steady_gain(&over_sample, &process, &channels)
    }

    /// The point that stands for rest at the first measurement of `run`.
    pub fn start(&self, run: &Run) -> Point {
        let first =
            |signal: &Option<Vec<f64>>| signal.as_ref().and_then(|s| s.first()).copied().unwrap_or(0.0);
        let (rate, angle) = (first(&run.rate), first(&run.angle));
        let mut x = State::zeros();
        x[Q] = rate;
        x[GYRO] = if self.measured.1 == GYRO { angle } else { rate };
        x[THETA] = angle;
        if self.plant.mount.is_some() {
            x[Q_IMU] = rate;
            x[THETA_IMU] = angle;
        }
        Point { x, own: [0.0; OWN_STATES], roll_rate: at_row(&run.beside.roll_rate, 0) }
    }

    /// What the log shows at `point`.
    pub fn output(&self, point: &Point) -> Output {
        self.limited(self.sensed(point))
    }

    fn sensed(&self, point: &Point) -> Output {
        let (rate, angle) = self.measured;
        let y = [point.x[rate], point.x[angle]];
        let at = Conditions { roll_rate: point.roll_rate, ..self.conditions };
        let sense = |y, Placed { effect, values, own }: &Placed<'_>| {
            effect.measure(values, &point.own[own.clone()], y, &at)
        };
        self.terms.iter().fold(y, sense)
    }

    fn limited(&self, y: Output) -> Output {
        if self.has_limit { limited(&self.terms, y) } else { y }
    }

    /// One sample further, from row `k` of `run` to row k+1. `false` when the state has diverged.
    pub fn advance(&self, point: &mut Point, run: &Run, k: usize) -> bool {
        let mut at = self.conditions;
        if let Some(rows) = &run.beside.roll_and_yaw {
            [at.roll_rate, at.yaw_rate, at.roll] = rows[k];
        }
        at.roll_command = at_row(&run.beside.roll_command, k);
        at.thrust = at_row(&run.beside.thrust, k);
        at.voltage = at_row(&run.beside.voltage, k);
        let mut driven = State::zeros();
        for (i, per_moment) in self.per_moment_of_substep.iter().enumerate() {
            at.t = run.elapsed(k) + i as f64 * at.dt;
            let delay =
                if self.delay_moves { self.plant.delay + later(&self.terms, &at) } else { self.delay };
            let shift = if delay == self.delay {
                self.shifts[i][usize::from(run.held)]
            } else {
                Shift::new(delay, i, self.substeps, self.step, run.held)
            };
            (at.command_ends, at.command) = shift.apply(run, k);
            let control = self.plant.dm_du * self.actuated(point, &at);
            let mut forced = self.terms.iter().map(|term| term.effect.forcing(term.values, &at)).sum::<f64>();
            if self.within_sample {
                let impulse =
                    self.terms.iter().map(|term| term.effect.impulse(term.values, &at)).sum::<f64>();
                let jumps = run.held && impulse != 0.0;
                let kicked = jumps.then(|| {
                    self.kick.left(at.command_left()) * (impulse / inertia_factor(&self.terms, &at))
                });
                if !jumps {
                    forced += impulse / at.dt;
                }
                self.substep_with_terms(point, control, forced, kicked, &at);
            } else {
                driven += per_moment * (control + forced);
            }
        }
        point.roll_rate = at_row(&run.beside.roll_rate, k + 1);
        if !self.within_sample {
            point.x = self.sample.apply(&point.x) + driven;
        }
        point.x[Q].abs() < DIVERGED * self.sizes.q
            && point.x[THETA].abs() < DIVERGED * self.sizes.theta.max(1.0)
    }

    /// What the blades do in one substep when the delayed command arrives.
    fn actuated(&self, point: &mut Point, at: &Conditions) -> f64 {
        let mut u = at.command;
        for Placed { effect, values, own } in &self.terms {
            u = effect.actuate(values, &mut point.own[own.clone()], u, at);
        }
        u
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
        let (moment, angle_rate) = self.nonlinear(&before, &point.own, driving, at);
        point.x = self.substep.apply(&before)
            + self.per_moment * (driving + moment)
            + self.per_angle_rate * angle_rate;
        if let Some(kicked) = kicked {
            point.x += kicked;
        }
        let mut middle = (before + point.x) * 0.5;
        // The chord cuts off an angle that swings: Hermite's cubic through both ends does not.
        middle[THETA] += at.dt * (before[Q] - point.x[Q]) / 8.0;
        let (corrected, corrected_rate) = self.nonlinear(&middle, &point.own, driving, at);
        point.x +=
            self.per_moment * (corrected - moment) + self.per_angle_rate * (corrected_rate - angle_rate);
        let (rate, angle) = self.measured;
        let (q, theta, acceleration) = (point.x[rate], point.x[angle], control / self.plant.inertia);
        let mean = |state: usize| 0.5 * (before[state] + point.x[state]);
        let (mean_rate, mean_angle) = (mean(Q), mean(THETA));
        for Placed { effect, values, own } in &self.terms {
            let own = &mut point.own[own.clone()];
            effect.follow(values, own, mean_rate, mean_angle, at);
            effect.sense(values, own, q, theta, acceleration, at);
        }
    }

    /// Moment and rate of the angle that the effects add to the linear model at state `x`.
    fn nonlinear(&self, x: &State, own: &[f64; OWN_STATES], driving: f64, at: &Conditions) -> (f64, f64) {
        let (q, theta) = (x[Q], x[THETA]);
        let (mut moment, mut angle_rate) = (self.stiffness * theta + self.damping * q, 0.0);
        for term in &self.terms {
            moment += term.effect.moment(term.values, &own[term.own.clone()], q, theta, at);
            angle_rate += term.effect.angle_rate(term.values, q, at);
        }
        if self.inertia_changes {
            let inertia = inertia_factor(&self.terms, at);
            let all = (self.moment_row * x)[0] + driving + moment;
            moment += all * (1.0 / inertia - 1.0);
        }
        (moment, angle_rate)
    }

    /// Free run: simulates rows `rows` of `run` from `point`, the state at the first of them.
    pub fn simulate(
        &self,
        run: &Run,
        rows: core::ops::Range<usize>,
        mut point: Point,
    ) -> Option<Vec<Output>> {
        let mut outputs = Vec::with_capacity(rows.len());
        for k in rows {
            outputs.push(self.output(&point));
            if !self.advance(&mut point, run, k) {
                return None;
            }
        }
        Some(outputs)
    }

    /// Innovations e = y − ŷ of the predictor with `gains` over the first `rows` of `run`; channels without a measurement
    /// give zero. `visit` sees the corrected state of every row.
    pub fn innovations(
        &self,
        run: &Run,
        gains: &Gains,
        rows: usize,
        mut visit: impl FnMut(usize, &Point),
    ) -> Option<Vec<Output>> {
        let mut point = self.start(run);
        let mut innovations = Vec::with_capacity(rows);
        let mut censored = Vec::new();
        for k in 0..rows {
            let sensed = self.sensed(&point);
            let expected = self.limited(sensed);
            let gain = match &gains.changed {
                Some(later) if self.inertia_at(run.elapsed(k)) != 1.0 => later,
                _ => &gains.begin,
            };
            let mut e = [0.0; 2];
            let mut column = 0;
            for (channel, signal) in [&run.rate, &run.angle].into_iter().enumerate() {
                if let Some(signal) = signal {
                    e[channel] = signal[k] - expected[channel];
                    point.x += gain[column] * e[channel];
                    column += 1;
                }
            }
            let at_limit = run.rate.as_ref().is_some_and(|rate| rate[k].abs() >= run.rate_limit);
            if at_limit && sensed[0] != expected[0] {
                censored.push(k);
            }
            innovations.push(e);
            visit(k, &point);
            if !self.advance(&mut point, run, k) {
                return None;
            }
        }
        impute(&mut innovations, &censored);
        Some(innovations)
    }
}

/// Adds to the rate's innovation of each of the `censored` rows that of another row, drawn by its number, with a sign drawn
/// alike: a reading at the limit says where the limit is and that the rate is at least that, and neither that the model is right
/// nor how strong the noise is (hot-deck imputation: Andridge and Little, Int. Stat. Rev. 78, 2010).
fn impute(innovations: &mut [Output], censored: &[usize]) {
    let mut is_censored = vec![false; innovations.len()];
    censored.iter().for_each(|&k| is_censored[k] = true);
    let donors: Vec<usize> = (0..innovations.len()).filter(|&k| !is_censored[k]).collect();
    if donors.is_empty() {
        return;
    }
    for &k in censored {
        // Knuth's multiplicative hash
        let drawn = (k as u32).wrapping_add(1).wrapping_mul(2_654_435_769);
        let sign = if drawn & 0x8000 == 0 { 1.0 } else { -1.0 };
        innovations[k][0] += sign * innovations[donors[(drawn >> 16) as usize % donors.len()]][0];
    }
}

/// Value of a column in row `k`, after its last row as it is there; zero where there is no column.
fn at_row(column: &Option<Vec<f64>>, k: usize) -> f64 {
    column.as_ref().and_then(|values| values.get(k).or(values.last())).copied().unwrap_or(0.0)
}

/// The terms that act; the background does so by its noise alone.
fn placed(terms: &[Term]) -> Vec<Placed<'_>> {
    let mut placed: Vec<Placed<'_>> = Vec::with_capacity(terms.len());
    for Term { effect, values } in terms.iter().filter(|term| !term.effect.is_background()) {
        let begin = placed.last().map_or(0, |before| before.own.end);
        placed.push(Placed { effect: *effect, values, own: begin..begin + effect.states() });
    }
    placed
}

fn limited(terms: &[Placed<'_>], y: Output) -> Output {
    terms.iter().fold(y, |y, term| term.effect.limit(term.values, y))
}

/// Delay that the terms add, s.
fn later(terms: &[Placed<'_>], at: &Conditions) -> f64 {
    terms.iter().map(|term| term.effect.delay(term.values, at)).sum()
}

/// Factor by which the terms change the inertia.
fn inertia_factor(terms: &[Placed<'_>], at: &Conditions) -> f64 {
    terms.iter().map(|term| term.effect.inertia(term.values, at)).product()
}

/// Stiffness and damping (N m/rad, N m s/rad) that stand for the effects' moments in the mean, at the signals'
/// sizes: statistical linearisation (Booton, 1954) by three Gauss–Hermite nodes.
fn linear_part(terms: &[Term], at: &Conditions) -> (f64, f64) {
    let sizes = &at.sizes;
    let own = [0.0; OWN_STATES];
    let moment = |q: f64, theta: f64| -> f64 {
        terms.iter().map(|term| term.effect.moment(&term.values, &own, q, theta, at)).sum()
    };
    let root = 3f64.sqrt();
    let slope = |plus: f64, minus: f64, size: f64| -(plus - minus) / (2.0 * root * size);
    let (dq, dtheta) = (root * sizes.q, root * sizes.theta);
    (
        slope(moment(0.0, dtheta), moment(0.0, -dtheta), sizes.theta),
        slope(moment(dq, 0.0), moment(-dq, 0.0), sizes.q),
    )
}
