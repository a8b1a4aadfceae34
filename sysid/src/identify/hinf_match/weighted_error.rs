//! The weighted error of a grey box against an identified model: its values and derivatives, its finite minimax problem,
//! and its exact norm.

use super::super::butterworth::Butterworth;
use super::super::continuous::ContinuousStateSpace;
use super::super::hinf_norm::{HinfNorm, hinf_norm};
use super::{AGREED, DENSE, HinfMatch, MOST_EXCHANGES, insert};
use crate::error::{Error, ErrorKind};
use crate::model::plant::{Mount, Plant};
use crate::optim::minimax::{Curve, minimise};
use core::f64::consts::TAU;
use nalgebra::{Complex, DMatrix};

/// A frequency with what does not depend on Θ there.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub omega: f64,
    pub weight: f64,
    pub response: Complex<f64>,
}

pub(super) struct Matching<'a> {
    pub identified: &'a ContinuousStateSpace,
    pub held: Plant,
    pub weight: &'a Butterworth,
    pub free_mount: bool,
    /// Unit of Θ's second entry, N m per unit of the input.
    pub dm_du: f64,
}

impl Matching<'_> {
    pub fn table(&self, frequencies: &[f64]) -> Vec<Row> {
        let row = |omega: &f64| {
            let response = self.identified.response_without_delay(*omega)?[0];
            Some(Row { omega: *omega, weight: self.weight.gain(*omega), response })
        };
        frequencies.iter().filter_map(row).collect()
    }

    /// ln(−∂M/∂q) and ∂M/∂u of (jω Iyy) G = ∂M/∂u + ∂M/∂q G by weighted least squares below the cutoff.
    pub fn straight_line(&self) -> Result<[f64; 2], Error> {
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
    pub fn finite(&self, table: &[Row], bounds: &[[f64; 2]], start: &[f64]) -> (f64, Vec<f64>) {
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
    pub fn refine(&self, table: &mut Vec<Row>, bounds: &[[f64; 2]], start: &[f64]) -> Vec<f64> {
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
    pub fn exact(&self, theta: &[f64], hints: &[f64]) -> Result<HinfNorm, Error> {
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

    pub fn report(
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
pub(super) fn peaks(matching: &Matching, table: &[Row], theta: &[f64]) -> (f64, Vec<f64>) {
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
