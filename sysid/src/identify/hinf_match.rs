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

use super::butterworth::Butterworth;
use super::continuous::ContinuousStateSpace;
use super::hinf_norm::{HinfNorm, hinf_norm};
use super::minimax::{Curve, minimise};
use crate::error::{Error, ErrorKind};
use crate::model::grey_box::{Mount, Plant};
use core::f64::consts::TAU;
use nalgebra::{Complex, DMatrix};

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

/// A frequency with what does not depend on Θ there.
#[derive(Clone, Copy)]
struct Row {
    omega: f64,
    weight: f64,
    response: Complex<f64>,
}

struct Matching<'a> {
    identified: &'a ContinuousStateSpace,
    held: Plant,
    weight: &'a Butterworth,
    free_mount: bool,
    /// Unit of Θ's second entry, N m per unit of the input.
    dm_du: f64,
}

impl Matching<'_> {
    fn table(&self, frequencies: &[f64]) -> Vec<Row> {
        let row = |omega: &f64| {
            let response = self.identified.response_without_delay(*omega)?[0];
            Some(Row { omega: *omega, weight: self.weight.gain(*omega), response })
        };
        frequencies.iter().filter_map(row).collect()
    }

    /// ln(−∂M/∂q) and ∂M/∂u of (jω Iyy) G = ∂M/∂u + ∂M/∂q G by weighted least squares below the cutoff.
    fn straight_line(&self) -> Result<[f64; 2], Error> {
        let omegas: Vec<f64> = (1..=40).map(|k| self.weight.cutoff * f64::from(k) / 40.0).collect();
        let (mut gram, mut cross) = ([[0.0; 2]; 2], [0.0; 2]);
        for row in self.table(&omegas) {
            let target = Complex::new(0.0, row.omega * self.held.inertia) * row.response;
            // near a pole the equation error is multiplied by it: divide by its size
            let share = row.weight / (1.0 + row.omega / self.weight.cutoff);
            for (regressor, target) in
                [([1.0, row.response.re], target.re), ([0.0, row.response.im], target.im)]
            {
                for i in 0..2 {
                    cross[i] += share * regressor[i] * target;
                    for j in 0..2 {
                        gram[i][j] += share * regressor[i] * regressor[j];
                    }
                }
            }
        }
        let det = gram[0][0] * gram[1][1] - gram[0][1] * gram[1][0];
        let dm_dq = (gram[0][0] * cross[1] - gram[1][0] * cross[0]) / det;
        let at_rest = self.table(&[0.0]).first().map_or(0.0, |row| row.response.re);
        // an undamped fit says little; the slowest that the weight can tell from an integrator is a start
        let slowest = -0.05 * self.weight.cutoff * self.held.inertia;
        let dm_dq = if dm_dq.is_finite() && dm_dq < slowest { dm_dq } else { slowest };
        let dm_du = -dm_dq * at_rest;
        if !dm_du.is_finite() || dm_du == 0.0 {
            let advice = "check that the model was identified from input to pitch rate";
            return Err(Error::new(
                ErrorKind::Numerical,
                "an identified model whose response at rest is zero",
                advice,
            ));
        }
        Ok([(-dm_dq).ln(), dm_du])
    }

    fn plant(&self, theta: &[f64]) -> Plant {
        let mount = self.held.mount.map(|mount| match theta {
            [_, _, mode, damping] => Mount::from_mode(mode.exp() / TAU, damping.exp(), mount.inertia),
            _ => mount,
        });
        Plant { dm_dq: -theta[0].exp(), dm_du: theta[1] * self.dm_du, mount, ..self.held }
    }

    /// |G_W| (G_ns − G_s) at `row`, and its derivatives to Θ if `gradient`.
    fn error(&self, plant: &Plant, row: &Row, gradient: Option<&mut [Complex<f64>]>) -> Complex<f64> {
        let s = Complex::new(0.0, row.omega);
        let airframe = s * plant.inertia - plant.dm_dq;
        let Some(mount) = plant.mount else {
            let response = Complex::from(plant.dm_du) / airframe;
            if let Some(gradient) = gradient {
                gradient[0] = -response / airframe * plant.dm_dq * row.weight;
                gradient[1] = -Complex::from(row.weight * self.dm_du) / airframe;
            }
            return (row.response - response) * row.weight;
        };
        let (kappa, chi) = (mount.stiffness / mount.inertia, mount.damping / mount.inertia);
        let coupling = s * chi + kappa;
        let mode = s * s + coupling;
        let denominator = airframe * mode + s * coupling * mount.inertia;
        let unit = coupling / denominator;
        let response = unit * plant.dm_du;
        if let Some(gradient) = gradient {
            gradient[0] = -response * mode / denominator * plant.dm_dq * row.weight;
            gradient[1] = -unit * row.weight * self.dm_du;
            if self.free_mount {
                let per_kappa =
                    (Complex::from(plant.dm_du) - response * (airframe + s * mount.inertia)) / denominator;
                gradient[2] = -per_kappa * (2.0 * kappa + s * chi) * row.weight;
                gradient[3] = -per_kappa * (s * chi) * row.weight;
            }
        }
        (row.response - response) * row.weight
    }

    /// The optimum of the finite problem over `table`.
    fn finite(&self, table: &[Row], bounds: &[[f64; 2]], start: &[f64]) -> (f64, Vec<f64>) {
        let values = |theta: &[f64]| {
            let plant = self.plant(theta);
            table.iter().map(|row| self.error(&plant, row, None).norm()).collect()
        };
        let gradient = |theta: &[f64], k: usize| {
            let mut slopes = vec![Complex::from(0.0); theta.len()];
            let error = self.error(&self.plant(theta), &table[k], Some(&mut slopes));
            let size = error.norm().max(f64::MIN_POSITIVE);
            slopes.iter().map(|slope| (error.conj() * slope).re / size).collect()
        };
        minimise(&Curve { values: &values, gradient: &gradient, bounds }, start)
    }

    /// The optimum with the peaks between the frequencies of `table` added to it, until they add nothing.
    fn refine(&self, table: &mut Vec<Row>, bounds: &[[f64; 2]], start: &[f64]) -> Vec<f64> {
        let mut theta = start.to_vec();
        for _ in 0..MOST_EXCHANGES {
            let (value, between) = peaks(self, table, &theta);
            let rows = self.table(&between);
            let plant = self.plant(&theta);
            let larger = rows.iter().map(|row| self.error(&plant, row, None).norm()).fold(0.0, f64::max);
            if larger <= value * (1.0 + AGREED) {
                break;
            }
            insert(table, rows);
            theta = self.finite(table, bounds, &theta).1;
        }
        theta
    }

    /// The exact norm of the weighted error.
    fn exact(&self, theta: &[f64], hints: &[f64]) -> Result<HinfNorm, Error> {
        let model = grey_box_response(&self.plant(theta))?;
        let (n, m) = (self.identified.order(), model.order());
        let (mut a, mut b) = (DMatrix::zeros(n + m, n + m), DMatrix::zeros(n + m, 1));
        let mut c = DMatrix::zeros(1, n + m);
        a.view_mut((0, 0), (n, n)).copy_from(self.identified.a());
        a.view_mut((n, n), (m, m)).copy_from(model.a());
        b.view_mut((0, 0), (n, 1)).copy_from(self.identified.b());
        b.view_mut((n, 0), (m, 1)).copy_from(model.b());
        c.view_mut((0, 0), (1, n)).copy_from(self.identified.c());
        c.view_mut((0, n), (1, m)).copy_from(&-model.c());
        let error = ContinuousStateSpace::new(a, b, c, self.identified.d().clone(), 0.0)?;
        hinf_norm(&self.weight.after(&error)?, hints)
    }

    fn report(
        &self,
        theta: &[f64],
        norm: HinfNorm,
        scale: f64,
        bounds: &[[f64; 2]],
        agreeing_starts: [usize; 2],
    ) -> HinfMatch {
        let plant = Plant { delay: self.identified.delay(), ..self.plant(theta) };
        let high = 10.0 * self.weight.cutoff.max(norm.omega);
        let grid: Vec<f64> = (0..DENSE)
            .map(|k| high * 1e-4_f64.powf(1.0 - k as f64 / (DENSE - 1) as f64))
            .chain([0.0])
            .collect();
        let size = |row: &Row| self.error(&plant, row, None).norm();
        let mut table = self.table(&grid);
        table.extend(self.table(&[norm.omega]));
        table.sort_by(|a, b| a.omega.total_cmp(&b.omega));
        let sizes: Vec<f64> = table.iter().map(size).collect();
        let on_bound = |(value, [low, high]): (&f64, &[f64; 2])| {
            let near = 1e-6 * (high - low);
            *value < low + near || *value > high - near
        };
        HinfMatch {
            plant,
            norm,
            dense_grid: sizes.iter().copied().fold(0.0, f64::max),
            relative: norm.value / scale,
            active: local_maxima(&sizes, 0.999 * norm.value).into_iter().map(|k| table[k].omega).collect(),
            agreeing_starts,
            mount_on_bound: theta.iter().zip(bounds).skip(2).any(on_bound),
        }
    }
}

