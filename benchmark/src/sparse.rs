//! Sparse regression beside the diagnosis: sequentially thresholded least squares (Brunton, Proctor, Kutz, 2016).
//!
//! The pitch acceleration is regressed on q, the delayed command and a library of candidate terms. Both sides are
//! averaged with the weights of a local straight-line fit over nine samples, which makes the left side the slope of
//! that line and spares differentiating noise (the weak form of Messenger and Bortz, 2021). q and u stay, so that
//! wrong values of the user's model are estimated again; a candidate whose contribution falls below the threshold
//! is dropped and the rest is fitted again. The threshold is chosen by cross-validation over the sections that are
//! not held out: the largest whose error is within one standard error of the least (Hastie, Tibshirani, Friedman
//! 2009, 7.10).

use crate::truth::Sparse;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use sysid::model::file::ModelFile;
use sysid::recording::Recording;
use sysid::validate::vaf::vaf;

/// Half the width of the local line, samples.
const REACH: usize = 4;
/// Thresholds on a term's effective contribution, relative to the effective value of the residual.
const THRESHOLDS: [f64; 11] = [0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.25, 0.35, 0.5, 0.7, f64::INFINITY];
/// Section that is held out.
pub const HELD_OUT: &str = "IV";

/// A candidate: its name and the ids that it may stand for.
struct Candidate {
    name: &'static str,
    ids: &'static [&'static str],
}

/// The library. What is not in it, such as free play or a sensor's fault, has no term in this form.
const LIBRARY: [Candidate; 10] = [
    Candidate { name: "1", ids: &["trim_offset"] },
    Candidate { name: "θ", ids: &["gravity_stiffness"] },
    Candidate { name: "θ³", ids: &["cubic_stiffness"] },
    Candidate { name: "q|q|", ids: &["quadratic_drag"] },
    Candidate { name: "sign q", ids: &["coulomb_friction"] },
    Candidate { name: "u|u|", ids: &["thrust_curve"] },
    Candidate { name: "u̇", ids: &["servo_lag", "extra_delay"] },
    Candidate { name: "t u", ids: &["effectiveness_fade"] },
    Candidate { name: "t u̇", ids: &["clock_skew"] },
    Candidate { name: "p r", ids: &["gyroscopic_coupling"] },
];
/// q and u, which are never dropped.
const KEPT: usize = 2;
const TERMS: usize = KEPT + LIBRARY.len();

/// The signals at one sample, and the step.
#[derive(Clone, Copy)]
struct Point {
    q: f64,
    theta: f64,
    u: f64,
    u_dot: f64,
    t: f64,
    p_r: f64,
}

impl Point {
    /// q, u and the library.
    fn terms(&self) -> [f64; TERMS] {
        let Self { q, theta, u, u_dot, t, p_r } = *self;
        let sign = if q == 0.0 { 0.0 } else { q.signum() };
        [q, u, 1.0, theta, theta.powi(3), q * q.abs(), sign, u * u.abs(), u_dot, t * u, t * u_dot, p_r]
    }
}

/// Averaged terms and slopes of the rate, row by row.
#[derive(Clone, Default)]
struct Rows {
    terms: Vec<[f64; TERMS]>,
    slopes: Vec<f64>,
}

/// Regresses the recording and simulates what is held out.
pub fn regress(recording: &Recording, model: &ModelFile) -> Option<Sparse> {
    let points = points(recording, model.plant.delay_s.unwrap_or(0.0))?;
    let training = recording.sections.iter().filter(|s| s.file_label != HELD_OUT);
    let folds: Vec<Rows> = training.map(|s| averaged(&points, s.rows.clone(), recording.step)).collect();
    let coefficients = Rows::joined(&folds).thresholded(threshold(&folds)?)?;
    let kept: Vec<&Candidate> =
        LIBRARY.iter().zip(&coefficients[KEPT..]).filter(|(_, c)| **c != 0.0).map(|(l, _)| l).collect();
    Some(Sparse {
        terms: kept.iter().map(|candidate| candidate.name.to_owned()).collect(),
        ids: kept.iter().map(|c| c.ids.iter().map(|id| (*id).to_owned()).collect()).collect(),
        vaf_percent: simulated(recording, &points, &coefficients),
    })
}

