//! The grey box by maximum likelihood on its free run (output error), over any number of sections together.
//!
//! ```text
//! y[k] = ŷ[k; Θ, x0_s] + o_s + e[k],    e[k] = Σ_j a_j e[k−j] + w[k],  w white
//! min over Θ, x0_s, o_s of V = 1/N Σ w[k]²        −2 log likelihood = N ln V + constant
//! ```
//!
//! | symbol | meaning | range |
//! | --- | --- | --- |
//! | Θ | ∂M/∂q, ∂M/∂u, and if free τ, and the mount's ln ω, ln ζ (`model::sampled`); I and J are always held | |
//! | x0_s, o_s | initial state and offset of section s: a joint between excitations is no transition of the model | |
//! | a | the noise's colour, an autoregression ([`Noise::Coloured`]), or none ([`Noise::White`]) | order 0 to 25 |
//! | τ | delay, any fraction of a sample | 0 to [`LONGEST_DELAY_S`] |
//!
//! Rows where the supervisor acted end a section and are left out: its feedback correlates the input with the
//! disturbance. The derivatives are exact. The colour is taken from the errors of the white fit, and again after.
//!
//! Several starts differ in the damping, the delay, and the mount's mode; the best end counts, and [`OutputErrorFit::agreeing_starts`] tells how many
//! reached it. What the data cannot tell is in [`identifiability`].
//!
//! Source: Ljung, System Identification, 2nd ed., sections 7.4 and 9.4; Jategaonkar, Flight Vehicle System
//! Identification, 2006, chapter 4.

pub(in crate::identify) mod colour;
pub mod delay_profile;
pub mod identifiability;
mod intervals;
mod rows;
mod search;

use super::fir::{Piece, common_step};
use super::hinf_match::MountRange;
use crate::error::{Error, ErrorKind};
use crate::estimate::Estimate;
use crate::model::plant::Plant;
use crate::model::sampled::Parameter;
use core::f64::consts::TAU;
use intervals::{Covariances, covariances};
use nalgebra::{DMatrix, DVector, Vector4};
use rows::Section;
use search::{At, Coordinate, Problem};

/// Largest delay, s.
pub const LONGEST_DELAY_S: f64 = 0.3;
/// Range of ∂M/∂q/I, 1/s: from much faster than any vehicle to undamped. The free run of an unstable one would diverge.
const DAMPING_RANGE: [f64; 2] = [-200.0, 0.0];
/// Rounds of colour and fit.
const ROUNDS: usize = 3;
/// Rows, about, on which starts are compared.
const COMPARED_ROWS: usize = 10_000;
/// Ends within this much of −2 log likelihood of the best agree with it.
const AGREED: f64 = 0.01;

/// What the output is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Pitch rate, rad/s.
    Rate,
    /// Pitch angle, rad.
    Angle,
}

/// What is assumed of the errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// White: plain output error. Unbiased in open loop whatever the colour, but not the most precise.
    White,
    /// Autoregressive, the order by BIC.
    Coloured,
}

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What [`Piece::y`] holds.
    pub output: Output,
    /// Whether the input is held between samples, or interpolated.
    pub held_input: bool,
    /// Whether τ is estimated.
    pub free_delay: bool,
    /// Range of the mount if it is estimated; J is held in any case.
    pub mount: Option<MountRange>,
    /// The errors.
    pub noise: Noise,
    /// Also use rows where the supervisor acted.
    pub use_supervised: bool,
    /// Whether to start from several points.
    pub several_starts: bool,
}

impl Default for Options {
    /// Pitch rate, held input, free delay, held mount, white errors, without supervised rows, several starts.
    fn default() -> Self {
        Self {
            output: Output::Rate,
            held_input: true,
            free_delay: true,
            mount: None,
            noise: Noise::White,
            use_supervised: false,
            several_starts: true,
        }
    }
}

