//! Kung's realisation of an impulse response: a state space from the shift invariance of the Hankel matrix of the taps.
//!
//! ```text
//! H[i,j] = w[i+j]  (p × p, p = ⌊(N+1)/2⌋)      H = U Λ Uᵀ = U Σ Vᵀ,  Σ = |Λ|,  V = U sign Λ
//! O = U_n Σ_n^½ = (C; CA; CA²; …)              A = O↑⁺ O↓,  C = first row of O,  B = first column of Σ_n^½ V_nᵀ
//! ```
//!
//! A square Hankel matrix is symmetric, so its eigenvalues give the singular value decomposition: faster than the
//! general one, and exact also where the rank is far below p, where nalgebra's general one (0.35) may return singular
//! vectors that do not reproduce H. With N even the last tap is not used.
//!
//! O↑ and O↓ are O without its last and first row. The first tap w\[0\] at lag L becomes C B behind an input delay of
//! L − 1 samples; with L = 0 it becomes D. A tail that the taps cut off does no harm: only products C Aⁱ B that were
//! measured enter.
//!
//! Realisations of noisy taps are often unstable from order 3 on: small singular values are noise, and noise does not
//! decay. So the order is chosen by the largest gap of the singular values and lowered until the model is
//! stable, and [`Realisation::reason`] says so; where there are data, [`realise_by_free_run`] chooses by them. An order that the caller gives is taken as it is, stable or not.
//!
//! Source: Kung, A new identification and model reduction algorithm via singular value decompositions, 12th Asilomar
//! Conference, 1978.

use crate::error::{Error, ErrorKind};
use crate::identify::fir::{Fir, Piece};
use crate::identify::linear_model::LinearModel;
use crate::model::state_space::StateSpace;
use crate::validate::vaf::vaf;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Highest order that is chosen without being asked for.
pub const HIGHEST_ORDER: usize = 5;
/// Singular values below this share of the first are rounding.
const ROUNDING: f64 = 1e-13;
/// Taps all below this count as zero: their squares underflow.
const SMALLEST_TAP: f64 = 1e-150;
/// Rounds of the eigenvalue iteration.
const EIGENVALUE_ROUNDS: usize = 10_000;

/// A realised model.
#[derive(Clone, Debug, PartialEq)]
pub struct Realisation {
    /// The model.
    pub model: StateSpace,
    /// All singular values of H, in falling order, rad/s per unit of the input.
    pub singular_values: Vec<f64>,
    /// Whether the model is stable. Do not simulate with one that is not.
    pub stable: bool,
    /// What was chosen and why: one sentence for people.
    pub reason: String,
}

/// Realises `fir` with the given order, 1 to [`HIGHEST_ORDER`], or with the one that the taps suggest.
///
/// # Errors
/// An order out of range, too few taps for it, taps of a lower rank than it, taps that are zero or not finite.
pub fn realise(fir: &Fir, order: Option<usize>) -> Result<Realisation, Error> {
    let highest = order.unwrap_or(HIGHEST_ORDER);
    if !(1..=HIGHEST_ORDER).contains(&highest) {
        return Err(Error::new(ErrorKind::Options, format!("order {highest}"), "choose a low order")
            .expecting(format!("1 to {HIGHEST_ORDER}")));
    }
    let markov = if fir.first_lag == 0 { fir.taps.get(1..).unwrap_or_default() } else { &fir.taps };
    if markov.len() < 2 * highest + 2 {
        let found = format!("{} taps at lag 1 and later", markov.len());
        return Err(Error::new(ErrorKind::TooShort, found, "estimate more taps, or choose a lower order")
            .expecting(format!("at least {} for order {highest}", 2 * highest + 2)));
    }
    let hankel = Hankel::of(markov)?;
    let singular_values = hankel.values.iter().map(|value| value.abs()).collect::<Vec<f64>>();
    let gap = largest_gap(&singular_values);
    let (model, reason) = match order {
        Some(n) => (hankel.realise(n, fir)?, given(n, gap)),
        None => chosen(&hankel, fir, gap)?,
    };
    let stable = model.is_stable();
    let verdict = if stable { "" } else { "; the model is unstable" };
    Ok(Realisation { model, singular_values, stable, reason: format!("{reason}{verdict}") })
}

