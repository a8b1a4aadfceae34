//! A black-box correction beside the diagnosis: what as many parameters do for the fit without saying anything.
//!
//! The free-run residual of the baseline is modelled as a sum of Laguerre filters of the input,
//! L₀ = √(1−a²)/(z−a), Lᵢ = Lᵢ₋₁ (1−a z)/(z−a) (Wahlberg 1991), so that the free run itself is fitted, by least squares.
//! The pole a counts as a parameter; it is the best of a grid on the sections that were fitted on.

use crate::sparse::HELD_OUT;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use sysid::diagnosis::traces::Trace;
use sysid::recording::Recording;
use sysid::validate::vaf::vaf;

/// Time constants of the pole, s.
const TIME_CONSTANTS_S: [f64; 8] = [0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0, 4.0];

/// A section: measured, the baseline's free run, and the filtered inputs.
struct Part<'a> {
    trace: &'a Trace,
    first_row: usize,
}

/// VAF (%) by held-out section of the baseline with a correction of `parameters` (2 or more).
pub fn correct(recording: &Recording, traces: &[Trace], parameters: usize) -> BTreeMap<String, f64> {
    let parts: Vec<Part<'_>> = traces.iter().filter_map(|trace| Part::new(recording, trace)).collect();
    let fits = TIME_CONSTANTS_S.iter().filter_map(|time_constant| {
        let pole = (-recording.step / time_constant).exp();
        let filtered = laguerre(&recording.u, pole, parameters.max(2) - 1);
        let gains = fit(&parts, &filtered)?;
        let left: f64 =
            parts.iter().filter(|p| p.trace.label != HELD_OUT).map(|p| p.power_left(&filtered, &gains)).sum();
        Some((left, filtered, gains))
    });
    let Some((_, filtered, gains)) = fits.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return BTreeMap::new();
    };
    let held_out = parts.iter().filter(|part| part.trace.label == HELD_OUT);
    held_out
        .map(|part| {
            let corrected: Vec<f64> = part.errors(&filtered, &gains);
            let simulated: Vec<f64> =
                part.trace.measured.iter().zip(&corrected).map(|(y, error)| y - error).collect();
            (part.trace.label.clone(), vaf(&part.trace.measured, &simulated))
        })
        .collect()
}

impl<'a> Part<'a> {
    /// The section, if its free run is whole and its rows are in the recording.
    fn new(recording: &Recording, trace: &'a Trace) -> Option<Self> {
        let section = recording.sections.iter().find(|s| s.label == trace.label)?;
        let whole = trace.baseline.len() == trace.measured.len();
        let inside = section.rows.start + trace.measured.len() <= recording.len();
        (whole && inside).then_some(Self { trace, first_row: section.rows.start })
    }

    /// What the baseline leaves.
    fn residual(&self) -> impl Iterator<Item = f64> {
        self.trace.measured.iter().zip(&self.trace.baseline).map(|(y, simulated)| y - simulated)
    }

    /// What baseline and correction leave.
    fn errors(&self, filtered: &[Vec<f64>], gains: &[f64]) -> Vec<f64> {
        let correction =
            |row: usize| -> f64 { filtered.iter().zip(gains).map(|(signal, gain)| gain * signal[row]).sum() };
        self.residual().enumerate().map(|(k, e)| e - correction(self.first_row + k)).collect()
    }

    fn power_left(&self, filtered: &[Vec<f64>], gains: &[f64]) -> f64 {
        self.errors(filtered, gains).iter().map(|e| e * e).sum()
    }
}

/// The input through the first `count` Laguerre filters.
fn laguerre(input: &[f64], pole: f64, count: usize) -> Vec<Vec<f64>> {
    let gain = (1.0 - pole * pole).sqrt();
    let mut signals: Vec<Vec<f64>> = Vec::new();
    for i in 0..count {
        let mut out = vec![0.0; input.len()];
        for k in 1..input.len() {
            out[k] = pole * out[k - 1]
                + match i.checked_sub(1).and_then(|before| signals.get(before)) {
                    // (1 − a z)/(z − a)
                    Some(previous) => previous[k - 1] - pole * previous[k],
                    None => gain * input[k - 1],
                };
        }
        signals.push(out);
    }
    signals
}

/// Gains by least squares over the sections that were fitted on.
fn fit(parts: &[Part<'_>], filtered: &[Vec<f64>]) -> Option<Vec<f64>> {
    let training = || parts.iter().filter(|part| part.trace.label != HELD_OUT);
    let rows: Vec<usize> =
        training().flat_map(|part| (0..part.trace.measured.len()).map(|k| part.first_row + k)).collect();
    let residuals: Vec<f64> = training().flat_map(Part::residual).collect();
    if rows.len() <= filtered.len() {
        return None;
    }
    let matrix = DMatrix::from_fn(rows.len(), filtered.len(), |r, c| filtered[c][rows[r]]);
    let right = matrix.transpose() * DVector::from_vec(residuals);
    let solution = (matrix.transpose() * &matrix).svd(true, true).solve(&right, 1e-15).ok()?;
    solution.iter().all(|gain| gain.is_finite()).then(|| solution.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filters_are_orthonormal() {
        let mut impulse = vec![0.0; 3000];
        impulse[0] = 1.0;
        let filters = laguerre(&impulse, 0.9, 4);
        for (i, a) in filters.iter().enumerate() {
            for (j, b) in filters.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9, "{i} {j} {product}");
            }
        }
    }

    #[test]
    fn a_missing_first_order_path_is_put_back() {
        let mut text = String::from("t_s,u_rad,q_rad_s,section\n");
        let (mut x, mut residual, mut input) = (0.0, Vec::new(), Vec::new());
        for k in 0..2000 {
            let u = if (k / 17) % 2 == 0 { 0.01 } else { -0.01 };
            text.push_str(&format!(
                "{:.2},{u},{x},{}\n",
                f64::from(k) * 0.02,
                if k < 1000 { "I" } else { "IV" }
            ));
            residual.push(x);
            input.push(u);
            x += 0.02 / 0.5 * (3.0 * u - x);
        }
        let recording =
            sysid::recording::parse("r.csv", text.as_bytes(), &sysid::recording::ReadOptions::default())
                .unwrap();
        let trace = |label: &str, rows: std::ops::Range<usize>| Trace {
            recording: 0,
            input: Vec::new(),
            angle: None,
            label: label.into(),
            t: Vec::new(),
            measured: residual[rows.clone()].to_vec(),
            baseline: vec![0.0; rows.len()],
            extended: Vec::new(),
            unit: "rad/s",
        };
        let found = correct(&recording, &[trace("I", 0..1000), trace("IV", 1000..2000)], 2);
        assert!(found["IV"] > 99.0, "{found:?}");
    }
}