/// G_s as a state space (order 3, or 1 without a mount), without its delay.
///
/// # Errors
/// Parameters that are not finite.
pub fn grey_box_response(plant: &Plant) -> Result<ContinuousStateSpace, Error> {
    let direct = DMatrix::zeros(1, 1);
    let Some(mount) = plant.mount else {
        let (a, b) = (plant.dm_dq / plant.inertia, plant.dm_du / plant.inertia);
        let scalar = |x| DMatrix::from_element(1, 1, x);
        return ContinuousStateSpace::new(scalar(a), scalar(b), scalar(1.0), direct, 0.0);
    };
    // states q, qP and δ = ω0 (θP − θ): of one size
    let omega = (mount.stiffness / mount.inertia).sqrt();
    let (i, j, k, c) = (plant.inertia, mount.inertia, mount.stiffness / omega, mount.damping);
    let a = DMatrix::from_row_slice(
        3,
        3,
        &[(plant.dm_dq - c) / i, c / i, k / i, c / j, -c / j, -k / j, -omega, omega, 0.0],
    );
    let b = DMatrix::from_column_slice(3, 1, &[plant.dm_du / i, 0.0, 0.0]);
    ContinuousStateSpace::new(a, b, DMatrix::from_row_slice(1, 3, &[0.0, 1.0, 0.0]), direct, 0.0)
}

