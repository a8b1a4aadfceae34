//! Effects: physics that a pitch model may leave out, as hooks into the simulation of
//! [`PitchModel`](super::pitch::PitchModel). Every hook has a neutral default, so that an effect says only what it changes.
//! Symbols as in the crate's documentation: u_c is the command after the delay, u_a what the blades do, M the pitch moment.

use super::noise::Third;
use super::pitch::Output;
use super::plant::Plant;
pub use crate::dataset::Amplitudes;
use crate::dataset::Dataset;
use crate::model::baseline::Baseline;

/// Where in the loop an effect sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Locus {
    /// Between the command and the moment of the rotors.
    Actuator,
    /// A moment on the airframe, or its inertia.
    PitchMoment,
    /// Between the motion and the logged measurement.
    Sensor,
    /// Time stamps and transport delays.
    Timing,
    /// A moment that the input does not cause.
    Environment,
}

/// Effects that the data often cannot separate by nature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Lags and delays: they turn the phase alike.
    Phase,
    /// What takes small signals away: dead bands, play, dry friction.
    SmallSignals,
    /// What stiffens at large angles.
    LargeAngles,
    /// Lightly damped modes that the gyro sees.
    Resonance,
}

/// How a parameter is searched: on its own scale, or on the logarithm of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Linear, with the step that counts as "one unit".
    Linear(f64),
    /// Logarithmic: positive parameters that range over decades.
    Log,
}

/// A parameter of an effect, within its physical bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in the JSON answer and in model files.
    pub name: &'static str,
    /// Unit of the vehicle's own recordings (rad, N m, s).
    pub unit: &'static str,
    /// Lowest value physics allows.
    pub lower: f64,
    /// Highest value worth searching.
    pub upper: f64,
    /// How it is searched.
    pub scale: Scale,
}

/// What an effect may depend on besides the state: the conditions of one simulation step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Conditions {
    /// Time since the start of the recording, s.
    pub t: f64,
    /// Length of the step, s.
    pub dt: f64,
    /// Roll rate p, rad/s; zero where it was not measured.
    pub roll_rate: f64,
    /// Yaw rate r, rad/s.
    pub yaw_rate: f64,
    /// A pitch rate that counts as rest, rad/s: where a sign change is smoothed.
    pub small_rate: f64,
    /// The delayed command u_c, mean over the step.
    pub command: f64,
    /// The moment that the command has the actuators give, ∂M/∂u u_a, mean over the step, N m.
    pub control: f64,
    /// By how much the blades' angle, u_a before what acts on the thrust, changes over the step; zero where no effect is impulsive.
    pub blades_change: f64,
    /// Command of the roll axis, in its unit; zero where it was not logged.
    pub roll_command: f64,
    /// Collective thrust relative to its mean, (T − T̄)/T̄; zero where it was not logged.
    pub thrust: f64,
    /// Supply voltage relative to its mean, (V − V̄)/V̄; zero where it was not logged.
    pub voltage: f64,
    /// Pitch inertia of the airframe, kg m².
    pub inertia: f64,
    /// Sizes of the signals.
    pub sizes: Amplitudes,
}

/// What the model before leaves: its estimate of the moment that it lacks, over the longest run.
#[derive(Clone, Debug, Default)]
pub struct ResidualMoment {
    /// Time of the first value since the start of its recording, s.
    pub start: f64,
    /// Sample period, s.
    pub step: f64,
    /// The moment, N m.
    pub moment: Vec<f64>,
    /// The pitch angle, rad.
    pub angle: Vec<f64>,
}

/// A signal that a term is drawn over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Pitch rate q, rad/s.
    Rate,
    /// Pitch angle θ, rad.
    Angle,
    /// The delayed command u, its unit.
    Command,
    /// Time, s.
    Time,
    /// Roll rate, rad/s.
    RollRate,
    /// Command of the roll axis, its unit.
    RollCommand,
    /// Collective thrust relative to its mean.
    Thrust,
    /// Supply voltage relative to its mean.
    Voltage,
}

/// What a term is drawn as, beside what the data say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// The moment over a signal; over the command, the moment beside ∂M/∂u·u.
    Moment(Signal),
    /// The moment over the angle, apart for the angle rising and falling.
    Loop,
    /// ∂M/∂u over a signal.
    Gain(Signal),
    /// ∂M/∂q over a signal.
    Damping(Signal),
    /// The moment after a step of the command, per unit of the command, over the time since.
    StepResponse,
    /// What the measured rate has beside the rate, over a signal.
    Measured(Signal),
}