/// A fitted grey box.
#[derive(Clone, Debug)]
pub struct OutputErrorFit {
    /// The plant.
    pub plant: Plant,
    /// Free parameters with 95 % intervals: `dM_dq`, `dM_du`, `delay`, `mount_mode` (Hz), `mount_zeta`.
    pub parameters: Vec<Estimate>,
    /// Standard deviations of `parameters`, as the intervals have them; infinite on a bound.
    pub deviations: Vec<f64>,
    /// The Cramér–Rao bounds of the same: what no unbiased method can fall below if the errors are as assumed.
    pub cramer_rao: Vec<f64>,
    /// Correlation of the estimates.
    pub correlation: DMatrix<f64>,
    /// Whether the intervals are corrected for errors that are not white (after the noise model).
    pub corrected: bool,
    /// Names of parameters that stand on a bound: they are not identified.
    pub on_bound: Vec<String>,
    /// a_1, a_2, …; empty for white errors.
    pub autoregression: Vec<f64>,
    /// Standard deviation of w, unit of the output.
    pub noise: f64,
    /// N ln V.
    pub deviance: f64,
    /// N.
    pub rows: usize,
    /// Whether the best search settled.
    pub converged: bool,
    /// Starts that ended at the best minimum, of those tried.
    pub agreeing_starts: [usize; 2],
}

/// Fits the grey box `start` to `pieces`.
///
/// # Errors
/// No piece, pieces too short, values that are not finite, an input that does not move the output.
pub fn fit(pieces: &[Piece], start: &Plant, options: &Options) -> Result<OutputErrorFit, Error> {
    let problem = problem(pieces, start, options)?;
    let (at, converged, ar, agreeing) = best(&problem, options).ok_or_else(no_fit)?;
    report(&problem, &at, converged, ar, agreeing)
}

fn no_fit() -> Error {
    let found = "the grey box has no finite free run on these data";
    Error::new(ErrorKind::Numerical, found, "check the units of the columns and the values of the model file")
}

fn problem<'a>(pieces: &[Piece<'a>], start: &Plant, options: &Options) -> Result<Problem<'a>, Error> {
    let step = common_step(pieces)?;
    let sections: Vec<Section<'a>> =
        pieces.iter().flat_map(|piece| sections(piece, options.use_supervised)).collect();
    let rows: usize = sections.iter().map(|s| s.rows.len()).sum();
    if rows < 100 {
        let found = format!("{rows} rows without supervision, in stretches of 40 or more");
        return Err(Error::new(ErrorKind::TooShort, found, "give longer sections").expecting("at least 100"));
    }
    let finite = |s: &Section| s.u.iter().chain(&s.y[s.rows.clone()]).all(|x| x.is_finite());
    let numbers = [start.inertia, start.dm_dq, start.dm_du, start.delay];
    if !sections.iter().all(finite) || !numbers.iter().all(|x| x.is_finite()) || start.inertia <= 0.0 {
        let found =
            "an input, an output or a start that is no finite number, or an inertia that is not positive";
        return Err(Error::new(ErrorKind::Value, found, "correct the rows, or the model file"));
    }
    let mut coordinates = vec![
        Coordinate { parameter: Parameter::DmDq, bounds: DAMPING_RANGE.map(|rate| rate * start.inertia) },
        Coordinate { parameter: Parameter::DmDu, bounds: [f64::NEG_INFINITY, f64::INFINITY] },
    ];
    if options.free_delay {
        coordinates.push(Coordinate { parameter: Parameter::Delay, bounds: [0.0, LONGEST_DELAY_S] });
    }
    if let Some(range) = options.mount.filter(|_| start.mount.is_some()) {
        let mode = range.mode_hz.map(|hz| (TAU * hz).ln());
        coordinates.push(Coordinate { parameter: Parameter::MountMode, bounds: mode });
        coordinates.push(Coordinate {
            parameter: Parameter::MountDamping,
            bounds: range.damping_ratio.map(f64::ln),
        });
    }
    let angle = options.output == Output::Angle;
    Ok(Problem { sections, start: *start, step, held_input: options.held_input, angle, coordinates })
}

/// The stretches of a piece that the supervisor left alone.
fn sections<'a>(piece: &Piece<'a>, use_supervised: bool) -> Vec<Section<'a>> {
    const SHORTEST: usize = 40;
    let end = piece.rows.end.min(piece.u.len()).min(piece.y.len()).min(piece.supervised.len());
    let (mut found, mut from) = (Vec::new(), piece.rows.start);
    while from < end {
        let to = (from..end).find(|&k| piece.supervised[k] && !use_supervised).unwrap_or(end);
        if to - from >= SHORTEST {
            found.push(Section { u: piece.u, y: piece.y, rows: from..to });
        }
        from = to + 1;
    }
    found
}

