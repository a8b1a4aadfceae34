//! Normalised LMS estimate of the finite impulse response from command to pitch rate.
//!
//! ```text
//! q̂[k] = w[k]ᵀ φ[k]        φ[k] = (u[k−1−d], …, u[k−n−d])
//! e[k] = q[k] − q̂[k]
//! w[k+1] = (1 − γ) w[k] + μ e[k] φ[k] / (ε + φ[k]ᵀ φ[k])
//! ```
//!
//! | symbol | meaning | unit | legal |
//! | --- | --- | --- | --- |
//! | w | taps, w\[0\] acts one sample after the delay | rad/s per rad | |
//! | μ | step size | - | 0 < μ < 2 |
//! | γ | leakage: pulls unexcited directions to zero | - | 0 to 0.01 |
//! | ε | regularisation: bounds the step where the input is silent | rad² | 1e-12 to 1 |
//! | d | input delay | samples | 0 to 15 |
//! | n | number of taps | - | 1 to N, the capacity |
//!
//! For 0 < μ < 2 the a-posteriori error (1 − μ φᵀφ/(ε+φᵀφ)) e never exceeds e, whatever the input; that is the
//! stability bound checked by `build`. E\[u²\] of the paper's excitation is about 2e-4 rad², so the plain LMS
//! would need a step of 1 to 20 and retuning with each amplitude: hence normalised. While the supervisor
//! holds, the taps are left alone ([`NormalizedLms::observe`] with `adapt = false`), for its feedback
//! correlates u with the disturbance; the regressor goes on holding the input truly applied.
//!
//! One pass over the taps does both: it moves w\[k\] to w\[k+1\] and takes the part of q̂\[k+1\] that is known already, for
//! φ\[k+1\] is φ\[k\] moved on by one and the newest input. Each tap then costs two loads, two multiplications and additions, and
//! one store.
//!
//! Order of summation, the same on chip and host: eight partial sums, tap i ≥ 1 to sum i mod 8, then
//! ((s0+s1)+(s2+s3)) + ((s4+s5)+(s6+s7)), then tap 0. No fused multiply-add.
//!
//! Cost: 12 N + 96 bytes; 4 n + 20 operations per sample, 5 n with leakage.
//! Source: Nagumo, Noda, 1967; Haykin, *Adaptive Filter Theory*, 4th ed., table 6.1.

use crate::config_error::{ConfigError, within};
use crate::constants::{MAX_INPUT_DELAY, TAPS};
use crate::delay_line::DelayLine;

/// Estimator in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LmsConfig {
    /// μ, 1e-6 to 1.999.
    pub step: f32,
    /// γ, 0 to 0.01 per update.
    pub leakage: f32,
    /// ε, rad², 1e-12 to 1. The default is 1 % of the regressor energy 60 · (0.012 rad)² of the weakest
    /// excitation.
    pub regularisation_rad2: f32,
    /// d, samples, 0 to 15. Three are 0.06 s.
    pub input_delay: u8,
    /// n, 1 to the capacity N.
    pub taps: u16,
}

impl Default for LmsConfig {
    fn default() -> Self {
        Self { step: 0.05, leakage: 0.0, regularisation_rad2: 1e-4, input_delay: 3, taps: TAPS as u16 }
    }
}

impl LmsConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field outside its legal range.
    pub fn build<const N: usize>(&self) -> Result<NormalizedLms<N>, ConfigError> {
        within("lms.step", "", self.step, [1e-6, 1.999])?;
        within("lms.leakage", "", self.leakage, [0.0, 0.01])?;
        within("lms.regularisation_rad2", "rad²", self.regularisation_rad2, [1e-12, 1.0])?;
        within("lms.input_delay", "samples", f32::from(self.input_delay), [0.0, f32::from(MAX_INPUT_DELAY)])?;
        within("lms.taps", "", f32::from(self.taps), [1.0, N as f32])?;
        Ok(NormalizedLms {
            taps: usize::from(self.taps),
            step: self.step,
            keep: 1.0 - self.leakage,
            regularisation: self.regularisation_rad2,
            input_delay: self.input_delay,
        })
    }
}

