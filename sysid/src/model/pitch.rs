//! The sampled pitch model: the grey-box plant with any number of effects, run as a simulation or as a predictor.
//!
//! Linear parts are propagated exactly (matrix exponential), effects by a midpoint rule over steps of at most 10 ms:
//! each effect's moment is split into its linear part, which joins the state matrix, and a remainder.

use super::grey_box::{Disturbance, Plant, Q, State, StateMatrix, THETA};
use super::kalman::{Channel, steady_gain};
use crate::dataset::{Amplitudes, Run};
use crate::diagnosis::effects::{Conditions, Effect};
use nalgebra::{RowSVector, SMatrix};

/// Longest step of the midpoint rule, s.
const LONGEST_STEP: f64 = 0.0101;
/// Room for the effects' own states.
const OWN_STATES: usize = 8;
/// A pitch rate is "rest" below this share of its standard deviation.
const REST: f64 = 0.02;
/// Leak of an angle that nothing observes, 1/s.
const LEAK: f64 = 0.1;
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
}

/// Output of the model at one sample: pitch rate in rad/s and pitch angle in rad, as the sensors show them.
pub type Output = [f64; 2];

/// The model, discretised for one sample period.
pub struct PitchModel<'a> {
    plant: Plant,
    terms: &'a [Term],
    transition: StateMatrix,
    per_moment: State,
    /// Response of the state to a unit rate added to θ̇.
    per_angle_rate: State,
    /// Moment on the airframe per state, N m.
    moment_row: RowSVector<f64, 6>,
    stiffness: f64,
    damping: f64,
    step: f64,
    substeps: usize,
    sizes: Amplitudes,
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
        let substeps = (step / LONGEST_STEP).ceil().max(1.0) as usize;
        let dt = step / substeps as f64;
        let (stiffness, damping) = linear_part(terms, sizes, dt);
        let continuous = plant.state_matrix(stiffness, damping, disturbance);
        let mut block = SMatrix::<f64, 8, 8>::zeros();
        block.fixed_view_mut::<6, 6>(0, 0).copy_from(&continuous);
        block[(Q, 6)] = 1.0 / plant.inertia;
        block[(THETA, 7)] = 1.0;
        block *= dt;
        if !block.amax().is_finite() || block.amax() > 1e4 {
            return None;
        }
        let exp = block.exp();
        Some(Self {
            plant,
            terms,
            transition: exp.fixed_view::<6, 6>(0, 0).into_owned(),
            per_moment: exp.fixed_view::<6, 1>(0, 6).into_owned(),
            per_angle_rate: exp.fixed_view::<6, 1>(0, 7).into_owned(),
            moment_row: continuous.row(Q) * plant.inertia,
            stiffness,
            damping,
            step,
            substeps,
            sizes: *sizes,
        })
    }

    /// Kalman gain for the outputs that `run` has, under the noise model `disturbance`.
    pub fn gain(&self, disturbance: &Disturbance, run: &Run) -> Option<Vec<State>> {
        let mut over_sample = StateMatrix::identity();
        for _ in 0..self.substeps {
            over_sample = self.transition * over_sample;
        }
        let mut drive = State::zeros();
        drive[super::grey_box::DISTURBANCE + 1] = disturbance.intensity * (self.step / 2.0).sqrt();
        let later = over_sample * drive;
        let process = drive * drive.transpose() + later * later.transpose();
        let (rate, angle) = self.plant.measured();
        let mut channels = Vec::with_capacity(2);
        if run.rate.is_some() {
            channels.push(Channel { state: rate, variance: 1.0 });
        }
        if run.angle.is_some() {
            let noise = if run.rate.is_some() { disturbance.angle_noise } else { 1.0 };
            channels.push(Channel { state: angle, variance: noise * noise });
        } else {
            // The angle is a pure integrator that nothing observes: a slow leak keeps its variance finite.
            for i in [THETA, super::grey_box::THETA_IMU] {
                for j in 0..6 {
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
        x[THETA] = angle;
        if self.plant.mount.is_some() {
            x[super::grey_box::Q_IMU] = rate;
            x[super::grey_box::THETA_IMU] = angle;
        }
        Point { x, own: [0.0; OWN_STATES] }
    }

    /// What the log shows at `point`.
    pub fn output(&self, point: &Point) -> Output {
        let (rate, angle) = self.plant.measured();
        let mut y = [point.x[rate], point.x[angle]];
        let mut offset = 0;
        for term in self.terms {
            let states = term.effect.states();
            y = term.effect.measure(&term.values, &point.own[offset..offset + states], y);
            offset += states;
        }
        y
    }

    /// One sample further, from row `k` of `run` to row k+1. `false` when the state has diverged.
    pub fn advance(&self, point: &mut Point, run: &Run, k: usize) -> bool {
        let dt = self.step / self.substeps as f64;
        let [roll_rate, yaw_rate, roll] = run.roll_and_yaw.as_ref().map_or([0.0; 3], |rows| rows[k]);
        for i in 0..self.substeps {
            let t = run.time(k) + i as f64 * dt;
            let at = Conditions { t, dt, roll_rate, yaw_rate, roll, small_rate: REST * self.sizes.q };
            let extra: f64 = self.terms.iter().map(|term| term.effect.delay(&term.values, &at)).sum();
            let command = delayed_mean(run, t - self.plant.delay - extra - run.start, dt);
            if self.terms.is_empty() {
                point.x = self.transition * point.x + self.per_moment * (self.plant.dm_du * command);
            } else {
                self.step_with_terms(point, command, &at);
            }
        }
        point.x[Q].abs() < DIVERGED * self.sizes.q
            && point.x[THETA].abs() < DIVERGED * self.sizes.theta.max(1.0)
    }

    fn step_with_terms(&self, point: &mut Point, command: f64, at: &Conditions) {
        let mut u = command;
        let mut offset = 0;
        for term in self.terms {
            let states = term.effect.states();
            u = term.effect.actuate(&term.values, &mut point.own[offset..offset + states], u, at);
            offset += states;
        }
        let control = self.plant.dm_du * u;
        let before = point.x;
        let (moment, angle_rate) = self.nonlinear(&before, control, at);
        point.x = self.transition * before
            + self.per_moment * (control + moment)
            + self.per_angle_rate * angle_rate;
        let (corrected, corrected_rate) = self.nonlinear(&((before + point.x) * 0.5), control, at);
        point.x +=
            self.per_moment * (corrected - moment) + self.per_angle_rate * (corrected_rate - angle_rate);
        let (rate, _) = self.plant.measured();
        let mut offset = 0;
        for term in self.terms {
            let states = term.effect.states();
            let own = &mut point.own[offset..offset + states];
            term.effect.sense(&term.values, own, point.x[rate], control / self.plant.inertia, at);
            offset += states;
        }
    }

    /// Moment and rate of the angle that the effects add to the linear model at state `x`.
    fn nonlinear(&self, x: &State, control: f64, at: &Conditions) -> (f64, f64) {
        let (q, theta) = (x[Q], x[THETA]);
        let (mut moment, mut angle_rate, mut inertia) = (self.stiffness * theta + self.damping * q, 0.0, 1.0);
        for term in self.terms {
            moment += term.effect.moment(&term.values, q, theta, at);
            angle_rate += term.effect.angle_rate(&term.values, q, at);
            inertia *= term.effect.inertia(&term.values, at);
        }
        if inertia != 1.0 {
            let all = (self.moment_row * x)[0] + control + moment;
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

    /// Innovations e = y − ŷ of the predictor with `gain` over the whole of `run`; channels without a measurement give
    /// zero. `visit` sees the corrected state of every row.
    pub fn innovations(
        &self,
        run: &Run,
        gain: &[State],
        mut visit: impl FnMut(usize, &Point),
    ) -> Option<Vec<Output>> {
        let mut point = self.start(run);
        let mut innovations = Vec::with_capacity(run.len());
        for k in 0..run.len() {
            let expected = self.output(&point);
            let mut e = [0.0; 2];
            let mut column = 0;
            for (channel, signal) in [&run.rate, &run.angle].into_iter().enumerate() {
                if let Some(signal) = signal {
                    e[channel] = signal[k] - expected[channel];
                    point.x += gain[column] * e[channel];
                    column += 1;
                }
            }
            innovations.push(e);
            visit(k, &point);
            if !self.advance(&mut point, run, k) {
                return None;
            }
        }
        Some(innovations)
    }
}

/// Mean of the input over `dt` seconds from `from` (s after the run's first sample); before the run its first value.
fn delayed_mean(run: &Run, from: f64, dt: f64) -> f64 {
    let at = |index: f64| run.u[(index.max(0.0) as usize).min(run.len() - 1)];
    let begin = from / run.step;
    let length = dt / run.step;
    if !run.held {
        let middle = begin + 0.5 * length;
        let low = middle.floor();
        return at(low) + (middle - low) * (at(low + 1.0) - at(low));
    }
    // A hair's breadth forward, so that a delay of whole samples does not straddle two of them by rounding.
    let first = (begin + 1e-9).floor();
    let beyond = begin + length - (first + 1.0);
    if beyond <= 1e-9 {
        return at(first);
    }
    let share = beyond / length;
    at(first) * (1.0 - share) + at(first + 1.0) * share
}

/// Stiffness and damping (N m/rad, N m s/rad) that stand for the effects' moments in the mean, at the signals'
/// sizes: statistical linearisation (Booton, 1954) by three Gauss–Hermite nodes.
fn linear_part(terms: &[Term], sizes: &Amplitudes, dt: f64) -> (f64, f64) {
    let at = Conditions { dt, small_rate: REST * sizes.q, ..Conditions::default() };
    let moment = |q: f64, theta: f64| -> f64 {
        terms.iter().map(|term| term.effect.moment(&term.values, q, theta, &at)).sum()
    };
    let root = 3f64.sqrt();
    let slope = |plus: f64, minus: f64, size: f64| -(plus - minus) / (2.0 * root * size);
    let (dq, dtheta) = (root * sizes.q, root * sizes.theta);
    (
        slope(moment(0.0, dtheta), moment(0.0, -dtheta), sizes.theta),
        slope(moment(dq, 0.0), moment(-dq, 0.0), sizes.q),
    )
}