/// Realises `fir` with the lowest stable order whose free runs over `pieces` are within half a point of VAF of the best
/// stable order's.
///
/// # Errors
/// As [`realise`]; no stable order.
pub fn realise_by_free_run(fir: &Fir, pieces: &[Piece]) -> Result<Realisation, Error> {
    const AS_GOOD: f64 = 0.5;
    let (mut scored, mut unstable) = (Vec::new(), Vec::new());
    for order in 1..=HIGHEST_ORDER {
        let Ok(found) = realise(fir, Some(order)) else { break };
        if !found.stable {
            unstable.push(order.to_string());
            continue;
        }
        let model = LinearModel::Sampled(found.model.clone());
        let vaf_of = |piece: &Piece| {
            let run = model.simulate(piece);
            run.map_or(0.0, |simulated| vaf(&piece.y[piece.rows.clone()], &simulated))
        };
        scored.push((pieces.iter().map(vaf_of).sum::<f64>() / pieces.len().max(1) as f64, found));
    }
    let best = scored.iter().map(|(vaf, _)| *vaf).fold(f64::NEG_INFINITY, f64::max);
    let Some((vaf, mut found)) = scored.into_iter().find(|(vaf, _)| *vaf >= best - AS_GOOD) else {
        // says why there is none
        return realise(fir, None);
    };
    let left_out =
        if unstable.is_empty() { String::new() } else { format!("; unstable: {}", unstable.join(", ")) };
    found.reason = format!(
        "order {}: the lowest within {AS_GOOD} points of the best stable one, {vaf:.1} % where it was fitted{left_out}",
        found.model.order()
    );
    Ok(found)
}

/// The order with the largest σ_n / σ_n+1, and this ratio.
fn largest_gap(singular_values: &[f64]) -> (usize, f64) {
    let floor = ROUNDING * singular_values.first().copied().unwrap_or(0.0);
    let ratio = |pair: &[f64]| pair[0].max(floor) / pair[1].max(floor);
    let ratios = singular_values.windows(2).take(HIGHEST_ORDER).map(ratio);
    // the first of equals: the lowest order
    ratios.enumerate().fold((1, 0.0), |best, (i, ratio)| if ratio > best.1 { (i + 1, ratio) } else { best })
}

fn given(n: usize, (gap, ratio): (usize, f64)) -> String {
    format!(
        "order {n}, as asked; the largest gap of the singular values ({ratio:.3} times) is after number {gap}"
    )
}

/// The order at the gap, or the next lower one that is stable.
fn chosen(hankel: &Hankel, fir: &Fir, (gap, ratio): (usize, f64)) -> Result<(StateSpace, String), Error> {
    let because = format!("the largest gap of the singular values ({ratio:.3} times) is after number {gap}");
    let mut model = hankel.realise(gap, fir)?;
    let mut n = gap;
    while n > 1 && !model.is_stable() {
        n -= 1;
        model = hankel.realise(n, fir)?;
    }
    let lowered = match gap - n {
        0 => String::new(),
        1 => format!(", and order {gap} is unstable"),
        _ => format!(", and orders {} to {gap} are unstable", n + 1),
    };
    Ok((model, format!("order {n}: {because}{lowered}")))
}

/// Eigenvectors as columns and eigenvalues of H, the largest in magnitude first.
struct Hankel {
    vectors: DMatrix<f64>,
    values: DVector<f64>,
}