/// Estimator of up to N taps, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalizedLms<const N: usize> {
    /// n.
    pub(crate) taps: usize,
    pub(crate) step: f32,
    pub(crate) keep: f32,
    regularisation: f32,
    input_delay: u8,
}

/// Taps and regressor.
#[derive(Clone, Debug, PartialEq)]
pub struct LmsState<const N: usize> {
    taps: [f32; N],
    line: DelayLine<N>,
    /// q̂ of the coming sample; after a pass, the part of it that does not need the coming input.
    prediction: f32,
    passed: bool,
}

impl<const N: usize> Default for LmsState<N> {
    fn default() -> Self {
        Self { taps: [0.0; N], line: DelayLine::new(), prediction: 0.0, passed: false }
    }
}

impl<const N: usize> LmsState<N> {
    /// w, rad/s per rad; w\[i\] is the response 1 + d + i samples after a unit pulse of one sample. Zero from n on.
    #[must_use]
    pub const fn taps(&self) -> &[f32; N] {
        &self.taps
    }

    /// The inputs that the taps meet.
    #[must_use]
    pub const fn line(&self) -> &DelayLine<N> {
        &self.line
    }
}

/// What one sample did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// e\[k\], rad/s.
    pub error: f32,
    /// μ e / (ε + φᵀφ): the taps moved by this times φ. Zero while gated.
    pub gain: f32,
}

impl<const N: usize> NormalizedLms<N> {
    /// Meets q\[k\] (rad/s) with the inputs up to u\[k−1\], and moves the taps if `adapt`. At most once between two calls
    /// of [`Self::push`]. A sample that is no number, or so wild that the step overflows, moves nothing.
    pub fn observe(&self, state: &mut LmsState<N>, q: f32, adapt: bool) -> Update {
        let LmsState { taps, line, prediction, passed } = state;
        let error = q - *prediction;
        let gain = self.step * error / (self.regularisation + line.energy());
        let moves = adapt && gain.is_finite();
        *prediction = if !moves {
            pass(taps, line, self.taps, |w, _| w)
        } else if self.keep == 1.0 {
            pass(taps, line, self.taps, |w, x| w + gain * x)
        } else {
            pass(taps, line, self.taps, |w, x| self.keep * w + gain * x)
        };
        *passed = true;
        Update { error, gain: if moves { gain } else { 0.0 } }
    }

    /// Takes the u\[k\] (rad) truly sent to the servo. Called once per tick, after [`Self::observe`], also where there was
    /// no sample to observe.
    pub fn push(&self, state: &mut LmsState<N>, u: f32) {
        if !state.passed {
            self.look_ahead(state);
        }
        let LmsState { taps, line, prediction, passed } = state;
        *passed = false;
        let newest = line.push(u, self.input_delay, self.taps);
        *prediction += taps.first().map_or(0.0, |w| w * newest);
    }

    #[cold]
    #[inline(never)]
    fn look_ahead(&self, state: &mut LmsState<N>) {
        state.prediction = pass(&mut state.taps, &state.line, self.taps, |w, _| w);
    }
}