/// The signals sample by sample; none without rate or angle.
fn points(recording: &Recording, delay_s: f64) -> Option<Vec<Point>> {
    let (q, theta) = (recording.q.as_ref()?, recording.theta.as_ref()?);
    let late = (delay_s / recording.step).round() as usize;
    let sent = |k: usize| k.checked_sub(late).map_or(0.0, |k| recording.u[k]);
    let point = |k: usize| Point {
        q: q[k],
        theta: theta[k],
        u: sent(k),
        u_dot: (sent(k) - sent(k.saturating_sub(1))) / recording.step,
        t: recording.t[k] - recording.t[0],
        p_r: recording.p.as_ref().zip(recording.r.as_ref()).map_or(0.0, |(p, r)| p[k] * r[k]),
    };
    Some((0..recording.len()).map(point).collect())
}

/// Rows of one section.
fn averaged(points: &[Point], rows: core::ops::Range<usize>, step: f64) -> Rows {
    let reach = REACH as i64;
    let spread: f64 = (-reach..=reach).map(|j| (j * j) as f64).sum::<f64>() * step;
    let mut found = Rows::default();
    for k in (rows.start + REACH..rows.end.saturating_sub(REACH)).step_by(REACH) {
        let (mut row, mut slope) = ([0.0; TERMS], 0.0);
        // weight of a step: the sum of the line's weights to its right
        let mut weight = 0.0;
        for j in (1..=2 * REACH).rev() {
            weight += (j as f64 - REACH as f64) / spread;
            let (from, to) = (&points[k - REACH + j - 1], &points[k - REACH + j]);
            slope += weight * (to.q - from.q);
            // the command is held, the rest runs straight
            let (a, b) = (from.terms(), Point { u: from.u, u_dot: from.u_dot, ..*to }.terms());
            for (sum, (a, b)) in row.iter_mut().zip(a.iter().zip(b)) {
                *sum += weight * step * 0.5 * (a + b);
            }
        }
        found.terms.push(row);
        found.slopes.push(slope);
    }
    found
}

/// The largest threshold whose error, each section predicted from the others, is within one standard error of the least.
fn threshold(folds: &[Rows]) -> Option<f64> {
    if folds.len() < 2 {
        return None;
    }
    let errors_at = |threshold: f64| -> Option<(f64, f64)> {
        let errors: Vec<f64> = (0..folds.len())
            .map(|out| {
                let others: Vec<Rows> = folds
                    .iter()
                    .enumerate()
                    .filter(|(i, _)| *i != out)
                    .map(|(_, rows)| rows.clone())
                    .collect();
                let coefficients = Rows::joined(&others).thresholded(threshold)?;
                Some(rms(&folds[out].residuals(&coefficients)).powi(2))
            })
            .collect::<Option<_>>()?;
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Some((mean, (variance / n).sqrt()))
    };
    let tried: Vec<(f64, f64, f64)> = THRESHOLDS
        .iter()
        .map(|t| errors_at(*t).map(|(mean, error)| (*t, mean, error)))
        .collect::<Option<_>>()?;
    let (_, least, error) = tried.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    tried.iter().rev().find(|(_, mean, _)| *mean <= least + error).map(|(threshold, ..)| *threshold)
}

impl Rows {
    fn joined(parts: &[Self]) -> Self {
        let terms = parts.iter().flat_map(|part| part.terms.iter().copied()).collect();
        Self { terms, slopes: parts.iter().flat_map(|part| part.slopes.iter().copied()).collect() }
    }

    /// Least squares, contributions below the threshold dropped, until nothing more is dropped.
    fn thresholded(&self, threshold: f64) -> Option<[f64; TERMS]> {
        let baseline = self.least_squares(&std::array::from_fn(|i| i < KEPT))?;
        let least = threshold * rms(&self.residuals(&baseline));
        let size = self.sizes()?;
        // the last part of a column that is nothing but q and u is rounding
        let mut active: [bool; TERMS] = std::array::from_fn(|i| i < KEPT || size[i] > 1e-9);
        loop {
            let found = self.least_squares(&active)?;
            let stays: [bool; TERMS] =
                std::array::from_fn(|i| active[i] && (i < KEPT || (found[i] * size[i]).abs() >= least));
            if stays == active {
                return Some(found);
            }
            active = stays;
        }
    }