impl Hankel {
    fn of(markov: &[f64]) -> Result<Self, Error> {
        let largest = markov.iter().fold(0.0_f64, |largest, w| largest.max(w.abs()));
        let unusable = |what: &str| {
            let advice = "check that the input moves in the sections that the taps come from";
            Error::new(ErrorKind::Numerical, format!("the taps {what}"), advice)
        };
        if !markov.iter().all(|w| w.is_finite()) {
            return Err(unusable("are not all finite"));
        }
        if largest < SMALLEST_TAP {
            return Err(unusable("are zero"));
        }
        let size = markov.len().div_ceil(2);
        let matrix = DMatrix::from_fn(size, size, |i, j| markov[i + j]);
        let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, EIGENVALUE_ROUNDS)
            .ok_or_else(|| unusable("have no singular value decomposition"))?;
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[j].abs().total_cmp(&eigen.eigenvalues[i].abs()));
        let vectors = eigen.eigenvectors.select_columns(&order);
        Ok(Self { vectors, values: eigen.eigenvalues.select_rows(&order) })
    }

    fn realise(&self, n: usize, fir: &Fir) -> Result<StateSpace, Error> {
        let failed = || {
            let advice = "choose a lower order";
            Error::new(ErrorKind::Numerical, format!("order {n} exceeds what the taps contain"), advice)
        };
        let values = self.values.rows(0, n);
        if values[n - 1].abs() <= ROUNDING * values[0].abs() {
            return Err(failed());
        }
        let root = values.map(|value| value.abs().sqrt());
        let observability = self.vectors.columns(0, n) * DMatrix::from_diagonal(&root);
        let height = observability.nrows() - 1;
        let (q, r) = observability.rows(0, height).into_owned().qr().unpack();
        let shifted = q.tr_mul(&observability.rows(1, height));
        let a = r.solve_upper_triangular(&shifted).ok_or_else(failed)?;
        let c = observability.row(0).into_owned();
        let b = c.transpose().zip_map(&values, |c, value| c * value.signum());
        let direct = if fir.first_lag == 0 { fir.taps.first().copied().unwrap_or(0.0) } else { 0.0 };
        StateSpace::new(a, b, c, direct, fir.step, fir.first_lag.saturating_sub(1)).map_err(|_| failed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    /// h[k] = Σ gᵢ Re(pᵢᵏ), k = 0..count.
    fn taps(terms: &[(f64, Complex<f64>)], count: i32) -> Vec<f64> {
        (0..count).map(|k| terms.iter().map(|(g, p)| g * p.powi(k).re).sum()).collect()
    }

    #[test]
    fn recovers_the_poles_the_delay_and_the_response_of_a_second_order_system() {
        let pole = Complex::from_polar(0.93, 0.35);
        for (order, first_lag) in [(Some(2), 4), (None, 4), (None, 1)] {
            let fir = Fir { taps: taps(&[(3.0, pole)], 60), first_lag, step: 0.02 };
            let found = realise(&fir, order).unwrap();
            assert_eq!(
                (found.model.order(), found.model.delay_samples()),
                (2, first_lag - 1),
                "{}",
                found.reason
            );
            assert!((found.model.poles()[1] - pole).norm() < 1e-8 && found.stable);
            let mut pulse = vec![0.0; 200];
            pulse[0] = 1.0;
            let expected = Fir { taps: taps(&[(3.0, pole)], 200), ..fir }.simulate(&pulse);
            let response = found.model.impulse_response(200);
            assert!(response.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-8));
        }
    }

    #[test]
    fn two_real_poles_of_different_speed() {
        let terms = [(1.0, Complex::from(0.97)), (-0.8, Complex::from(0.6))];
        let found = realise(&Fir { taps: taps(&terms, 60), first_lag: 1, step: 0.02 }, None).unwrap();
        assert_eq!(found.model.order(), 2, "{}", found.reason);
        for (pole, (_, expected)) in found.model.poles().iter().zip(terms) {
            assert!((pole - expected).norm() < 1e-8, "{pole}");
        }
    }

    #[test]
    fn many_ranks_and_lengths_reproduce_their_taps() {
        for count in [12, 15, 29, 30, 60, 100] {
            for slow in [0.3, 0.6, 0.8, 0.9, 0.95, 0.99] {
                for fast in [0.0, 0.2, 0.5, 0.7] {
                    let w = taps(&[(2.0, Complex::from(slow)), (-1.0, Complex::from(fast))], count);
                    let found = realise(&Fir { taps: w.clone(), first_lag: 1, step: 0.02 }, None).unwrap();
                    let response = found.model.impulse_response(w.len() + 1);
                    let error = response[1..].iter().zip(&w).fold(0.0_f64, |e, (a, b)| e.max((a - b).abs()));
                    assert!(error < 1e-7, "{count} taps, poles {slow}, {fast}: {error:e}, {}", found.reason);
                }
            }
        }
    }

    #[test]
    fn a_tap_at_lag_zero_is_the_direct_term() {
        let mut w = taps(&[(2.0, Complex::from(0.8))], 30);
        w.insert(0, 7.0);
        let found = realise(&Fir { taps: w.clone(), first_lag: 0, step: 0.02 }, None).unwrap();
        assert_eq!((found.model.d(), found.model.delay_samples(), found.model.order()), (7.0, 0, 1));
        assert!(found.model.impulse_response(31).iter().zip(&w).all(|(a, b)| (a - b).abs() < 1e-10));
    }

    #[test]
    fn an_unstable_order_is_lowered_or_flagged() {
        // a slow mode, and a pair that grows, within 1.3 times of each other in the singular values
        let growing = Complex::from_polar(1.02, 1.5);
        let fir =
            Fir { taps: taps(&[(1.0, Complex::from(0.95)), (0.35, growing)], 40), first_lag: 1, step: 0.02 };
        let asked = realise(&fir, Some(3)).unwrap();
        assert!(!asked.stable && asked.reason.ends_with("unstable"), "{}", asked.reason);
        assert!((asked.model.spectral_radius() - 1.02).abs() < 1e-8);
        let free = realise(&fir, None).unwrap();
        assert!(free.stable && free.model.order() < 3, "{}", free.reason);
        assert!(
            free.reason.contains("after number 3") && free.reason.contains("unstable"),
            "{}",
            free.reason
        );
    }

    #[test]
    fn refuses_what_it_cannot_realise() {
        let with = |taps: Vec<f64>| Fir { taps, first_lag: 1, step: 0.02 };
        assert!(realise(&with(vec![1.0; 11]), None).is_err());
        assert!(realise(&with(vec![0.0; 60]), None).is_err());
        assert!(realise(&with(vec![f64::NAN; 60]), None).is_err());
        assert!(realise(&with(vec![1.0; 60]), Some(0)).is_err());
        assert!(realise(&with(vec![1.0; 60]), Some(6)).is_err());
        let error = realise(&with(vec![1.0; 60]), Some(2)).unwrap_err();
        assert!(error.to_string().contains("order 2 exceeds"), "taps of rank 1: {error}");
    }
}