/// The best end of all starts, whether it settled, its noise model, and how many starts reached it. On long records the
/// starts are compared on their first part, and the best goes on with all.
fn best(problem: &Problem, options: &Options) -> Option<(At, bool, Vec<f64>, [usize; 2])> {
    let rest = vec![Vector4::zeros(); problem.sections.len()];
    let first = problem.theta(&problem.start);
    let starts = if options.several_starts { starts(problem, &first) } else { vec![first] };
    let short = if starts.len() > 1 { problem.shortened(COMPARED_ROWS) } else { None };
    let compared = short.as_ref().unwrap_or(problem);
    let mut ends: Vec<(At, bool)> =
        starts.iter().filter_map(|theta| compared.minimise(theta, &rest, &[])).collect();
    ends.sort_by(|a, b| a.0.squares.total_cmp(&b.0.squares));
    let deviance = |at: &At| at.rows as f64 * at.squares.ln();
    let least = deviance(&ends.first()?.0);
    let agreeing = ends.iter().filter(|(at, _)| deviance(at) <= least + AGREED).count();
    let (mut at, mut converged) = ends.swap_remove(0);
    if short.is_some() {
        (at, converged) = problem.minimise(&at.theta, &at.x0, &[])?;
    }
    let mut ar = Vec::new();
    if options.noise == Noise::Coloured {
        for _ in 0..ROUNDS {
            let found = colour::autoregression(&errors(problem, &at));
            if found.is_empty() && ar.is_empty() {
                break;
            }
            ar = found;
            (at, converged) = problem.minimise(&at.theta, &at.x0, &ar)?;
        }
    }
    Some((at, converged, ar, [agreeing, starts.len()]))
}

/// Points to start from: other delays, and other modes of the mount.
fn starts(problem: &Problem, first: &[f64]) -> Vec<Vec<f64>> {
    let mut all = vec![first.to_vec()];
    for (i, c) in problem.coordinates.iter().enumerate() {
        let others: &[f64] = match c.parameter {
            Parameter::DmDq => &[-0.3, -3.0, -20.0],
            Parameter::Delay => &[0.0, 0.04, 0.1],
            Parameter::MountMode => &[0.1, 0.9],
            _ => &[],
        };
        for other in others {
            let mut theta = first.to_vec();
            theta[i] = match c.parameter {
                Parameter::Delay => *other,
                Parameter::DmDq => other * problem.start.inertia,
                _ => c.bounds[0] + other * (c.bounds[1] - c.bounds[0]),
            };
            all.push(theta);
        }
    }
    all
}

/// Output errors by section, not whitened.
fn errors(problem: &Problem, at: &At) -> Vec<Vec<f64>> {
    let model = problem.sensitivities(&at.theta, &[]);
    let width = model.width();
    let of = |((section, x0), offset): ((&Section, &Vector4<f64>), &f64)| {
        let mut errors = Vec::with_capacity(section.rows.len());
        model.rows(section, x0, &[], &mut |rows| {
            errors.extend(rows.chunks_exact(width).map(|row| row[width - 1] - offset));
        });
        errors
    };
    problem.sections.iter().zip(&at.x0).zip(&at.offsets).map(of).collect()
}

