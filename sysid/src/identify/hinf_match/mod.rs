//! H∞ model matching: the grey box whose weighted response is nearest to an identified model's.
//!
//! ```text
//! min over Θ of sup_ω |G_W(jω)| |G_ns(jω) − G_s(jω; Θ)|
//! G_s(s) = ∂M/∂u (χ s + κ) / [(Iyy s − ∂M/∂q)(s² + χ s + κ) + J s (χ s + κ)],   κ = k/J,  χ = c/J
//! |G_W(jω)|² = 1 / (1 + (ω/ω_c)^2N)
//! ```
//!
//! | symbol | meaning | range |
//! | --- | --- | --- |
//! | G_ns | identified model, its delay removed | stable |
//! | G_s | grey box (Riccardi, Panizza, Lovera, ERF 2014, eq. 10) from u to the measured rate; the pole of its four-state form at s = 0 is unobservable and left out. Without a mount: ∂M/∂u / (Iyy s − ∂M/∂q) | |
//! | N, ω_c | order and cutoff of the Butterworth weight | 1 to 25, 3 to 60 rad/s |
//! | Θ | ln(−∂M/∂q), ∂M/∂u, and if not held ln √κ, ln χ/(2√κ) within bounds; J is always held | |
//!
//! The delay is removed before and put back after: the grey box gets that of the identified model.
//!
//! The supremum is exchanged for a maximum over a finite set of frequencies. Each finite problem is solved by
//! sequential quadratic programming over its peaks, with the inverse Hessian of the Lagrangian by damped
//! Broyden–Fletcher–Goldfarb–Shanno steps; then the exact norm (`hinf_norm`) is taken, its peak joins the set, and so on
//! until the exact norm of the error is that of the finite problem. Starts: a straight-line fit of
//! (jω Iyy) G_ns = ∂M/∂u + ∂M/∂q G_ns, and multiples of it.
//!
//! Above the cutoff the weight leaves the fit free: a lower norm can simulate worse, and a free mount often ends on its
//! bounds.
//!
//! Source: Riccardi, Panizza, Lovera, ERF 2014, section 5; exchange: Polak, Optimization, Springer 1997, section 3.5;
//! quadratic programme: Han, Variable metric methods for minimizing a class of nondifferentiable functions,
//! Mathematical Programming 20, 1981.

mod weighted_error;

pub use weighted_error::grey_box_response;

use super::butterworth::Butterworth;
use super::continuous::ContinuousStateSpace;
use super::hinf_norm::HinfNorm;
use crate::error::{Error, ErrorKind};
use crate::model::plant::Plant;
use core::f64::consts::TAU;
use weighted_error::{Matching, Row, peaks};

/// Frequencies of the finite problem at first.
const FREQUENCIES: usize = 150;
/// Frequencies of the certificate.
const DENSE: usize = 1500;
/// Exchanges at most.
const MOST_EXCHANGES: usize = 12;
/// Relative distance between the exact norm and the finite problem's at which the exchange ends.
const AGREED: f64 = 1e-6;
/// Weighted errors below this share of the weighted response are rounding.
const NOTHING: f64 = 1e-9;
/// Starts: multiples of the straight-line fit, and where in its range (0 to 1) a free mount begins.
const STARTS: [(f64, f64); 5] = [(1.0, 0.5), (0.3, 0.5), (3.0, 0.5), (1.0, 0.1), (1.0, 0.9)];

/// Range that the mount may take; J is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountRange {
    /// Undamped frequency √κ/2π, Hz.
    pub mode_hz: [f64; 2],
    /// Damping ratio χ/(2√κ).
    pub damping_ratio: [f64; 2],
}

/// A matched grey box.
#[derive(Clone, Debug, PartialEq)]
pub struct HinfMatch {
    /// The grey box, with the identified model's delay.
    pub plant: Plant,
    /// Exact norm of the weighted error, rad/s per unit of the input, and the frequency of its peak.
    pub norm: HinfNorm,
    /// Largest weighted error over a dense grid of frequencies: what the norm is checked by.
    pub dense_grid: f64,
    /// The norm relative to that of the weighted identified model.
    pub relative: f64,
    /// Frequencies, rad/s, at which the weighted error is within 0.1 % of its largest: what holds the optimum.
    pub active: Vec<f64>,
    /// Starts that ended within 0.1 % of the optimum, of those tried.
    pub agreeing_starts: [usize; 2],
    /// Whether a free mount ended on a bound; it is then not identified.
    pub mount_on_bound: bool,
}