    /// Effective value of what a candidate has beyond q and u: under a two-level excitation u|u| is nearly u itself.
    fn sizes(&self) -> Option<[f64; TERMS]> {
        let mut sizes = [0.0; TERMS];
        for (i, size) in sizes.iter_mut().enumerate().skip(KEPT) {
            let column = Self { slopes: self.terms.iter().map(|row| row[i]).collect(), ..self.clone() };
            *size = rms(&column.residuals(&column.least_squares(&std::array::from_fn(|k| k < KEPT))?));
        }
        Some(sizes)
    }

    fn least_squares(&self, active: &[bool; TERMS]) -> Option<[f64; TERMS]> {
        let columns: Vec<usize> = (0..TERMS).filter(|i| active[*i]).collect();
        let scale = |i: usize| self.terms.iter().map(|row| row[i].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let scales: Vec<f64> = columns.iter().map(|i| scale(*i)).collect();
        let count = self.terms.len();
        let matrix = DMatrix::from_fn(count, columns.len(), |r, c| self.terms[r][columns[c]] / scales[c]);
        let solution = matrix.svd(true, true).solve(&DVector::from_column_slice(&self.slopes), 1e-10).ok()?;
        let mut coefficients = [0.0; TERMS];
        for ((column, scale), value) in columns.into_iter().zip(scales).zip(&solution) {
            coefficients[column] = value / scale;
        }
        Some(coefficients)
    }

    fn residuals(&self, coefficients: &[f64; TERMS]) -> Vec<f64> {
        self.terms.iter().zip(&self.slopes).map(|(row, slope)| slope - dot(row, coefficients)).collect()
    }
}

fn dot(a: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// VAF of the free run through the held-out sections, from the measured state at their beginning; Heun's method.
fn simulated(recording: &Recording, points: &[Point], coefficients: &[f64; TERMS]) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    for section in recording.sections.iter().filter(|s| s.file_label == HELD_OUT) {
        let part = &points[section.rows.clone()];
        let Some(first) = part.first() else { continue };
        let (mut q, mut theta) = (first.q, first.theta);
        let mut run = Vec::with_capacity(part.len());
        for point in part {
            run.push(q);
            let rate = |q: f64, theta: f64| dot(&Point { q, theta, ..*point }.terms(), coefficients);
            let k1 = rate(q, theta);
            let k2 = rate(q + recording.step * k1, theta + recording.step * q);
            theta += recording.step * (q + 0.5 * recording.step * k1);
            q += 0.5 * recording.step * (k1 + k2);
        }
        let measured: Vec<f64> = part.iter().map(|point| point.q).collect();
        found.insert(section.label.clone(), vaf(&measured, &run));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nominal;
    use host_sim::{Background, Plant, Scenario, Setting, fly};
    use sysid::recording::{ReadOptions, parse};

    fn regressed(effects: Vec<Setting>) -> Sparse {
        let mut scenario = Scenario::campaign(4, 0.015, 3).unwrap();
        scenario.background = Background::Clean;
        scenario.plant = Plant::nominal().rigid();
        scenario.conceal(effects);
        let text = fly(&scenario).unwrap().recording();
        let recording = parse("r.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        regress(&recording, &nominal()).unwrap()
    }

    #[test]
    fn a_term_of_the_library_is_found() {
        let stiff = Setting::new("gravity_stiffness", &[("G", 0.5)]).unwrap();
        let found = regressed(vec![stiff]);
        assert_eq!(found.ids, [["gravity_stiffness"]]);
        assert!(found.vaf_percent["IV"] > 80.0, "{:?}", found.vaf_percent);
    }

    #[test]
    fn where_nothing_is_concealed_nothing_is_kept() {
        assert!(regressed(Vec::new()).terms.is_empty());
    }
}