/// What an effect is called, and how it is told to a person.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Name in the JSON answer and in model files.
    pub id: &'static str,
    /// Where it sits.
    pub locus: Locus,
    /// What it is, as the end of the sentence "what is missing is that ...".
    pub sentence: &'static str,
    /// The term it adds, in our symbols.
    pub equation: &'static str,
    /// The variable that the residual depends on most when the effect is left out.
    pub variable: &'static str,
    /// When it shows, in words.
    pub condition: &'static str,
}

/// One piece of physics that the baseline leaves out.
pub trait Effect: Sync {
    /// What it is called and how it is told.
    fn about(&self) -> About;
    /// Where its equation comes from: author and year.
    fn source(&self) -> Option<&'static str> {
        None
    }
    /// What it is drawn as; `None` where no picture shows it.
    fn picture(&self) -> Option<Picture> {
        None
    }
    /// Its parameters with bounds that suit the signals at hand.
    fn parameters(&self, _data: &Amplitudes) -> Vec<Parameter>;
    /// Where the search for the parameters starts, one or more vectors.
    fn starts(&self, _data: &Amplitudes) -> Vec<Vec<f64>>;
    /// The same where what the model before leaves shows where to begin: a frequency, a moment in time.
    fn starts_from(&self, data: &Amplitudes, _left: &ResidualMoment) -> Vec<Vec<f64>> {
        self.starts(data)
    }
    /// Whether it can be asked for at all with this baseline and these signals.
    fn applies(&self, _baseline: &Baseline, _data: &Dataset) -> bool {
        true
    }
    /// Index of the parameter that is a moment in time from which on the effect acts: the likelihood has many minima over
    /// it, and kinks.
    fn begins_at(&self) -> Option<usize> {
        None
    }
    /// Index of a parameter that is no unknown: it says nothing at the values `p`, which lie beyond what these data show, or
    /// is read off the log.
    fn beyond_data(&self, _p: &[f64], _data: &Amplitudes) -> Option<usize> {
        None
    }
    /// Index of the parameter that says where the effect acts: at zero it acts as well as anywhere.
    fn acts_at(&self) -> Option<usize> {
        None
    }
    /// Index of the parameter that is an angle: it counts modulo 2π.
    fn turns(&self) -> Option<usize> {
        None
    }
    /// Frequency in Hz and damping ratio at which it rings with the parameters `p`.
    fn rings(&self, _p: &[f64]) -> Option<[f64; 2]> {
        None
    }
    /// Where the search starts in the place of another effect that rings at `f_hz` with the damping ratio `zeta`.
    fn start_ringing(&self, _f_hz: f64, _zeta: f64) -> Option<Vec<f64>> {
        None
    }
    /// The one frequency at which it acts, Hz.
    fn acts_at_frequency(&self, _p: &[f64]) -> Option<f64> {
        None
    }
    /// Index of the parameter that is a moment in time up to which the effect acts.
    fn ends_at(&self) -> Option<usize> {
        None
    }
    /// The class of effects that one excitation hardly separates from it.
    fn class(&self) -> Option<Class> {
        None
    }
    /// Whether `other` with the values `p` beside it is a facet of this very effect, and no second one.
    fn accounts_for(&self, _other: &dyn Effect, _p: &[f64], _data: &Amplitudes) -> bool {
        false
    }
    /// Whether it holds `other` as its special case: where both explain the data alike, that is the simpler name.
    fn generalises(&self, _other: &dyn Effect) -> bool {
        false
    }
    /// Ids of effects that together say the same as it does, or all but the same, and are more usual.
    fn restates(&self) -> &'static [&'static str] {
        &[]
    }
    /// Whether it belongs to the background, which every model may have: then it is no finding.
    fn is_background(&self) -> bool {
        false
    }
    /// Whether it acts on the thrust that the blades make of their angle, and so behind all that acts on the angle.
    fn of_thrust(&self) -> bool {
        false
    }
    /// Whether the collective thrust, which is a command too, comes through it as well.
    fn carries_thrust(&self) -> bool {
        false
    }
    /// Whether it may hold the vehicle aside on average: what the blades make of a command that goes as much up as down, and what
    /// sensors make of the motion, is nothing on average, unless it tells one direction from the other.
    fn moves_the_mean(&self) -> bool {
        matches!(self.about().locus, Locus::PitchMoment | Locus::Environment)
    }
    /// Number of states of its own (0, 1 or 2).
    fn states(&self) -> usize {
        0
    }
    /// Whether it acts on the motion, or is moved by it, within a sample (by `impulse`, `moment`, `inertia`, `follow`,
    /// `sense`): then samples are cut into substeps. One that does not acts on what drives the motion (by `delay`,
    /// `actuate`, `forcing`), which the motion has no part in; no effect does both.
    fn within_sample(&self) -> bool {
        false
    }
    /// Whether it gives the airframe an impulse where the blades move: else it is not asked for one.
    fn is_impulsive(&self) -> bool {
        false
    }
    /// Changes parameters of the plant.
    fn plant(&self, _p: &[f64], _plant: &mut Plant) {}
    /// Time constant of a first-order filter between the rate at the IMU and its measurement, s.
    fn gyro_lag(&self, _p: &[f64]) -> Option<f64> {
        None
    }
    /// Time constant of a first-order filter between the angle at the IMU and its measurement, s. The model has room for one
    /// filter behind the IMU: of the rate or of the angle.
    fn angle_lag(&self, _p: &[f64]) -> Option<f64> {
        None
    }
    /// A third pole for the noise model.
    fn noise(&self, _p: &[f64]) -> Option<Third> {
        None
    }
    /// By how much the states q, x₁ and x₂ are corrected by what is new in the command.
    fn corrects(&self, _p: &[f64]) -> Option<[f64; 3]> {
        None
    }
    /// Delay of the input beyond the plant's, s.
    fn delay(&self, _p: &[f64], _at: &Conditions) -> f64 {
        0.0
    }
    /// u_c → u_a, the mean over one step, with its own states `s`.
    fn actuate(&self, _p: &[f64], _s: &mut [f64], u: f64, _at: &Conditions) -> f64 {
        u
    }
    /// u_c → u_a at one moment, at which its own states are `s`: the first of them, where it has any.
    fn blades(&self, p: &[f64], s: &[f64], u: f64, at: &Conditions) -> f64 {
        s.first().copied().unwrap_or_else(|| self.actuate(p, &mut [], u, at))
    }
    /// Moment that the motion has no part in, N m, the mean over one step.
    fn forcing(&self, _p: &[f64], _at: &Conditions) -> f64 {
        0.0
    }
    /// Angular impulse on the airframe, N m s, that the change of the blades' angle within the step gives.
    fn impulse(&self, _p: &[f64], _at: &Conditions) -> f64 {
        0.0
    }
    /// Moment added to the airframe, N m, at pitch rate `q` and angle `theta`, with its own states `s`.
    fn moment(&self, _p: &[f64], _s: &[f64], _q: f64, _theta: f64, _at: &Conditions) -> f64 {
        0.0
    }
    /// Largest moment, N m, with which dry friction opposes a motion at pitch rate `q`, or holds a body at rest that would move
    /// in that direction. The model brings it to bear in place of `moment`, which tells the same with its step smoothed.
    fn friction(&self, _p: &[f64], _q: f64) -> Option<f64> {
        None
    }
    /// Factor on the pitch inertia.
    fn inertia(&self, _p: &[f64], _at: &Conditions) -> f64 {
        1.0
    }
    /// Moves its own states over one step, with the mean over it of the airframe's pitch rate `q` in rad/s and angle `theta`
    /// in rad.
    fn follow(&self, _p: &[f64], _s: &mut [f64], _q: f64, _theta: f64, _at: &Conditions) {}
    /// Moves its own states over one step, with the pitch rate `q` in rad/s and angle `theta` in rad at the IMU and the
    /// acceleration `control` that the control moment gives the airframe in rad/s².
    fn sense(&self, _p: &[f64], _s: &mut [f64], _q: f64, _theta: f64, _control: f64, _at: &Conditions) {}
    /// What the sensors make of the rate and angle `y` at the IMU, while the airframe rolls at `roll_rate` in rad/s.
    fn measure(&self, _p: &[f64], _s: &[f64], y: Output, _roll_rate: f64) -> Output {
        y
    }
    /// What the log can show of the sensors' `y`; after all that the sensors make.
    fn limit(&self, _p: &[f64], y: Output) -> Output {
        y
    }
}

impl dyn Effect + '_ {
    /// Indices of the parameters that are moments in time.
    pub fn moments(&self) -> impl Iterator<Item = usize> + use<> {
        self.begins_at().into_iter().chain(self.ends_at())
    }
}