/// Matches `start` to `identified`: ∂M/∂q and ∂M/∂u are found, whatever `start` has; Iyy and J are held, and so is the
/// mount unless `mount` gives it a range.
///
/// # Errors
/// Options out of range, an unstable model, a model of another shape than one input and output, a response that no
/// damped vehicle has.
pub fn hinf_match(
    identified: &ContinuousStateSpace,
    start: &Plant,
    weight: &Butterworth,
    mount: Option<&MountRange>,
) -> Result<HinfMatch, Error> {
    check(identified, start, weight, mount)?;
    let mut matching = Matching { identified, held: *start, weight, free_mount: mount.is_some(), dm_du: 1.0 };
    let fitted = matching.straight_line()?;
    matching.dm_du = fitted[1];
    let bounds = bounds(mount, fitted[0]);
    let mut table = matching.table(&frequencies(start, weight, identified)?);
    let scale = table.iter().map(|row| row.weight * row.response.norm()).fold(0.0, f64::max);
    let mut ends: Vec<(f64, Vec<f64>)> = Vec::new();
    let starts = if matching.free_mount { &STARTS[..] } else { &STARTS[..3] };
    for (factor, middle) in starts {
        let mut theta = vec![fitted[0] + factor.ln(), *factor];
        theta.extend(bounds[2..].iter().map(|[low, high]| low + middle * (high - low)));
        ends.push(matching.finite(&table, &bounds, &theta));
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let agreeing = ends.iter().filter(|end| end.0 <= 1.001 * ends[0].0 + NOTHING * scale).count();
    let tried = ends.len();
    let (_, mut theta) = ends.swap_remove(0);
    let mut norm = None;
    for _ in 0..MOST_EXCHANGES {
        theta = matching.refine(&mut table, &bounds, &theta);
        let (value, hints) = peaks(&matching, &table, &theta);
        let exact = matching.exact(&theta, &hints)?;
        norm = Some(exact);
        if exact.value <= value * (1.0 + AGREED) + NOTHING * scale {
            break;
        }
        insert(&mut table, matching.table(&[exact.omega]));
    }
    let norm = norm.map_or_else(|| matching.exact(&theta, &[]), Ok)?;
    Ok(matching.report(&theta, norm, scale, &bounds, [agreeing, tried]))
}

/// Adds `rows`, in the order of frequency.
fn insert(table: &mut Vec<Row>, rows: Vec<Row>) {
    table.extend(rows);
    table.sort_by(|a, b| a.omega.total_cmp(&b.omega));
    table.dedup_by(|a, b| a.omega == b.omega);
}

fn check(
    identified: &ContinuousStateSpace,
    start: &Plant,
    weight: &Butterworth,
    mount: Option<&MountRange>,
) -> Result<(), Error> {
    let refuse = |found: String, expected: &str, advice: &str| {
        Err(Error::new(ErrorKind::Options, found, advice).expecting(expected))
    };
    if !(1..=25).contains(&weight.order) || !(3.0..=60.0).contains(&weight.cutoff) {
        let found = format!("a weight of order {} with its cutoff at {} rad/s", weight.order, weight.cutoff);
        return refuse(
            found,
            "order 1 to 25, cutoff 3 to 60 rad/s",
            "order 15 at 7 rad/s suits excitation of 3 to 6 rad/s",
        );
    }
    if identified.d().len() != 1 {
        let found =
            format!("a model with {} inputs and {} outputs", identified.b().ncols(), identified.c().nrows());
        return refuse(found, "one input, one output", "match the response from the input to the pitch rate");
    }
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let sound =
        start.mount.is_none_or(|m| positive(m.stiffness) && positive(m.damping) && positive(m.inertia));
    if !positive(start.inertia) || !sound {
        let found = format!("inertia {} kg m², mount {:?}", start.inertia, start.mount);
        return refuse(found, "positive values", "correct the values of the model file");
    }
    let Some(range) = mount else { return Ok(()) };
    let rising = |[low, high]: [f64; 2]| positive(low) && positive(high) && low < high;
    if start.mount.is_none() || !rising(range.mode_hz) || !rising(range.damping_ratio) {
        let found = format!("{range:?} for mount {:?}", start.mount);
        return refuse(
            found,
            "a mount, and rising positive ranges",
            "give the model file a mount, or hold it",
        );
    }
    Ok(())
}

fn bounds(mount: Option<&MountRange>, damping: f64) -> Vec<[f64; 2]> {
    let mut bounds = vec![[damping - 7.0, damping + 7.0], [-100.0, 100.0]];
    if let Some(range) = mount {
        bounds.push(range.mode_hz.map(|hz| (TAU * hz).ln()));
        bounds.push(range.damping_ratio.map(f64::ln));
    }
    bounds
}

/// Zero, and a logarithmic grid that covers the weight, the mount and the identified poles.
fn frequencies(
    start: &Plant,
    weight: &Butterworth,
    identified: &ContinuousStateSpace,
) -> Result<Vec<f64>, Error> {
    // where the weight has fallen to 1e-6 nothing is left to match
    let reach = weight.cutoff * 1e6_f64.powf(1.0 / weight.order as f64).min(1e3);
    let mode = start.mount.map(|mount| (mount.stiffness / mount.inertia).sqrt());
    let own: Vec<f64> = identified.poles()?.iter().map(|pole| pole.norm()).chain(mode).collect();
    let (low, high) = (1e-2 * weight.cutoff, reach);
    let grid = (0..FREQUENCIES).map(|k| low * (high / low).powf(k as f64 / (FREQUENCIES - 1) as f64));
    let mut all: Vec<f64> =
        [0.0].into_iter().chain(own.into_iter().filter(|omega| *omega < high)).chain(grid).collect();
    all.sort_by(f64::total_cmp);
    Ok(all)
}