/// Indices of the local maxima above `floor`; an end counts if its neighbour is not larger.
fn local_maxima(sizes: &[f64], floor: f64) -> Vec<usize> {
    let last = sizes.len().saturating_sub(1);
    (0..sizes.len())
        .filter(|&k| {
            sizes[k] >= floor
                && (k == 0 || sizes[k] > sizes[k - 1])
                && (k == last || sizes[k] >= sizes[k + 1])
        })
        .collect()
}

/// The largest weighted error over `table`, and its peaks between those frequencies by a parabola through three of them.
fn peaks(matching: &Matching, table: &[Row], theta: &[f64]) -> (f64, Vec<f64>) {
    let plant = matching.plant(theta);
    let sizes: Vec<f64> = table.iter().map(|row| matching.error(&plant, row, None).norm()).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let vertex = |k: usize| {
        if k == 0 || k + 1 >= table.len() {
            return table[k].omega;
        }
        let [x, y, z] = [k - 1, k, k + 1].map(|k| (table[k].omega, sizes[k]));
        let (left, right) = ((y.0 - x.0) * (y.1 - z.1), (y.0 - z.0) * (y.1 - x.1));
        let shift = ((y.0 - x.0) * left - (y.0 - z.0) * right) / (2.0 * (left - right));
        if shift.is_finite() { (y.0 - shift).clamp(x.0, z.0) } else { y.0 }
    };
    (largest, local_maxima(&sizes, 0.5 * largest).into_iter().map(vertex).collect())
}