/// w\[i\] ← `change`(w\[i\], x\[i\]) for every i of x; returns Σ w\[i\] x\[i−1\] over i ≥ 1, in the documented order.
///
/// A function of its own: inlined, the compiler addresses both slices from the state's beginning, too far for one instruction.
#[inline(never)]
fn pass<const N: usize>(
    w: &mut [f32; N],
    line: &DelayLine<N>,
    length: usize,
    change: impl Fn(f32, f32) -> f32,
) -> f32 {
    // never taken; written so that both lengths are known to be one
    let (Some(w), Some(x)) = (w.get_mut(..length), line.regressor(length)) else { return 0.0 };
    let (w8, w_rest) = w.as_chunks_mut::<8>();
    let (x8, x_rest) = x.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    let mut before = 0.0;
    for (w, x) in w8.iter_mut().zip(x8) {
        for ((sum, w), x) in sums.iter_mut().zip(w).zip(x) {
            *w = change(*w, *x);
            *sum += *w * before;
            before = *x;
        }
    }
    for ((sum, w), x) in sums.iter_mut().zip(w_rest).zip(x_rest) {
        *w = change(*w, *x);
        *sum += *w * before;
        before = *x;
    }
    let [s0, s1, s2, s3, s4, s5, s6, s7] = sums;
    ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / 8_388_608.0 - 1.0
    }

    #[test]
    fn one_tap_meets_the_closed_form() {
        // x = 1 throughout: w[k] = h (1 − (1 − μ/(1+ε))^k)
        let lms = LmsConfig { step: 0.5, regularisation_rad2: 1.0, input_delay: 0, leakage: 0.0, taps: 1 };
        let lms = lms.build::<1>().unwrap();
        let mut state = LmsState::default();
        lms.push(&mut state, 1.0);
        for k in 1..=20 {
            lms.observe(&mut state, 3.0, true);
            lms.push(&mut state, 1.0);
            let expected = 3.0 * (1.0 - 0.75_f64.powi(k));
            assert!((f64::from(state.taps()[0]) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn finds_known_taps_behind_a_delay() {
        let truth: [f32; 12] = core::array::from_fn(|i| 4.0 * (-0.3 * i as f32).exp());
        let lms =
            LmsConfig { step: 0.5, input_delay: 2, taps: 12, ..LmsConfig::default() }.build::<12>().unwrap();
        let (mut state, mut seed) = (LmsState::default(), 1);
        let mut inputs = std::vec![0.0_f32; 20];
        for _ in 0..4000 {
            let q: f32 = truth.iter().enumerate().map(|(i, h)| h * inputs[inputs.len() - 3 - i]).sum();
            lms.observe(&mut state, q, true);
            let u = 0.02 * noise(&mut seed);
            inputs.push(u);
            lms.push(&mut state, u);
        }
        for (found, expected) in state.taps().iter().zip(truth) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn leakage_pulls_the_taps_to_the_closed_form_equilibrium() {
        // one tap, x = 1: γ w = g e, with e = h − w and g = μ/(1+ε)  ⇒  w = g h / (γ + g)
        let config =
            LmsConfig { step: 0.1, leakage: 0.01, regularisation_rad2: 1e-4, input_delay: 0, taps: 1 };
        let lms = config.build::<1>().unwrap();
        let mut state = LmsState::default();
        lms.push(&mut state, 1.0);
        for _ in 0..2000 {
            lms.observe(&mut state, 1.0, true);
            lms.push(&mut state, 1.0);
        }
        let g = 0.1 / 1.0001;
        assert!((state.taps()[0] - g / (0.01 + g)).abs() < 1e-5);
    }

    #[test]
    fn the_sum_is_taken_in_the_documented_order() {
        let mut w: [f32; 11] = core::array::from_fn(|i| 1.0 / (3.0 + i as f32));
        let x: [f32; 11] = core::array::from_fn(|i| (1.7 * i as f32).sin());
        let moved = w.map(|w| 0.5 * w);
        let mut s = [0.0_f32; 8];
        for i in 1..11 {
            s[i % 8] += moved[i] * x[i - 1];
        }
        let expected = ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
        let mut line = DelayLine::new();
        x.iter().rev().for_each(|x| {
            line.push(*x, 0, 11);
        });
        assert_eq!(pass(&mut w, &line, 11, |w, _| 0.5 * w).to_bits(), expected.to_bits());
        assert_eq!(w, moved);
    }

    /// The error is q − wᵀφ for the taps and the regressor as they stand, however the sample before was treated.
    #[test]
    fn the_prediction_is_that_of_the_present_taps() {
        let lms =
            LmsConfig { step: 0.7, input_delay: 1, taps: 19, ..LmsConfig::default() }.build::<19>().unwrap();
        let (mut state, mut seed) = (LmsState::default(), 3);
        for k in 0..500 {
            let expected: f32 =
                state.taps().iter().zip(state.line().regressor(19).unwrap()).map(|(w, x)| w * x).sum();
            if k % 7 != 3 {
                let error = lms.observe(&mut state, 1.0, k % 5 != 0).error;
                assert!((error - (1.0 - expected)).abs() < 1e-5, "{k}: {error} {expected}");
            }
            lms.push(&mut state, noise(&mut seed));
        }
    }
}