fn report(
    problem: &Problem,
    at: &At,
    converged: bool,
    autoregression: Vec<f64>,
    agreeing_starts: [usize; 2],
) -> Result<OutputErrorFit, Error> {
    let on_bound = |i: &usize| problem.on_bound(&at.theta, *i);
    let free: Vec<usize> = (0..at.theta.len()).filter(|i| !on_bound(i)).collect();
    if (0..at.theta.len()).any(|i| at.hessian[(i, i)] <= 0.0) {
        let found = "the input does not show all parameters of the grey box";
        let advice = "use sections in which the input switches, or hold the mount";
        return Err(Error::new(ErrorKind::Numerical, found, advice));
    }
    // parameters that only show together have no interval of their own
    let covariances = covariances(problem, at, &free, &autoregression).unwrap_or_else(|| {
        let unknown = DMatrix::from_diagonal_element(free.len(), free.len(), f64::INFINITY);
        Covariances { bound: unknown.clone(), used: unknown, corrected: false }
    });
    let own = |m: &DMatrix<f64>, i: usize| {
        let place = free.iter().position(|&f| f == i);
        place.map_or(f64::INFINITY, |a| m[(a, a)].max(0.0).sqrt() * stretch(problem, at, i))
    };
    let count = at.theta.len();
    let deviations: Vec<f64> = (0..count).map(|i| own(&covariances.used, i)).collect();
    let cramer_rao = (0..count).map(|i| own(&covariances.bound, i)).collect();
    let parameters: Vec<Estimate> = (0..count).map(|i| estimate(problem, at, i, deviations[i])).collect();
    let scale = DVector::from_fn(free.len(), |a, _| covariances.used[(a, a)].max(f64::MIN_POSITIVE).sqrt());
    let mut correlation = DMatrix::identity(count, count);
    for (a, &i) in free.iter().enumerate() {
        for (b, &j) in free.iter().enumerate() {
            correlation[(i, j)] = if a == b { 1.0 } else { covariances.used[(a, b)] / (scale[a] * scale[b]) };
        }
    }
    let on_bound = (0..count).filter(on_bound).map(|i| parameters[i].name.clone()).collect();
    let variance = at.squares / at.rows as f64;
    Ok(OutputErrorFit {
        plant: problem.plant(&at.theta),
        parameters,
        deviations,
        cramer_rao,
        correlation,
        corrected: covariances.corrected,
        on_bound,
        autoregression,
        noise: variance.sqrt(),
        deviance: at.rows as f64 * variance.ln(),
        rows: at.rows,
        converged,
        agreeing_starts,
    })
}

/// d value / d coordinate: the mount's parameters are searched on the logarithm.
fn stretch(problem: &Problem, at: &At, i: usize) -> f64 {
    match problem.coordinates[i].parameter {
        Parameter::MountMode => at.theta[i].exp() / TAU,
        Parameter::MountDamping | Parameter::MountInertia => at.theta[i].exp(),
        Parameter::DmDq | Parameter::DmDu | Parameter::Delay => 1.0,
    }
}

fn estimate(problem: &Problem, at: &At, i: usize, deviation: f64) -> Estimate {
    let [low, high] = problem.coordinates[i].bounds;
    let (name, unit) = match problem.coordinates[i].parameter {
        Parameter::DmDq => ("dM_dq", "N m s/rad"),
        Parameter::DmDu => ("dM_du", "N m/rad"),
        Parameter::Delay => ("delay", "s"),
        Parameter::MountMode => {
            return Estimate::new(
                "mount_mode",
                "Hz",
                at.theta[i].exp() / TAU,
                deviation,
                [low, high].map(|l| l.exp() / TAU),
            );
        }
        Parameter::MountDamping => {
            return Estimate::new("mount_zeta", "1", at.theta[i].exp(), deviation, [low, high].map(f64::exp));
        }
        Parameter::MountInertia => ("mount_J", "kg m²"),
    };
    Estimate::new(name, unit, at.theta[i], deviation, [low, high])
}

/// Simulates rows of a run from the initial state that fits them best, with the offset that does, and answers the
/// free run with the offset taken out; `None` where it overflows.
pub fn simulate(piece: &Piece, plant: &Plant, options: &Options) -> Option<Vec<f64>> {
    let angle = options.output == Output::Angle;
    let section = Section { u: piece.u, y: piece.y, rows: piece.rows.clone() };
    let problem = Problem {
        sections: vec![section],
        start: *plant,
        step: piece.step,
        held_input: options.held_input,
        angle,
        coordinates: Vec::new(),
    };
    let at = problem.at(&[], &[Vector4::zeros()], &[])?;
    let errors = errors(&problem, &at).pop()?;
    let simulated: Vec<f64> =
        piece.y[piece.rows.clone()].iter().zip(&errors).map(|(y, e)| y - e - at.offsets[0]).collect();
    simulated.iter().all(|y| y.is_finite()).then_some(simulated)
}
